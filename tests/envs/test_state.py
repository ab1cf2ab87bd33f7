"""Every view keeps its state, takes it back, and is pickled and copied with episodes under way."""

import copy
import pickle
from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest

from coopenv import Transport
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import IDS, LEVEL, PARALLEL, actions, assert_same, parallel_actions

HORIZON = 14  # so that an episode ends in the middle of a ride
KEYWORDS: dict[str, Any] = {"horizon": HORIZON, "partner": "noisy"}
AGAIN: dict[str, Callable[[Any], Any]] = {
    "pickled": lambda one: pickle.loads(pickle.dumps(one)),
    "copied deep": copy.deepcopy,
}


def single(env: Any, plan: np.ndarray) -> list[Any]:
    seen = []
    for action in plan:
        seen.append(env.step(action[0].reshape(-1)))
        if seen[-1][2] or seen[-1][3]:
            seen.append(env.reset())
    return seen


def vector(env: Any, plan: np.ndarray) -> list[Any]:
    return [env.step(action.reshape(2, -1)) for action in plan]


def parallel(env: Any, plan: np.ndarray) -> list[Any]:
    seen = []
    for action in plan:
        if not env.agents:
            seen.append((env.reset(), env.agents))
        seen.append((env.step(parallel_actions(env, action[0])), env.state(), list(env.agents)))
    return seen


def turns(env: Any, plan: np.ndarray) -> list[Any]:
    """An odd number of turns of two agents ends in the middle of a round."""
    seen = []
    for action in plan[:, 0, 0]:
        if not env.agents:
            env.reset()
        agent = env.agent_selection
        seen.append((env.last(), agent, dict(env.rewards)))
        env.step(None if env.terminations[agent] or env.truncations[agent] else action)
    return seen


def rows(venv: Any, plan: np.ndarray) -> list[Any]:
    seen = []
    for action in plan:
        obs, reward, done, infos = venv.step(action.reshape(2, -1))
        for info in infos:
            info.get("episode", {}).pop("t", None)
        seen.append((obs, reward, done, infos))
    return seen


def vec_env(view: str) -> Any:
    pytest.importorskip("stable_baselines3")
    from coopenv.agents import sb3

    return sb3.make_vec_env(view, 2, **KEYWORDS)


class View(NamedTuple):
    """How to make a view of an id, how to step it, and how many steps its episode takes."""

    make: Callable[[str], Any]
    ride: Callable[[Any, np.ndarray], list[Any]]
    length: int = HORIZON


VIEWS = {
    "gymnasium": View(lambda view: gymnasium.make(view, **KEYWORDS), single),
    "NextStep": View(lambda view: gymnasium.make_vec(view, 2, **KEYWORDS), vector),
    "SameStep": View(
        lambda view: gymnasium.make_vec(view, 2, autoreset_mode="SameStep", **KEYWORDS), vector
    ),
    "parallel": View(lambda view: PARALLEL[view].parallel_env(**KEYWORDS), parallel),
    "aec": View(lambda view: PARALLEL[view].env(horizon=HORIZON), turns, 2 * HORIZON),
    "vec_env": View(vec_env, rows),
}
EVERY_VIEW = pytest.mark.parametrize("kind", VIEWS)


def plan_of(kind: str, view: str, steps: int, seed: int) -> np.ndarray:
    """Actions of two worlds, so gentle that nothing is touched."""
    core = Transport(config=find_config(view, {} if kind == "aec" else KEYWORDS))
    shape = steps, 2, len(core.learners), core.action_size
    return (0.3 * actions(seed, *shape)).astype(np.float32)


def begun(kind: str, view: str, steps: int) -> Any:
    """An environment some steps into its first episode."""
    env = VIEWS[kind].make(view)
    if kind == "vec_env":
        env.seed(3)
        env.reset()
    else:
        env.reset(seed=3)
    VIEWS[kind].ride(env, plan_of(kind, view, steps, 1))
    return env


def keeper(kind: str, env: Any) -> Any:
    """Whose ``get_state`` and ``set_state`` they are."""
    return env if kind in ("aec", "vec_env") else env.unwrapped


@EVERY_VIEW
@pytest.mark.parametrize("end", [False, True])
def test_a_view_goes_on_from_its_state_to_the_same_bits(kind, end):
    view = VIEWS[kind]
    env = begun(kind, IDS[0], view.length if end else 5)
    plan = plan_of(kind, IDS[0], 2 * view.length, 2)
    state = keeper(kind, env).get_state()
    first = view.ride(env, plan)
    keeper(kind, env).set_state(state)
    assert_same(view.ride(env, plan), first)
    other = begun(kind, IDS[0], 2)
    keeper(kind, other).set_state(state)
    assert_same(view.ride(other, plan), first)


@EVERY_VIEW
@pytest.mark.parametrize("view", LEVEL)
@pytest.mark.parametrize("again", AGAIN)
def test_a_view_is_copied_within_an_episode_and_goes_on_to_the_same_bits(kind, view, again):
    env, plan = begun(kind, view, 5), plan_of(kind, view, 2 * HORIZON, 2)
    twin = AGAIN[again](env)
    assert_same(VIEWS[kind].ride(twin, plan), VIEWS[kind].ride(env, plan))


@EVERY_VIEW
@pytest.mark.parametrize("steps", [0, HORIZON])
def test_a_view_is_copied_right_after_its_reset_and_at_the_end(kind, steps):
    env, plan = begun(kind, IDS[1], steps), plan_of(kind, IDS[1], HORIZON, 2)
    twin = AGAIN["pickled"](env)
    assert_same(VIEWS[kind].ride(twin, plan), VIEWS[kind].ride(env, plan))


