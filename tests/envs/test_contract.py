"""What Gymnasium, Stable-Baselines3 and PettingZoo ask of an environment, and what they miss."""

import importlib.util
import warnings
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.wrappers import RecordEpisodeStatistics
from gymnasium.wrappers.vector import RecordEpisodeStatistics as RecordVectorStatistics
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.test import (
    api_test,
    max_cycles_test,
    parallel_api_test,
    parallel_seed_test,
    render_test,
    seed_test,
    state_test,
)

from coopenv import Transport
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, ResetNeeded, UnknownName
from tests.helpers import (
    CASE_NAMES,
    CASES,
    EASY_TASKS,
    IDS,
    NEVER,
    PARALLEL,
    TRIO,
    WIDE,
    actions,
    assert_same,
    constant,
    option,
    spoil,
)

EVERY_ID = pytest.mark.parametrize("view", IDS)
EVERY_MODULE = pytest.mark.parametrize("module", PARALLEL.values(), ids=PARALLEL)
EVERY_CASE = pytest.mark.parametrize(
    ("view", "keywords"), [(view, keywords) for view, _, keywords in CASES], ids=CASE_NAMES
)
EVERY_MODULES_CASE = pytest.mark.parametrize(
    ("module", "keywords"),
    [(PARALLEL[view], keywords) for view, _, keywords in CASES],
    ids=CASE_NAMES,
)
DRAWS = all(importlib.util.find_spec(name) for name in ("coopenv.render", "pygame"))

# Observations are in SI units without bounds, and a single block can be one number, at rest zero.
REMARKS = r"(minimum|maximum) (value|observation|state)|single number|all zeros|it has no effect"


@pytest.fixture(autouse=True)
def _no_other_warning(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", rf".*({REMARKS})")
        yield


def test_every_registered_id_is_tested():
    assert {name for name in gymnasium.registry if name.startswith("coopenv/")} == set(IDS)


@EVERY_CASE
def test_the_gymnasium_view_passes_gymnasiums_checker(view, keywords):
    env = gymnasium.make(view, disable_env_checker=True, **keywords)
    check_env(env.unwrapped, skip_render_check=not DRAWS)


@EVERY_CASE
def test_the_gymnasium_view_passes_stable_baselines_checker(view, keywords):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(view, **keywords), warn=True)


@EVERY_MODULES_CASE
def test_the_pettingzoo_views_pass_its_api_tests(module, keywords):
    cycles = 2 * keywords.get("horizon", 15)
    parallel_api_test(module.parallel_env(**keywords), num_cycles=cycles)
    api_test(module.env(**keywords), num_cycles=cycles)


@EVERY_MODULE
@pytest.mark.parametrize("name", ["defaults", "cluttered", "short horizon", "three agents"])
def test_the_pettingzoo_views_pass_its_seed_tests(module, name):
    keywords = option(next(view for view in IDS if PARALLEL[view] is module), name)
    seed_test(lambda: module.env(**keywords), num_cycles=20)
    parallel_seed_test(lambda: module.parallel_env(**keywords), num_cycles=20)


@EVERY_MODULE
def test_the_pettingzoo_views_pass_its_other_tests(module):
    max_cycles_test(module)
    state_test(module.env(), module.parallel_env())


@EVERY_MODULE
@pytest.mark.skipif(not DRAWS, reason="needs coopenv[render]")
def test_the_pettingzoo_views_pass_its_render_test(module):
    render_test(module.env)


