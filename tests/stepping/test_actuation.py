"""What of the agents' commands acts: late, slowly, and no steeper than it may."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import coopenv
from coopenv import Actuators, Ranges, Transport, rewards
from coopenv.agents.partners import PARTNERS
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.stepping.handling import CompliantHands, HeldWrenches
from tests.helpers import NEVER, OPEN_ROOM, actions, assert_same, side_by_side, vec_env
from tests.test_partner import Steady

DT = 0.05  # [s]
KINDS: dict[str, dict[str, Any]] = {
    "wrench": {"action": "wrench"},
    "force": {"action": "force"},
    "discrete": {"action": "discrete"},
    "motion": {"action": "motion"},
    "impedance": {"action": "impedance"},
}
EVERY_KIND = pytest.mark.parametrize("keywords", KINDS.values(), ids=KINDS)
BESIDE = {**KINDS, "partner": {"partner": "leader"}}
EVERY_KIND_BESIDE = pytest.mark.parametrize("keywords", BESIDE.values(), ids=BESIDE)
SLOW = Actuators(delay=(2, 3), time_constant=(0.1, 0.02), rate_limit=(None, 3.0))


def started(num_worlds: int = 1, seed: int = 0, **keywords) -> Transport:
    core = Transport(num_worlds=num_worlds, **{"scene": OPEN_ROOM, "task": NEVER, **keywords})
    core.reset(seed=seed)
    return core


def commands(core: Transport, steps: int, seed: int = 0) -> np.ndarray:
    """Random ones, beyond [−1, 1] too; numbers of pushes where these are wanted."""
    if core.table is not None:
        generator = np.random.default_rng(seed)
        return generator.integers(0, len(core.table), (steps, *core.action_shape))
    return 1.3 * actions(seed, steps, *core.action_shape)


def acting(core: Transport, plan: np.ndarray) -> np.ndarray:
    """What acts in every step, in parts of the limits, ``(step, world, agent, 3)``, agent frame."""
    seen = []
    for command in plan:
        core.step(command)
        assert core.transition is not None
        team, applied = core.team, core.transition.applied
        c, s = np.moveaxis(team.frame, -1, 0)
        x, y = applied[..., 0], applied[..., 1]
        along, across = c * x + s * y, c * y - s * x
        limits = team.limits[..., [0, 0, 1]]
        seen.append(np.stack([along, across, applied[..., 2]], axis=-1) / limits)
    return np.array(seen)


def held(steps: int, size: float = 1.0) -> np.ndarray:
    return np.full((steps, 1, 2, 3), size)


@pytest.mark.parametrize("constant", [0.003, 0.1, 2.0])
def test_a_held_command_comes_to_act_as_the_exponential_says(constant):
    seen = acting(started(actuators=Actuators(time_constant=constant)), held(40, -0.7))
    ends = DT * np.arange(1, 41)  # [s], of the steps
    wanted = -0.7 * (1 - np.exp(-ends / constant))
    np.testing.assert_allclose(seen, np.broadcast_to(wanted[:, None, None, None], seen.shape))


def test_of_a_command_that_is_over_the_exponential_is_left():
    plan = held(30)
    plan[1:] = 0.0
    seen = acting(started(actuators=Actuators(time_constant=0.2)), plan)
    left = np.exp(-DT / 0.2)
    wanted = (1 - left) * left ** np.arange(30)
    np.testing.assert_allclose(seen[:, 0, 0, 0], wanted)
    np.testing.assert_allclose(seen.sum(axis=0), 1 - left**30)  # no impulse gets lost


@settings(max_examples=25, deadline=None)
@given(st.floats(1e-4, 5.0), st.integers(0, 6), st.integers(0, 10**6))
def test_any_commands_act_as_their_convolution_with_the_impulse_response(constant, delay, seed):
    plan = actions(seed, 20, 1, 2, 3)
    seen = acting(started(actuators=Actuators(time_constant=constant, delay=delay)), plan)
    left = np.exp(-DT / constant)
    response = (1 - left) * left ** np.arange(20)
    wanted = np.zeros_like(plan)
    for n in range(20):
        for k in range(n - delay + 1):
            wanted[n] += response[n - delay - k] * plan[k]
    np.testing.assert_allclose(seen, wanted, atol=1e-12)


@EVERY_KIND
@pytest.mark.parametrize("delay", [1, 3])
def test_a_delay_shifts_what_is_commanded_to_the_bit(keywords, delay):
    late, prompt = started(3, actuators=Actuators(delay=delay), **keywords), started(3, **keywords)
    plan = commands(prompt, 12)
    still = np.zeros_like(plan[:1])
    shifted = np.concatenate([*[still] * delay, plan[:-delay]])
    for command, other in zip(plan, shifted, strict=True):
        late.step(command)
        prompt.step(other)
        np.testing.assert_array_equal(late.world.pose, prompt.world.pose)
        np.testing.assert_array_equal(late.world.twist, prompt.world.twist)
    assert late.world.twist.any()


def test_the_rate_limit_is_the_slope_of_what_acts():
    core = started(actuators=Actuators(rate_limit=4.0))
    up, down = acting(core, held(7)), acting(core, held(12, -1.0))
    rise = np.minimum(4.0 * DT * np.arange(1, 8), 1.0)
    np.testing.assert_allclose(up[:, 0, 1, 2], rise, atol=1e-12)
    np.testing.assert_allclose(
        down[:, 0, 0, 1], np.maximum(1.0 - 4.0 * DT * np.arange(1, 13), -1.0), atol=1e-12
    )
    gentle = np.cumsum(np.full((5, 1, 2, 3), 0.19), axis=0)
    np.testing.assert_array_equal(
        acting(started(actuators=Actuators(rate_limit=4.0)), gentle), acting(started(), gentle)
    )


def test_the_limit_is_behind_the_lag_and_both_behind_the_delay():
    """Of a step it lets the slope through until the exponential, which flattens, is met."""
    values = Actuators(delay=2, time_constant=0.3, rate_limit=2.0)
    seen = acting(started(actuators=values), held(30))[:, 0, 0, 0]
    n = np.maximum(np.arange(1, 31) - 2, 0)
    lag, slope = 1 - np.exp(-n * DT / 0.3), 2.0 * n * DT
    assert (slope < lag)[4:8].all()
    assert (slope > lag)[-5:].all()
    np.testing.assert_allclose(seen, np.minimum(lag, slope), atol=1e-12)


@EVERY_KIND_BESIDE
def test_actuators_that_do_nothing_change_no_bit(keywords):
    plain, through = started(3, **keywords), started(3, actuators=Actuators(), **keywords)
    for command in commands(plain, 15):
        assert_same(plain.step(command), through.step(command))


def test_without_actuators_nothing_is_between_action_and_handling():
    assert type(started().handling) is HeldWrenches
    assert type(started(action="motion").handling) is CompliantHands


def test_each_agent_has_its_own():
    core, plain = started(actuators=SLOW), started()
    plan = actions(5, 20, 1, 2, 3)
    seen, prompt = acting(core, plan), acting(plain, plan)
    first = acting(started(actuators=Actuators(delay=2, time_constant=0.1)), plan)
    other = acting(started(actuators=Actuators(delay=3, time_constant=0.02, rate_limit=3.0)), plan)
    np.testing.assert_array_equal(seen[:, :, 0], first[:, :, 0])
    np.testing.assert_array_equal(seen[:, :, 1], other[:, :, 1])
    alone = acting(started(actuators=Actuators(delay=(0, 4))), plan)
    np.testing.assert_array_equal(alone[:, :, 0], prompt[:, :, 0])
    assert (alone[:, :, 1] != prompt[:, :, 1]).any()


def test_what_a_driven_agent_gives_goes_through_its_actuators():
    values = Actuators(delay=(0, 2), time_constant=(0.0, 0.1))
    core = started(actuators=values, partner=Steady((3.0, -2.0, 1.0)))
    seen = []
    for command in actions(1, 12, 1, 1, 3):
        core.step(command)
        assert core.transition is not None
        seen.append(core.transition.applied[0, 1].copy())
        np.testing.assert_allclose(core.transition.action[0, 1], [-0.3, 0.2, 0.2], atol=1e-12)
    steps = np.maximum(np.arange(1, 13) - 2, 0)[:, None]
    wanted = np.array([3.0, -2.0, 1.0]) * (1 - np.exp(-steps * DT / 0.1))
    np.testing.assert_allclose(seen, wanted, atol=1e-12)


@pytest.mark.parametrize("name", ["leader", "lagging", "walking"])
def test_partners_act_through_actuators_within_their_limits(name):
    assert name in PARTNERS
    core = started(3, partner=name, actuators=SLOW, scene=coopenv.Scene(size=(9.0, 9.0)))
    seen = acting(core, actions(2, 30, 3, 1, 3))
    assert not seen[:3, :, 1].any()
    assert seen[-1, :, 1].any()
    assert (np.abs(seen) <= 1 + 1e-12).all()


def test_an_action_that_is_told_is_what_was_commanded():
    """So a term about changes of actions is about the agent's own, whatever its actuators do."""
    reward = {"jerk": rewards.ActionRate(weight=1.0), "effort": rewards.Effort(weight=1.0)}
    core, plain = (started(2, reward=reward, actuators=each) for each in (SLOW, None))
    effort = []
    for command in 1.5 * actions(3, 10, 2, 2, 3):
        before = core.transition
        *_, info = core.step(command)
        *_, prompt = plain.step(command)
        assert core.transition is not None
        assert before is not None
        np.testing.assert_array_equal(core.transition.action, np.clip(command, -1, 1))
        np.testing.assert_array_equal(core.transition.previous_action, before.action)
        np.testing.assert_array_equal(info["reward/jerk"], prompt["reward/jerk"])
        effort.append((info["reward/effort"], prompt["reward/effort"]))
    assert not np.any([acted for acted, _ in effort[:2]])  # what acts is what costs
    assert np.all([given for _, given in effort])


