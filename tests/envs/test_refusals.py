"""What no view takes: the error is ours, nothing has moved, and the episode goes on."""

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from coopenv import Transport, beam_doorway_v0, beam_transport_v0
from coopenv.envs.single import TransportEnv
from coopenv.envs.vector import TransportVectorEnv
from coopenv.errors import InvalidInput

ZERO = np.zeros(3)


class View(NamedTuple):
    """One view of a transport with an episode under way."""

    core: Transport
    shape: tuple[int, ...]  # of an action
    step: Callable[[Any], Any]
    reset: Callable[..., Any]


def core() -> View:
    core = Transport(num_worlds=2)

    def reset(seed=None, options=None):
        return core.reset(seed=seed, **(options or {}))

    return View(core, (2, 2, 3), core.step, reset)


def single() -> View:
    env = TransportEnv()
    return View(env.transport, (6,), env.step, env.reset)


def vector() -> View:
    env = TransportVectorEnv(num_envs=2)
    return View(env.transport, (2, 6), env.step, env.reset)


def parallel() -> View:
    env: Any = beam_transport_v0.parallel_env()
    return View(
        env.unwrapped.transport,
        (3,),
        lambda action: env.step({"agent_0": action, "agent_1": ZERO}),
        env.reset,
    )


def in_turn() -> View:
    env: Any = beam_transport_v0.env()

    def step(action):
        for each in (action, ZERO):
            env.step(each)

    return View(env.unwrapped.transport, (3,), step, env.reset)


def stable_baselines() -> View:
    pytest.importorskip("stable_baselines3")
    from coopenv import TransportConfig
    from coopenv.agents.sb3 import TransportVecEnv

    env = TransportVecEnv(TransportConfig(), 2)

    def reset(seed=None, options=None):
        env.set_options(options)
        if seed is not None:
            env.seed(seed)
        try:
            return env.reset()
        finally:
            env.set_options(None)

    return View(env.transport, (2, 6), env.step, reset)


VIEWS = [core, single, vector, parallel, in_turn, stable_baselines]


def bad_actions(shape):
    zero = np.zeros(shape)
    yield from (zero + 1j, zero.astype(complex), (zero + 1j).tolist(), (zero + 1j).astype(object))
    yield from (zero.astype(str), zero.astype("S"), zero.astype(str).tolist(), "abc")
    yield from (np.zeros(shape, "M8[s]"), np.zeros(shape, "m8[s]"))
    yield from (zero.astype(object), np.full(shape, 10**400, dtype=object), None, {})
    yield np.ma.masked_array(zero, mask=zero == 0)
    yield list(np.ma.masked_array(zero, mask=zero == 0))
    yield from (zero + np.nan, zero - np.inf, zero[..., None], [[1, 2], [3]], np.zeros(0), 3)


def whole_state(core: Transport) -> str:
    assert core.transition is not None
    states = [each and each.bit_generator.state for each in core.generators]
    return repr((core.world.pose, core.world.twist, core.transition.next_state, states))


@pytest.mark.parametrize("make", VIEWS, ids=lambda make: make.__name__)
def test_no_view_takes_actions_that_are_no_finite_real_numbers(make):
    view = make()
    view.reset(seed=0)
    before = whole_state(view.core)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy warns where it drops imaginary parts
        for action in bad_actions(view.shape):
            with pytest.raises(InvalidInput, match=r"action.* must "):
                view.step(action)
    assert whole_state(view.core) == before
    view.step(np.zeros(view.shape))
    assert view.core.transition is not None
    np.testing.assert_allclose(view.core.transition.next_state.time, view.core.dt)


BAD_SEEDS = [-1, 0.5, "1", "12", ["1", "2"], b"1", b"12", 1j, np.nan, np.inf, True, {}, object()]
BAD_SEEDS += [np.datetime64(1, "s"), np.timedelta64(1, "s"), np.zeros((2, 2)), np.array(["1", "2"])]
BAD_POSES = ["abc", (1j, 0, 0), (1, 2), (np.nan, 0, 0), (1e300, 0, 0), (0, 0, 1e300), (None, 0, 0)]
BAD_POSES += [
    np.zeros(3, "M8[s]"),
    {},
    (100, 0, 0),
    np.ma.masked_array(ZERO, mask=[True, False, False]),
]


@pytest.mark.parametrize("make", VIEWS, ids=lambda make: make.__name__)
def test_a_refused_reset_changes_nothing(make):
    view = make()
    view.reset(seed=0)
    before = whole_state(view.core)
    for seed in BAD_SEEDS:
        with pytest.raises(InvalidInput, match="seed must be"):
            view.reset(seed=seed)
    for name in ("pose", "goal"):
        for pose in BAD_POSES:
            with pytest.raises(InvalidInput, match=f"{name} must"):
                view.reset(seed=5, options={name: pose})
    assert whole_state(view.core) == before
    view.step(np.zeros(view.shape))


@pytest.mark.parametrize("make", VIEWS[1:], ids=lambda make: make.__name__)
@pytest.mark.parametrize("options", [[1], 1, 0, "goal", [], True], ids=repr)
def test_reset_options_are_a_dict(make, options):
    view = make()
    if make is stable_baselines and isinstance(options, list):
        pytest.skip("has its own message: one dict for all worlds")
    with pytest.raises(InvalidInput, match=r"options must be a dict or None, got"):
        view.reset(options=options)


def test_a_start_inside_a_drawn_wall_does_not_use_up_the_draw():
    env: Any = beam_doorway_v0.parallel_env()
    core = Transport(num_worlds=2, config=env.unwrapped.transport.config)
    core.reset(seed=0)
    pillar = core.scenes[0].obstacles[0].center[0], core.scenes[0].size[1] / 2 - 0.01, 0.0
    core.reset(seed=1)
    before = whole_state(core)
    with pytest.raises(InvalidInput, match="pose must put"):
        core.reset(seed=0, pose=pillar)
    assert whole_state(core) == before


def test_masks_are_booleans_one_a_world():
    core = Transport(num_worlds=2)
    core.reset(seed=0)
    masked = np.ma.masked_array([True, True], mask=[True, False])
    for mask in ([1, 0], [True], "ab", np.zeros(2), 3, np.ones((2, 1), bool), masked):
        with pytest.raises(InvalidInput, match="mask must"):
            core.reset(mask=mask)  # pyright: ignore[reportArgumentType]
        with pytest.raises(InvalidInput, match="restart must"):
            core.step(np.zeros((2, 2, 3)), restart=mask)  # pyright: ignore[reportArgumentType]
    core.step(np.zeros((2, 2, 3)), restart=[True, False])  # pyright: ignore[reportArgumentType]


def test_an_agent_whose_action_was_refused_may_act_again_in_its_turn():
    env: Any = beam_transport_v0.env()
    env.reset(seed=0)
    with pytest.raises(InvalidInput, match=r"actions\['agent_0'\] must be finite"):
        env.step(ZERO * np.nan)
    assert env.agent_selection == "agent_0"
    env.step(ZERO)
    with pytest.raises(InvalidInput, match=r"actions\['agent_1'\] must be an array"):
        env.step(ZERO.astype(str))
    env.step(ZERO)
    assert env.agent_selection == "agent_0"