@pytest.mark.parametrize(("view", "module"), PARALLEL.items(), ids=PARALLEL)
def test_views_are_what_the_ecosystem_takes_them_for(view, module):
    assert isinstance(gymnasium.make(view).unwrapped, gymnasium.Env)
    assert isinstance(gymnasium.make_vec(view, num_envs=2), VectorEnv)
    assert isinstance(module.parallel_env(), ParallelEnv)
    assert isinstance(module.env(), AECEnv)
    spec = gymnasium.spec(view)
    assert isinstance(spec.entry_point, str)  # a class would not survive JSON
    assert isinstance(spec.vector_entry_point, str)
    assert spec.max_episode_steps is None  # Gymnasium would put a time limit of its own outside
    for env in (gymnasium.make(view), gymnasium.make_vec(view), module.parallel_env()):
        assert isinstance(env.unwrapped.transport, Transport)  # pyright: ignore[reportAttributeAccessIssue]
        assert env.metadata["render_fps"] == 20
    assert isinstance(module.env().unwrapped.transport, Transport)
    name = module.__name__.rsplit(".", 1)[-1]
    assert module.parallel_env().metadata["name"] == name
    assert module.env().metadata["name"] == name


def check_observation(obs, space):
    assert (obs.shape, obs.dtype) == (space.shape, space.dtype)
    assert np.isfinite(obs).all()
    assert space.contains(obs)


def check_info(info, first):
    """Everything finite, of the names, types and shapes of ``first``, and flat."""
    assert list(info) == list(first)
    for name, value in info.items():
        assert isinstance(value, np.ndarray | float | bool | int), (name, type(value))
        assert np.isfinite(np.asarray(value, dtype=float)).all(), name
        assert type(value) is type(first[name]), name
        assert np.shape(value) == np.shape(first[name]), name
        assert np.asarray(value).dtype == np.asarray(first[name]).dtype, name


@EVERY_CASE
def test_single_results_are_finite_and_of_the_types_promised(view, keywords):
    env = gymnasium.make(view, **keywords)
    obs, first = env.reset(seed=0)
    check_observation(obs, env.observation_space)
    check_info(first, first)
    env.action_space.seed(1)
    for _ in range(min(20, keywords.get("horizon", 20))):
        obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
        check_observation(obs, env.observation_space)
        assert type(reward) is float
        assert np.isfinite(reward)
        assert (type(terminated), type(truncated)) == (bool, bool)
        check_info(info, first)
        assert sum(info["reward_terms"].values()) == pytest.approx(reward, abs=1e-12)
        if terminated or truncated:
            break


@EVERY_MODULES_CASE
def test_parallel_results_are_finite_and_of_the_types_promised(module, keywords):
    env = module.parallel_env(**keywords)
    obs, first = env.reset(seed=0)
    everyone = set(env.possible_agents)
    for i, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(i)
    for _ in range(min(20, keywords.get("horizon", 20))):
        plan = {agent: env.action_space(agent).sample() for agent in env.agents}
        obs, rewards, terminated, truncated, infos = env.step(plan)
        for given in (obs, rewards, terminated, truncated, infos):
            assert type(given) is dict
            assert set(given) == everyone
        for agent in everyone:
            check_observation(obs[agent], env.observation_space(agent))
            assert type(rewards[agent]) is float
            assert np.isfinite(rewards[agent])
            assert (type(terminated[agent]), type(truncated[agent])) == (bool, bool)
            check_info(infos[agent], first[agent])
            terms = infos[agent]["reward_terms"]
            assert sum(terms.values()) == pytest.approx(rewards[agent], abs=1e-12)
        check_observation(env.state(), env.state_space)
        if not env.agents:
            break


@EVERY_ID
@pytest.mark.parametrize("mode", list(AutoresetMode), ids=lambda mode: mode.name)
@pytest.mark.parametrize("name", ["every block", "short horizon", "reward balanced", "forces"])
def test_vector_results_are_finite_and_of_the_types_promised(view, mode, name):
    keywords = {"horizon": 8, **option(view, name)}
    env = gymnasium.make_vec(view, num_envs=3, autoreset_mode=mode, **keywords)
    obs, _ = env.reset(seed=0)
    env.action_space.seed(0)
    ended = np.zeros(3, dtype=bool)
    for _ in range(20):
        if mode is AutoresetMode.DISABLED and ended.any():
            obs, _ = env.reset(options={"reset_mask": ended})
        obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
        check_observation(obs, env.observation_space)
        assert (reward.shape, reward.dtype) == ((3,), np.float64)
        assert np.isfinite(reward).all()
        for end in (terminated, truncated):
            assert (end.shape, end.dtype) == ((3,), np.bool_)
        for key in info:
            if not key.startswith("_"):
                assert info[f"_{key}"].dtype == np.bool_, key
        ended = terminated | truncated


