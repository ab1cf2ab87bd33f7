"""The first step of an episode: what came before it is nothing, whoever began it and however."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Transport, rewards
from tests.helpers import NEVER, TRIO

PUSH = np.array([[[0.5, -0.25, 1.0], [-1.0, 0.0, 0.5]], [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]])


def begun():
    core = Transport(num_worlds=2, task=NEVER, reward=rewards.ActionRate(weight=0.5))
    core.reset(seed=0)
    return core


def last(core):
    assert core.transition is not None
    return core.transition


def test_the_action_before_the_first_is_no_action():
    core = begun()
    assert (
        last(core).action.tolist() == last(core).previous_action.tolist() == [[[0.0] * 3] * 2] * 2
    )
    _, reward, *_ = core.step(PUSH)
    np.testing.assert_array_equal(last(core).previous_action, np.zeros((2, 2, 3)))
    # Half of 0.25 + 0.0625 + 1 and so on
    np.testing.assert_allclose(reward, [[-0.65625, -0.625], [-0.07, -0.385]], rtol=1e-12)
    _, reward, *_ = core.step(PUSH)
    np.testing.assert_array_equal(last(core).previous_action, PUSH)
    assert not reward.any()


def test_only_a_world_that_begins_anew_forgets_its_last_action():
    mask = np.array([True, False])
    core = begun()
    core.step(PUSH)
    core.reset(mask=mask)
    np.testing.assert_array_equal(last(core).action, [np.zeros((2, 3)), PUSH[1]])
    core.step(PUSH)
    np.testing.assert_array_equal(last(core).previous_action, [np.zeros((2, 3)), PUSH[1]])
    core.step(PUSH, restart=mask)
    _, reward, *_ = core.step(PUSH)
    np.testing.assert_array_equal(last(core).previous_action, [np.zeros((2, 3)), PUSH[1]])
    np.testing.assert_allclose(reward, [[-0.65625, -0.625], [0, 0]], rtol=1e-12)


def test_a_start_led_to_nothing_yet():
    core = Transport(num_worlds=2, body=TRIO, action="force", dt=0.1, horizon=7)
    core.reset(seed=0)
    start = last(core)
    assert start.state is start.next_state
    assert start.action.shape == (2, 3, 2)
    assert start.applied.shape == (2, 3, 3)
    assert (start.dt, start.horizon) == (0.1, 7)
    for name in (
        "applied",
        "contact_impulse",
        "contact_shift",
        "surroundings_wrench",
        "wheel_force",
        "success",
        "terminated",
        "truncated",
    ):
        assert not getattr(start, name).any(), name
    assert not start.state.twist.any()
    assert not start.state.time.any()


def test_a_step_says_where_it_came_from():
    core = begun()
    core.step(PUSH)
    middle = last(core)
    core.step(-PUSH)
    assert last(core).state is middle.next_state
    np.testing.assert_allclose(last(core).next_state.time, 0.1)
    np.testing.assert_allclose(middle.next_state.time, 0.05)
    assert (last(core).next_state.pose != middle.next_state.pose).all()


def test_one_value_a_world_is_repeated_for_each_agent():
    given = last(begun()).per_agent(np.array([2.0, -3.0]), 0.5)
    np.testing.assert_array_equal(given, [[1.0, 1.0], [-1.5, -1.5]])


@pytest.mark.parametrize("worlds", [[1], [0, 1]])
def test_worlds_are_put_into_a_transition_in_their_order(worlds):
    core = begun()
    core.step(PUSH)
    into, rows = last(core), np.array(worlds)
    time = np.array([7.0, 8.0])[: len(worlds)]
    source = replace(core.conditions.take(rows))
    other = replace(
        into,
        action=into.action[rows] + 5,
        state=replace(into.state, time=time, **{
            name: getattr(into.state, name)[rows] for name in ("pose", "twist", "goal", "distance")
        }),
        conditions=source,
    )  # fmt: skip
    for name in ("previous_action", "applied", "contact_impulse", "contact_shift",
                 "surroundings_wrench", "wheel_force", "success", "terminated",
                 "truncated"):  # fmt: skip
        other = replace(other, **{name: getattr(into, name)[rows]})
    other = replace(other, next_state=other.state)
    merged = into.with_worlds(rows, other, core.conditions)
    wanted = PUSH.copy()
    wanted[rows] += 5
    np.testing.assert_array_equal(merged.action, wanted)
    assert merged.next_state.time[rows].tolist() == time.tolist()
    assert into.action.max() == 1.0  # as it was