@EVERY_KIND_BESIDE
def test_an_episode_begins_with_nothing_commanded_where_it_begins_and_nowhere_else(keywords):
    core, other = (started(3, actuators=SLOW, **keywords) for _ in range(2))
    plan = commands(core, 12)
    for command in plan:
        core.step(command)
        other.step(command)
    still = np.zeros_like(plan[0])
    core.step(still, restart=np.array([False, True, False]))
    other.step(still)
    np.testing.assert_array_equal(core.world.pose[[0, 2]], other.world.pose[[0, 2]])
    core.step(still)
    other.step(still)
    if "partner" not in keywords:
        np.testing.assert_allclose(core.world.twist[1], 0.0, atol=1e-12)
    np.testing.assert_array_equal(core.world.twist[[0, 2]], other.world.twist[[0, 2]])
    assert (other.world.twist[:, :2].any(axis=1)).all()


@EVERY_KIND_BESIDE
def test_a_state_in_the_middle_of_a_command_goes_on_to_the_bit(keywords):
    core = started(6, actuators=SLOW, **keywords)
    plan = commands(core, 24, seed=3)
    for command in plan[:10]:
        core.step(command)
    state = core.get_state()
    first = [core.step(command) for command in plan[10:]]
    core.set_state(state)
    for command, wanted in zip(plan[10:], first, strict=True):
        assert_same(core.step(command), wanted)
    other = Transport(num_worlds=2, config=core.config)
    other.set_state(state.take([4, 1]))
    for command, wanted in zip(plan[10:], first, strict=True):
        np.testing.assert_allclose(other.step(command[[4, 1]])[1], wanted[1][[4, 1]], atol=1e-9)