@EVERY_ID
@pytest.mark.parametrize("name", ["defaults", "every block", "three agents"])
def test_no_observation_is_constant(view, name):
    wide = replace(WIDE, length=(0.9, 1.0)) if "Walker" in view else WIDE
    if "Lift" in view:  # else nothing leaves the floor
        wide = replace(WIDE, force_limit=(90.0, 120.0))
    env = gymnasium.make_vec(view, num_envs=6, horizon=20, randomise=wide, **option(view, name))
    core = env.unwrapped.transport  # pyright: ignore[reportAttributeAccessIssue]
    env.action_space.seed(0)
    seen = [env.reset(seed=0)[0]]
    seen += [env.step(env.action_space.sample())[0] for _ in range(45)]
    rows = np.concatenate(seen).reshape(-1, core.num_agents, core.observation.size)
    nothing_near = (rows == core.observation.high).all(axis=0)  # a range beyond its reach
    dull = (rows.std(axis=0) <= 1e-3) & ~nothing_near & ~without_news(core)
    found = [
        (name, np.argwhere(dull[:, where]).tolist())
        for name, where in core.observation.blocks.items()
        if dull[:, where].any()
    ]
    assert not found


def without_news(core):
    """Features ``(agent, feature)`` that are constant by right."""
    blocks, told = core.observation.blocks, core.conditions.told[0]
    quiet = np.zeros((core.num_agents, core.observation.size), dtype=bool)
    if "known" in blocks:  # what this team is told never changes
        quiet[:, blocks["known"]] = True
    if "place" in blocks:  # nor does who holds it where
        quiet[:, blocks["place"]] = True
    for name in ("goal", "near_goal"):
        if name in blocks:
            quiet[~told.any(axis=1), blocks[name]] = True
    if "twist" in blocks and core.bodies[0].nonholonomic:  # no sideways velocity
        quiet[:, blocks["twist"].start + 1] = True
    if "own_motion" in blocks and core.bodies[0].nonholonomic:  # nor at the wheels' own axle
        quiet[~core.team.grips[0].any(axis=-1), blocks["own_motion"].start + 1] = True
    if "body" in blocks:  # a grip at the centre of mass stays there
        first, central = blocks["body"].start, ~core.team.grips[0].any(axis=-1)
        quiet[central, first + 6] = True
        for i in np.flatnonzero(central):
            for other in range(1, core.num_agents):
                place = first + 9 + 4 * (other - 1)
                quiet[(i - other) % core.num_agents, place : place + 2] = True
    return quiet


@EVERY_ID
def test_nothing_that_the_single_view_returns_is_shared_with_it(view):
    clean, soiled = (
        gymnasium.make(view, task=EASY_TASKS[view], horizon=7, reward="balanced") for _ in "ab"
    )
    assert_same(clean.reset(seed=0), first := soiled.reset(seed=0))
    spoil(first)
    for action in actions(0, 40, *constant(clean).shape).astype(np.float32):
        given = action.copy()
        mine, theirs = clean.step(action), soiled.step(given)
        assert_same(mine, theirs)
        spoil((given, theirs))
        if mine[2] or mine[3]:
            assert_same(clean.reset(), again := soiled.reset())
            spoil(again)


