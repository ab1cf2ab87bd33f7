"""Every view shows the same episodes: the core, Gymnasium, its vectors, PettingZoo's two."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv

from coopenv import Transport
from coopenv.envs.registry import find_config
from coopenv.info import TRIPLES
from tests.helpers import (
    ALONG,
    CLUTTERED,
    EASY_TASKS,
    IDS,
    OPEN_ROOM,
    PARALLEL,
    TRIO,
    actions,
    assert_same,
    constant,
    option,
    parallel_actions,
    room,
)

AGREEING = [
    "defaults",
    "forces",
    "every block",
    "reward balanced",
    "own sum",
    "decompose moore_penrose",
    "fine steps",
    "cluttered",
    "uneven limits",
    "one agent",
    "three agents",
    "plate of four",
    "randomised",
    "drawn actuators",
]


PAIRS = [  # the ids after the first differ in their tasks only
    (view, name)
    for view in IDS
    for name in (AGREEING if view == IDS[0] else ("defaults", "cluttered", "three agents"))
]
EVERY_PAIR = pytest.mark.parametrize(("view", "name"), PAIRS)


def agent_info(info, i):
    """Agent ``i``'s part of one world of the core's info, as a view gives it."""
    own = {}
    for name, value in info.items():
        value = value[0]
        of_world = np.ndim(value) == 0 or name in TRIPLES
        own[name] = value if of_world else value[i]
    return own


def episode(view, name):
    """A core of one world, its first observation, and every step under random actions."""
    core = Transport(config=find_config(view, {"horizon": 30, **option(view, name)}))
    first, steps = core.reset(seed=40), []
    for action in actions(0, core.horizon, 1, core.num_agents, core.action_size).astype(np.float32):
        steps.append((action[0], *core.step(action)))
        if steps[-1][3][0] or steps[-1][4][0]:
            break
    return core, first, steps


def joint(array):
    return np.asarray(array).reshape(-1)


@EVERY_PAIR
def test_the_gymnasium_view_shows_the_core_to_the_bit(view, name):
    _, first, steps = episode(view, name)
    env = gymnasium.make(view, **{"horizon": 30, **option(view, name)})
    obs, info = env.reset(seed=40)
    np.testing.assert_array_equal(obs, joint(first[0]), strict=True)
    assert list(info) == list(first[1])
    for action, seen, reward, terminated, truncated, told in steps:
        obs, mean, *ends, info = env.step(joint(action))
        np.testing.assert_array_equal(obs, joint(seen), strict=True)
        assert mean == reward[0].mean()
        assert ends == [bool(terminated[0]), bool(truncated[0])]
        for key, value in told.items():
            wanted = value[0].mean() if key.startswith("reward/") else value[0]
            np.testing.assert_array_equal(info[key], wanted, err_msg=key)
        assert list(info) == list(told)


@EVERY_PAIR
def test_the_parallel_view_shows_the_core_to_the_bit(view, name):
    core, first, steps = episode(view, name)
    env = PARALLEL[view].parallel_env(**{"horizon": 30, **option(view, name)})
    assert env.possible_agents == [f"agent_{i}" for i in range(core.num_agents)]
    obs, info = env.reset(seed=40)
    for i, agent in enumerate(env.possible_agents):
        np.testing.assert_array_equal(obs[agent], first[0][0, i], strict=True)
        assert_same(info[agent], agent_info(first[1], i))
    for action, seen, reward, terminated, truncated, told in steps:
        obs, rewards, ends, stops, info = env.step(parallel_actions(env, action))
        for i, agent in enumerate(env.possible_agents):
            np.testing.assert_array_equal(obs[agent], seen[0, i], strict=True)
            assert rewards[agent] == reward[0, i]
            assert (ends[agent], stops[agent]) == (bool(terminated[0]), bool(truncated[0]))
            assert_same(info[agent], agent_info(told, i))
        np.testing.assert_array_equal(env.state(), joint(seen), strict=True)
    assert env.agents == []


@EVERY_PAIR
def test_the_turn_taking_view_shows_the_parallel_one_to_the_bit(view, name):
    module, keywords = PARALLEL[view], {"horizon": 30, **option(view, name)}
    parallel, turns = module.parallel_env(**keywords), module.env(**keywords)
    obs, info = parallel.reset(seed=40)
    turns.reset(seed=40)
    rewards, ends, stops = {}, {}, {}
    count = parallel.transport.num_agents
    for action in actions(0, 30, count, parallel.transport.action_size).astype(np.float32):
        for i, agent in enumerate(parallel.possible_agents):
            assert turns.agent_selection == agent
            seen, reward, ended, stopped, told = turns.last()
            np.testing.assert_array_equal(seen, obs[agent], strict=True)
            assert reward == rewards.get(agent, 0)
            assert (ended, stopped) == (ends.get(agent, False), stops.get(agent, False))
            assert_same(told, info[agent])
            turns.step(action[i])
        obs, rewards, ends, stops, info = parallel.step(parallel_actions(parallel, action))
        if not parallel.agents:
            break
    assert parallel.agents == []
    for agent in parallel.possible_agents:
        np.testing.assert_array_equal(turns.observe(agent), obs[agent])
        assert (turns.terminations[agent], turns.truncations[agent]) == (ends[agent], stops[agent])
        assert_same(turns.infos[agent], info[agent])


@EVERY_PAIR
def test_the_vector_view_shows_the_core_to_the_bit(view, name):
    keywords = {"horizon": 12, "task": EASY_TASKS[view], **option(view, name)}
    core = Transport(num_worlds=3, config=find_config(view, keywords))
    env = gymnasium.make_vec(view, num_envs=3, autoreset_mode="Disabled", **keywords)
    mask = None
    plan = actions(1, 25, 3, core.num_agents, core.action_size).astype(np.float32)
    for action in plan:
        if mask is None or mask.any():
            obs, _ = core.reset(seed=40 if mask is None else None, mask=mask)
            options = None if mask is None else {"reset_mask": mask}
            seen, _ = env.reset(seed=40 if mask is None else None, options=options)
            np.testing.assert_array_equal(seen, obs.reshape(3, -1), strict=True)
        obs, reward, terminated, truncated, info = core.step(action)
        seen, mean, ended, stopped, told = env.step(action.reshape(3, -1))
        np.testing.assert_array_equal(seen, obs.reshape(3, -1), strict=True)
        np.testing.assert_array_equal(mean, reward.mean(axis=1), strict=True)
        np.testing.assert_array_equal(ended, terminated, strict=True)
        np.testing.assert_array_equal(stopped, truncated, strict=True)
        for key, value in info.items():
            wanted = value.mean(axis=1) if key.startswith("reward/") else value
            np.testing.assert_array_equal(told[key], wanted, err_msg=key)
        mask = terminated | truncated


def assert_same_infos(ours, theirs, count, within):
    """Raise unless two vector infos say the same of the same environments."""
    masks = {name for name in {*ours, *theirs} if f"_{name}" not in {*ours, *theirs}}
    for name in {*ours, *theirs} - masks:
        nowhere = np.zeros(count, dtype=bool)
        has, had = ours.get(f"_{name}", nowhere), theirs.get(f"_{name}", nowhere)
        np.testing.assert_array_equal(has, had, err_msg=f"_{name}", strict=True)
        if not had.any():
            continue
        mine, wanted = ours[name], theirs[name]
        if isinstance(wanted, dict):
            assert_same_infos(mine, wanted, count, within)
        elif wanted.dtype == object:
            assert [entry is None for entry in mine] == [entry is None for entry in wanted]
            for k in np.flatnonzero(had):
                np.testing.assert_allclose(mine[k], wanted[k], rtol=0, atol=within)
        else:
            assert (mine.dtype, mine.shape) == (wanted.dtype, wanted.shape), name
            np.testing.assert_allclose(mine[had], wanted[had], rtol=0, atol=within, err_msg=name)


VECTORED = {
    "balanced": {"reward": "balanced"},
    "blocks": {"reward": "harmony", "observe": ("goal", "twist", "load_share", "time")},
    "cluttered": {"scene": CLUTTERED, "action": "force"},
    "three": {"body": TRIO},
    "randomised": {"randomise": ALONG, "observe": ("goal", "body")},
}


MODES = list(AutoresetMode)


@pytest.mark.parametrize(
    ("view", "name", "mode"),
    [
        *((IDS[0], name, mode) for name in VECTORED for mode in MODES),
        *((view, "own task", MODES[k % len(MODES)]) for k, view in enumerate(IDS[1:])),
    ],
)
def test_the_vector_view_behaves_as_gymnasiums_own_over_single_ones(view, name, mode):
    count, within = 4, 1e-5  # float32 observations of up to 100 m
    keywords = {"horizon": 9, "task": EASY_TASKS[view], **VECTORED.get(name, {})}
    ours = gymnasium.make_vec(view, num_envs=count, autoreset_mode=mode, **keywords)
    theirs = SyncVectorEnv(
        [lambda: gymnasium.make(view, **keywords) for _ in range(count)], autoreset_mode=mode
    )
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"] == mode
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.single_action_space == theirs.single_action_space
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space

    def compare(mine, wanted):
        for got, want in zip(mine[:-1], wanted[:-1], strict=True):
            assert (got.dtype, got.shape) == (want.dtype, want.shape)
            np.testing.assert_allclose(got, want, rtol=0, atol=within)
        assert_same_infos(mine[-1], wanted[-1], count, within)

    compare(ours.reset(seed=11), theirs.reset(seed=11))
    ours.action_space.seed(3)
    ended = np.zeros(count, dtype=bool)
    ends = {"terminated": 0, "truncated": 0}
    for step in range(60):
        if mode is AutoresetMode.DISABLED and ended.any():
            compare(
                ours.reset(options={"reset_mask": ended.copy()}),
                theirs.reset(options={"reset_mask": ended.copy()}),
            )
        action = ours.action_space.sample()
        mine, wanted = ours.step(action), theirs.step(action)
        compare(mine, wanted)
        ended = wanted[2] | wanted[3]
        ends["terminated"] += wanted[2].sum()
        ends["truncated"] += wanted[3].sum()
        if step == 40:  # in mid-history everything starts again
            compare(ours.reset(seed=5), theirs.reset(seed=5))
            ended[:] = False
    assert ends["terminated"] > 2
    assert ends["truncated"] > 2


@pytest.mark.parametrize("view", IDS)
def test_vector_world_k_goes_on_through_autoresets_as_the_single_one_does(view):
    keywords = {"horizon": 6, "scene": room(view, OPEN_ROOM)}
    vector = gymnasium.make_vec(view, num_envs=3, autoreset_mode="SameStep", **keywords)
    singles = [gymnasium.make(view, **keywords) for _ in range(3)]
    still = constant(vector)
    seen = [vector.reset(seed=20)[0], *(vector.step(still)[0] for _ in range(18))]
    for k, single in enumerate(singles):
        np.testing.assert_array_equal(seen[0][k], single.reset(seed=20 + k)[0])
        for start in (6, 12, 18):  # an episode of six steps
            np.testing.assert_array_equal(seen[start][k], single.reset()[0])


@pytest.mark.parametrize("view", IDS)
def test_gymnasiums_worker_processes_take_the_environment(view):
    keywords = {"scene": room(view, CLUTTERED), "reward": "harmony", "horizon": 4}
    workers = AsyncVectorEnv([lambda: gymnasium.make(view, **keywords) for _ in range(2)])
    try:
        near = SyncVectorEnv([lambda: gymnasium.make(view, **keywords) for _ in range(2)])
        np.testing.assert_array_equal(workers.reset(seed=1)[0], near.reset(seed=1)[0])
        workers.action_space.seed(0)
        for _ in range(6):
            action = workers.action_space.sample()
            mine, wanted = workers.step(action), near.step(action)
            for got, want in zip(mine[:-1], wanted[:-1], strict=True):
                np.testing.assert_array_equal(got, want)
    finally:
        workers.close()