@pytest.mark.parametrize("kind", ["gymnasium", "parallel", "NextStep"])
def test_a_state_goes_from_view_to_view(kind):
    core = Transport(config=find_config(IDS[0], KEYWORDS))
    core.reset(seed=8)
    state, plan = core.get_state(), plan_of(kind, IDS[0], 8, 2)
    env = begun(kind, IDS[0], HORIZON)
    obs, _ = keeper(kind, env).set_state(state)
    seen = obs["agent_0"] if kind == "parallel" else np.ravel(obs)[: core.observation.size]
    np.testing.assert_array_equal(seen, state.parts["obs"][0, 0])
    VIEWS[kind].ride(env, np.repeat(plan[:, :1], 2, axis=1))
    for action in plan:
        core.step(action[:1])
    pose = env.unwrapped.transport.world.pose
    np.testing.assert_allclose(pose, np.repeat(core.world.pose, len(pose), 0), rtol=0, atol=1e-9)
    state = keeper(kind, env).get_state()
    core.set_state(state.take([0]))
    np.testing.assert_array_equal(core.world.pose[0], pose[0])


def test_the_parallel_view_has_nobody_left_where_the_episode_had_ended():
    env, other = (begun("parallel", IDS[0], steps) for steps in (HORIZON, 3))
    assert not env.agents
    running = other.get_state()
    obs, info = other.set_state(env.get_state())
    assert not other.agents
    assert list(obs) == list(info) == env.possible_agents
    env.set_state(running)
    assert env.agents == env.possible_agents


def test_the_turns_need_a_state_that_knows_them():
    env, other = begun("aec", IDS[0], 5), begun("parallel", IDS[0], 2)
    with pytest.raises(InvalidInput, match="state must know whose turn it is, got one of another"):
        env.set_state(other.get_state())
    with pytest.raises(InvalidInput, match="state must be what get_state returned"):
        env.set_state(None)


def test_the_single_view_draws_with_the_generator_of_its_state():
    env, other = (begun("gymnasium", IDS[0], 3).unwrapped for _ in range(2))
    other.reset(seed=99)
    other.set_state(env.get_state())
    assert other.np_random is other.transport.generators[0] is not env.np_random
    assert other.np_random_seed == -1  # as Gymnasium says of a generator that was given
    assert other.np_random.random() == env.np_random.random()


def test_a_view_with_pictures_is_copied_and_draws_the_same():
    env = gymnasium.make(IDS[1], render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    for again in AGAIN.values():
        np.testing.assert_array_equal(again(env).render(), picture)


def test_lists_of_pictures_begin_anew_at_a_state():
    env: Any = gymnasium.make_vec(IDS[0], 2, render_mode="rgb_array_list").unwrapped
    env.reset(seed=0)
    state = env.get_state([0])
    for _ in range(2):
        env.step(env.action_space.sample())
    env.set_state(state, [1])
    assert [len(frames) for frames in env.render()] == [3, 1]


def test_a_vec_env_reports_episodes_as_if_they_had_not_been_left():
    venv = begun("vec_env", IDS[0], 5)
    plan = plan_of("vec_env", IDS[0], HORIZON - 5, 2)
    state = venv.env_method("get_state", [1])[0]
    (*_, infos) = rows(venv, plan)[-1]
    venv.env_method("set_state", state)  # world 1 in both
    again = rows(venv, plan[:, [1, 1]])[-1][3]
    assert infos[1]["episode"]["l"] == HORIZON
    assert_same(again[0], again[1], within=1e-9)
    assert_same(again[1], infos[1])
    venv.set_state(venv.transport.get_state())  # of a view without statistics: they begin here
    assert rows(venv, plan_of("vec_env", IDS[0], HORIZON, 3))[-1][3][0]["episode"]["l"] == HORIZON


def test_worlds_that_had_ended_are_reset_at_once_where_that_is_the_vectors_way():
    core = Transport(num_worlds=2, horizon=3)
    core.reset(seed=0)
    for _ in range(3):
        core.step(np.zeros((2, 2, 3)))
    env: Any = gymnasium.make_vec(IDS[0], 2, horizon=3, autoreset_mode="SameStep")
    env.reset(seed=1)
    env.unwrapped.set_state(core.get_state())
    ends = [env.step(np.zeros((2, 6), dtype=np.float32))[3] for _ in range(3)]
    np.testing.assert_array_equal(ends, [[False] * 2, [False] * 2, [True] * 2])


def test_a_vec_env_begins_anew_where_the_episode_had_ended():
    venv = begun("vec_env", IDS[0], 5)
    core = Transport(num_worlds=2, config=venv.transport.config)
    core.reset(seed=0)
    for action in plan_of("vec_env", IDS[0], HORIZON, 2):
        core.step(action)
    obs = venv.set_state(core.get_state())
    np.testing.assert_array_equal(venv.transport.transition.next_state.time, 0.0)
    assert_same(obs, core.reset()[0].reshape(2, -1))
    rows(venv, plan_of("vec_env", IDS[0], 3, 2))


def test_the_seconds_of_an_episode_go_on_in_a_pickle(monkeypatch):
    venv = begun("vec_env", IDS[0], 5)
    monkeypatch.setattr("time.perf_counter", lambda: venv._start_time + 10)
    data = pickle.dumps(venv)
    monkeypatch.setattr("time.perf_counter", lambda: 77.0)  # another process's clock
    assert pickle.loads(data)._start_time == pytest.approx(67.0)