@EVERY_MODULE
def test_nothing_that_the_parallel_view_returns_is_shared_with_it(module):
    task = EASY_TASKS[next(view for view in IDS if PARALLEL[view] is module)]
    clean, soiled = (module.parallel_env(task=task, horizon=7, reward="balanced") for _ in "ab")
    assert_same(clean.reset(seed=0), first := soiled.reset(seed=0))
    spoil(first)
    count, size = len(clean.possible_agents), clean.action_space("agent_0").shape[0]
    for action in actions(0, 40, count, size).astype(np.float32):
        plan = dict(zip(clean.possible_agents, action, strict=True))
        given = {agent: row.copy() for agent, row in plan.items()}
        mine, theirs = clean.step(plan), soiled.step(given)
        assert_same(mine, theirs)
        spoil((given, theirs))
        np.testing.assert_array_equal(clean.state(), kept := soiled.state())
        kept[:] = 0
        np.testing.assert_array_equal(clean.state(), soiled.state())
        if not clean.agents:
            assert_same(clean.reset(), again := soiled.reset())
            spoil(again)


@EVERY_ID
@pytest.mark.parametrize("mode", list(AutoresetMode), ids=lambda mode: mode.name)
def test_nothing_that_the_vector_view_returns_is_shared_with_it(view, mode):
    keywords = {
        "task": EASY_TASKS[view],
        "horizon": 7,
        "reward": "balanced",
        "autoreset_mode": mode,
    }
    clean, soiled = (gymnasium.make_vec(view, num_envs=3, **keywords) for _ in "ab")
    assert_same(clean.reset(seed=0), first := soiled.reset(seed=0))
    spoil(first)
    for action in actions(0, 24, *constant(clean).shape).astype(np.float32):
        given = action.copy()
        mine, theirs = clean.step(action), soiled.step(given)
        assert_same(mine, theirs)
        ended = mine[2] | mine[3]
        spoil((given, theirs))
        if mode is AutoresetMode.DISABLED and ended.any():
            options, same = {"reset_mask": ended.copy()}, {"reset_mask": ended.copy()}
            assert_same(clean.reset(options=options), again := soiled.reset(options=same))
            np.testing.assert_array_equal(same["reset_mask"], ended)
            spoil((again, same))


@EVERY_MODULE
def test_the_spaces_are_always_the_same_objects(module):
    env = module.parallel_env(body=TRIO)
    for agent in env.possible_agents:
        assert env.observation_space(agent) is env.observation_spaces[agent]
        assert env.action_space(agent) is env.action_spaces[agent]
    assert set(env.observation_spaces) == set(env.action_spaces) == set(env.possible_agents)


@EVERY_MODULE
def test_emptying_the_list_of_agents_leaves_the_possible_ones(module):
    env = module.parallel_env()
    env.reset(seed=0)
    env.agents.clear()
    count = env.unwrapped.transport.num_agents
    assert env.possible_agents == [f"agent_{i}" for i in range(count)]
    env.reset(seed=0)
    assert env.agents == env.possible_agents


@EVERY_ID
def test_observation_blocks_name_the_parts_of_what_one_agent_sees(view):
    env = gymnasium.make(view, observe=("time", "goal"), horizon=10)
    blocks = env.unwrapped.observation_blocks  # pyright: ignore[reportAttributeAccessIssue]
    assert blocks == {"time": slice(0, 1), "goal": slice(1, 5)}
    env.reset(seed=0)
    obs, *_ = env.step(env.action_space.sample())
    np.testing.assert_allclose(obs.reshape(-1, 5)[:, blocks["time"]], 0.9, rtol=1e-6)


@EVERY_ID
@pytest.mark.parametrize("steps", [3, 300])
def test_the_horizon_is_kept_in_every_view(view, steps):
    module = PARALLEL[view]
    env = gymnasium.make(view, horizon=steps, task=NEVER)
    env.reset(seed=0)
    still = constant(env)
    ends = [env.step(still)[2:4] for _ in range(steps)]
    assert ends == [(False, False)] * (steps - 1) + [(False, True)]
    parallel = module.parallel_env(max_cycles=steps, task=NEVER)
    parallel.reset(seed=0)
    plan = {agent: np.zeros(space.shape) for agent, space in parallel.action_spaces.items()}
    stops = [parallel.step(plan)[3]["agent_0"] for _ in range(steps)]
    assert stops == [False] * (steps - 1) + [True]
    assert not parallel.agents