def test_a_world_does_not_depend_on_those_beside_it():
    keywords = {"actuators": SLOW, "horizon": 7}
    many, again = (started(5, **keywords) for _ in range(2))
    alone = started(1, seed=2, **keywords)
    for _ in side_by_side(many, again, alone, actions(4, 20, 5, 2, 3)):
        assert many.transition is not None
        assert alone.transition is not None
        np.testing.assert_array_equal(many.transition.applied[2], alone.transition.applied[0])


DRAWN = Ranges(
    delay=(0, 3), time_constant=(0.01, 0.3), rate_limit=(2.0, 8.0), logarithmic=("time_constant",)
)

NAMES = ("delay", "time_constant", "rate_limit")


def test_what_is_drawn_is_told_acts_and_is_another_in_the_next_episode():
    core = started(64, randomise=DRAWN)
    assert core.config.actuators == Actuators()
    _, info = core.reset(seed=1)
    for name in NAMES:
        low, high = getattr(DRAWN, name)
        drawn = info[f"body/{name}"]
        assert drawn.shape == (64, 2)
        assert low <= drawn.min() < drawn.max() <= high
    delay, constant, rate = (info[f"body/{name}"] for name in NAMES)
    assert (np.bincount(delay.astype(int).ravel(), minlength=4) > 16).all()  # of 128
    assert np.median(constant) < 0.1  # the middle is the geometric one
    seen = acting(core, np.ones((12, 64, 2, 3)))[..., 0]
    steps = np.maximum(np.arange(1, 13)[:, None, None] - delay, 0)
    lag = 1 - np.exp(-steps * DT / constant)
    np.testing.assert_array_equal(seen != 0, steps > 0)
    np.testing.assert_allclose(seen, np.minimum(lag, rate * DT * steps), atol=1e-12)
    _, after = core.reset()
    for name in NAMES:
        assert (after[f"body/{name}"] != info[f"body/{name}"]).mean() > 0.6