@EVERY_ID
@pytest.mark.parametrize("steps", [3, 300])
def test_gymnasiums_episode_limit_is_the_horizon_of_a_vector(view, steps):
    env = gymnasium.make_vec(view, num_envs=2, max_episode_steps=steps, horizon=77, task=NEVER)
    assert env.unwrapped.transport.horizon == steps  # pyright: ignore[reportAttributeAccessIssue]
    env.reset(seed=0)
    still = constant(env)
    stops = np.array([env.step(still)[3] for _ in range(steps)])
    assert not stops[:-1].any()
    assert stops[-1].all()


@EVERY_ID
def test_gymnasiums_time_limit_is_the_horizon_of_a_single_environment(view):
    early: Any = gymnasium.make(view, max_episode_steps=3, task=NEVER)
    late: Any = gymnasium.make(view, max_episode_steps=30, horizon=20, task=NEVER)
    again: Any = gymnasium.make(late.spec)
    for env, steps in ((early, 3), (late, 30), (again, 30)):
        assert env.unwrapped.transport.horizon == steps
        assert env.spec.max_episode_steps == steps
        env.reset(seed=0)
        still = constant(env)
        stops = [env.step(still)[3] for _ in range(steps)]
        assert stops == [False] * (steps - 1) + [True]


class Around(gymnasium.Env):
    """An environment of somebody's own with one of ours inside."""

    def __init__(self, view: str):
        self.inner = PARALLEL[view].single_env(horizon=31)
        self.observation_space = self.inner.observation_space
        self.action_space = self.inner.action_space


@EVERY_ID
def test_the_horizon_can_be_read_where_tools_look_for_it(view):
    made: Any = gymnasium.make(view, horizon=31), gymnasium.make_vec(view, horizon=31)
    for env in made:
        assert env.spec.max_episode_steps == 31
        assert env.unwrapped._max_episode_steps == 31
        assert "TimeLimit" not in str(env)
    gymnasium.register("tests/Around-v0", lambda **_: Around(view), max_episode_steps=3)
    try:
        around: Any = gymnasium.make("tests/Around-v0")
        assert around.unwrapped.inner.unwrapped.transport.horizon == 31  # the 3 are of another's
    finally:
        del gymnasium.registry["tests/Around-v0"]
    unlimited: Any = gymnasium.make(view, max_episode_steps=-1, horizon=31)
    assert unlimited.unwrapped.transport.horizon == 31


def test_a_horizon_that_a_specifications_limit_would_cut_is_refused():
    spec: Any = gymnasium.make(IDS[0], horizon=31).spec
    longer: Any = gymnasium.make(spec, max_episode_steps=50)
    assert longer.unwrapped.transport.horizon == 50
    with pytest.raises(InvalidInput, match="horizon must be given as max_episode_steps"):
        gymnasium.make(spec, horizon=50)


@EVERY_ID
def test_without_a_render_mode_there_are_no_pictures(view):
    for env in (gymnasium.make_vec(view, num_envs=2), gymnasium.make(view)):
        plain: Any = env.unwrapped
        plain.reset(seed=0)
        assert plain.render_mode is None
        assert plain.render() is None


@EVERY_ID
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_vector_collects_pictures_as_gymnasiums_own_over_single_ones(view, mode):
    keywords = {"horizon": 3, "task": NEVER, "render_mode": "rgb_array_list"}
    ours: Any = gymnasium.make_vec(view, num_envs=2, autoreset_mode=mode, **keywords)
    theirs: Any = SyncVectorEnv(
        [lambda: gymnasium.make(view, **keywords) for _ in range(2)],
        autoreset_mode=AutoresetMode(mode),
    )
    still = constant(ours, 0.5)
    for envs in (ours, theirs):
        envs.reset(seed=0)
    for _ in range(2):
        for _ in range(5):
            ours.step(still)
            theirs.step(still)
        for mine, wanted in zip(ours.render(), theirs.render(), strict=True):
            assert len(mine) == len(wanted) > 0
            for got, want in zip(mine, wanted, strict=True):
                np.testing.assert_array_equal(got, want)


@EVERY_ID
def test_gymnasiums_statistics_count_whole_episodes(view):
    env = RecordEpisodeStatistics(gymnasium.make(view, horizon=9, task=NEVER))
    env.reset(seed=0)
    push = constant(env, 0.1)
    rewards = [env.step(push) for _ in range(9)]
    episode = rewards[-1][4]["episode"]
    assert episode["l"] == 9
    assert episode["r"] == pytest.approx(sum(float(step[1]) for step in rewards))
    vector = RecordVectorStatistics(gymnasium.make_vec(view, num_envs=2, horizon=9, task=NEVER))
    vector.reset(seed=0)
    steps = [vector.step(np.tile(push, (2, 1))) for _ in range(9)]
    assert steps[-1][4]["episode"]["l"].tolist() == [9, 9]


@EVERY_ID
def test_a_reset_starts_where_it_is_told(view):
    start = {"pose": (-1.5, -0.5, 1.0), "goal": (-1.0, 1.0, 0.0)}
    if find_config(view, {}).task.moves:
        del start["goal"]  # it has one of its own
    single, vector = gymnasium.make(view), gymnasium.make_vec(view, num_envs=3)
    parallel = PARALLEL[view].parallel_env()
    for env in (single, vector, parallel):
        env.reset(seed=0, options=start)
        state = env.unwrapped.transport.transition.next_state  # pyright: ignore[reportAttributeAccessIssue]
        np.testing.assert_allclose(state.pose, [start["pose"]] * len(state.pose))
        if "goal" in start:
            np.testing.assert_allclose(state.goal, [start["goal"]] * len(state.goal))


@EVERY_ID
def test_an_unknown_reset_option_warns(view):
    with pytest.warns(UserWarning, match=r"reset options must be among .* got 'poes'"):
        gymnasium.make(view).reset(options={"poes": (0, 0, 0)})