def test_without_actuators_none_are_told_or_drawn():
    plain = started(2, randomise=Ranges(mass=(4, 9)))
    assert not any("delay" in name for name in plain.reset(seed=0)[1])
    fixed = started(2, randomise=Ranges(mass=(4, 9)), actuators=SLOW)
    _, info = fixed.reset(seed=0)
    np.testing.assert_array_equal(info["body/delay"], [[2, 3]] * 2)
    assert np.isfinite(info["body/rate_limit"]).all()


def test_every_view_has_actuators():
    core = started(1, actuators=SLOW)
    keywords: dict[str, Any] = {"scene": OPEN_ROOM, "task": NEVER, "actuators": SLOW}
    env = gymnasium.make("coopenv/BeamTransport-v0", **keywords)
    vector = gymnasium.make_vec("coopenv/BeamTransport-v0", num_envs=2, **keywords)
    team = coopenv.beam_transport_v0.parallel_env(**keywords)
    venv = vec_env("coopenv/BeamTransport-v0", num_worlds=2, control="joint", **keywords)
    env.reset(seed=0)
    vector.reset(seed=0)
    team.reset(seed=0)
    venv.seed(0)
    venv.reset()
    inside = {
        "env": env.unwrapped, "vector": vector.unwrapped, "team": team.unwrapped, "venv": venv
    }  # fmt: skip
    for push in actions(6, 8, 1, 2, 3).astype(np.float32):
        core.step(push)
        assert core.transition is not None
        flat = push.reshape(-1)
        env.step(flat)
        vector.step(np.stack([flat, flat]))
        team.step({name: push[0, i] for i, name in enumerate(team.possible_agents)})
        venv.step(np.stack([flat, flat]))
        for name, view in inside.items():
            given = view.transport.transition.applied[0]
            np.testing.assert_array_equal(given, core.transition.applied[0], err_msg=name)
    assert core.transition.applied.any()  # pyright: ignore[reportOptionalMemberAccess]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"delay": 1.5}, r"actuators\.delay must be a whole number of at least 0, got 1\.5"),
        ({"delay": -1}, r"actuators\.delay must be a whole number"),
        ({"delay": True}, r"actuators\.delay must be made of numbers, got True"),
        ({"delay": (1, 0.5)}, r"actuators\.delay must be a whole number"),
        ({"delay": ()}, r"actuators\.delay must be one whole number or one an agent, got \(\)"),
        ({"delay": [[1, 2]]}, r"actuators\.delay must be one whole number or one an agent, got"),
        ({"delay": b"ab"}, r"actuators\.delay must be an array of numbers, got b'ab'"),
        ({"delay": 10**5}, r"actuators\.delay must be at most 10000"),
        ({"time_constant": -0.1}, r"actuators\.time_constant must be zero or positive"),
        ({"time_constant": np.nan}, r"actuators\.time_constant must be finite"),
        ({"time_constant": (0.1, False)}, r"actuators\.time_constant must be made of numbers"),
        ({"rate_limit": 0.0}, r"actuators\.rate_limit must be positive"),
        ({"rate_limit": (None, -1.0)}, r"actuators\.rate_limit must be positive"),
        ({"rate_limit": (None, (1.0, 2.0))}, r"actuators\.rate_limit must"),
    ],
)
def test_a_value_that_breaks_its_rule_is_refused(values, message):
    with pytest.raises(InvalidInput, match=message):
        Actuators(**values)


def test_delays_may_be_given_in_arrays():
    assert Actuators(delay=np.array(2)) == Actuators(delay=2)  # pyright: ignore[reportArgumentType]
    assert Actuators(delay=np.array([1, 3])).delay == (1, 3)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"actuators": Actuators(delay=(1, 2, 3))}, r"actuators\.delay must be one number or one"),
        ({"actuators": Actuators(rate_limit=(None,))}, r"actuators\.rate_limit must be one number"),
        ({"actuators": 3}, r"actuators must be a Actuators, got 3"),
        ({"actuators": {"dely": 3}}, r"got 'dely'; did you mean 'delay'"),
        ({"randomise": {"delay": (0.5, 2)}}, r"randomise\.delay must be a whole number"),
        ({"randomise": {"rate_limit": (0, 2)}}, r"randomise\.rate_limit must begin above zero"),
        (
            {"randomise": {"delay": (1, 2), "logarithmic": ("delay",)}},
            r"randomise\.logarithmic must name what may be drawn log-uniformly, got 'delay'",
        ),
        ({"rate_limit": 3.0}, r"pass actuators=Actuators"),
        ({"delay": 3}, r"pass actuators=Actuators\(delay=\.\.\.\) .* or observe="),
    ],
)
def test_what_does_not_go_with_the_environment_is_refused(keywords, message):
    with pytest.raises(CoopenvError, match=message):
        Transport(**keywords)