@EVERY_ID
def test_a_joint_action_of_another_shape_is_refused(view):
    env = gymnasium.make(view).unwrapped
    env.reset(seed=0)
    (size,) = env.action_space.shape  # pyright: ignore[reportGeneralTypeIssues]
    for shape in ((size - 1,), (size // 3, 3), (1, size), (3, size // 3), (size + 2,), ()):
        with pytest.raises(InvalidInput, match=rf"action must have shape \({size},\), got"):
            env.step(np.zeros(shape))


@EVERY_ID
def test_a_vector_action_of_another_shape_is_refused(view):
    env = gymnasium.make_vec(view, num_envs=3)
    env.reset(seed=0)
    size = env.action_space.shape[1]  # pyright: ignore[reportOptionalSubscript]
    for shape in ((size, 3), (3 * size,), (3, size // 3, 3), (3, size - 1), (2, size)):
        with pytest.raises(InvalidInput, match=rf"action must have shape \(3, {size}\), got"):
            env.step(np.zeros(shape, dtype=np.float32))


@EVERY_MODULE
def test_wrong_actions_of_agents_are_refused_and_move_nothing(module):
    env, twin = module.parallel_env(), module.parallel_env()
    env.reset(seed=0)
    twin.reset(seed=0)
    good = {agent: np.ones(space.shape, np.float32) for agent, space in env.action_spaces.items()}
    last, size = env.possible_agents[-1], env.action_space("agent_0").shape[0]
    entries, shape = r"actions must have one entry for each of \['agent_0'", r"\] must have shape"
    for plan, said in (
        ({}, entries + r".*\], got \[\]"),
        ({agent: row for agent, row in good.items() if agent != last}, entries),
        ({**good, f"agent_{len(good)}": np.zeros(size)}, entries),
        ({**good, last: np.zeros(size - 1)}, rf"actions\['{last}'{shape}"),
        ({**good, last: None}, rf"actions\['{last}'\] must be an array of numbers"),
        ({**good, "agent_0": np.full(size, np.nan)}, r"actions\['agent_0'\] must be finite"),
    ):
        with pytest.raises(InvalidInput, match=said):
            env.step(plan)
    assert_same(env.step(good), twin.step(good))


@EVERY_ID
def test_a_nan_action_is_refused_by_the_gymnasium_views_and_moves_nothing(view):
    for make in (
        lambda: gymnasium.make(view, disable_env_checker=True),
        lambda: gymnasium.make_vec(view, num_envs=2),
    ):
        env, twin = make(), make()
        shape = constant(env).shape
        assert_same(env.reset(seed=0), twin.reset(seed=0))
        with pytest.raises(InvalidInput, match=r"action.* must be finite, got nan"):
            env.step(np.full(shape, np.nan, dtype=np.float32))
        action = np.ones(shape, dtype=np.float32)
        assert_same(env.step(action), twin.step(action))


@EVERY_ID
def test_a_step_out_of_turn_is_refused_in_every_view(view):
    module = PARALLEL[view]
    single = gymnasium.make(view, horizon=1).unwrapped
    vector = gymnasium.make_vec(view, num_envs=2, horizon=1, autoreset_mode="Disabled")
    parallel = module.parallel_env(horizon=1)
    plan = {agent: np.zeros(space.shape) for agent, space in parallel.action_spaces.items()}
    still = constant(single)
    for env, action in ((single, still), (vector, np.tile(still, (2, 1))), (parallel, plan)):
        with pytest.raises(ResetNeeded, match="reset must be called before"):
            env.step(action)
        env.reset(seed=0)
        env.step(action)
        with pytest.raises(ResetNeeded, match="must be"):
            env.step(action)


@EVERY_ID
@pytest.mark.parametrize("mode", ["humann", "rgb", 3])
def test_an_unknown_render_mode_is_refused(view, mode):
    for make in (
        lambda: gymnasium.make_vec(view, num_envs=2, render_mode=mode),
        lambda: PARALLEL[view].parallel_env(render_mode=mode),
        lambda: PARALLEL[view].env(render_mode=mode),
    ):
        with pytest.raises(UnknownName, match="render_mode must be one of the known names"):
            make()


@EVERY_ID
def test_a_vector_has_no_window(view):
    with pytest.raises(UnknownName, match=r"render_mode must .* known: rgb_array"):
        gymnasium.make_vec(view, num_envs=2, render_mode="human")


@EVERY_ID
def test_an_unknown_autoreset_mode_is_refused(view):
    with pytest.raises(UnknownName, match=r"autoreset_mode must .* did you mean 'NextStep'"):
        gymnasium.make_vec(view, num_envs=2, autoreset_mode="next_step")


@EVERY_ID
@pytest.mark.parametrize("count", [0, 1.5, "two"])
def test_a_wrong_number_of_environments_is_refused(view, count):
    with pytest.raises(InvalidInput, match="num_worlds must be"):
        gymnasium.make_vec(view, num_envs=count)


@EVERY_ID
def test_a_wrong_mask_or_seed_is_refused_by_the_vector(view):
    env = gymnasium.make_vec(view, num_envs=3)
    env.reset(seed=0)
    with pytest.raises(InvalidInput, match="mask must be 3 booleans"):
        env.reset(options={"reset_mask": np.array([1, 0, 1])})
    with pytest.raises(InvalidInput, match="seed must be one number or one for each of 3"):
        env.reset(seed=[1, 2])  # pyright: ignore[reportArgumentType]


@EVERY_ID
def test_closing_twice_is_no_error(view):
    for env in (
        gymnasium.make(view),
        gymnasium.make_vec(view, num_envs=2),
        PARALLEL[view].parallel_env(),
    ):
        env.reset(seed=0)
        env.close()
        env.close()
