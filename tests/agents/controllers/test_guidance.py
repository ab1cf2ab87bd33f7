"""Guidance by hand: the twist to aim for, its limits, walls and the turns that need room."""

import numpy as np
import pytest

from coopenv.agents.controllers import Gains, approach

GAINS = Gains(approach=2.0, speed=1.5, spin=0.8, margin=0.1, look_ahead=0.8)
BEAM = np.array([[(-1.0, -0.05), (1.0, -0.05), (1.0, 0.05), (-1.0, 0.05)]])
ROOM = np.array([[-4.0, -3.0]]), np.array([[4.0, 3.0]])


def led(pose, goal, *, room=ROOM, gains=GAINS):
    low, high = room
    return approach(np.array([pose], float), np.array([goal], float), BEAM, low, high, gains)[0]


def test_near_the_goal_the_twist_is_the_way_left_times_the_gain():
    np.testing.assert_allclose(
        led((0.1, -0.2, 3.1), (0.4, 0.2, -3.1)), (0.6, 0.8, 2 * (2 * np.pi - 6.2))
    )
    np.testing.assert_allclose(led((0.1, -0.2, 0.3), (0.0, -0.1, 0.1)), (-0.2, 0.2, -0.4))
    np.testing.assert_array_equal(led((0.5, 0.5, 1.0), (0.5, 0.5, 1.0)), 0.0)


def test_far_from_it_speed_and_spin_are_at_their_most_in_the_same_direction():
    np.testing.assert_allclose(led((0, 0, 0), (2.4, 1.8, 0.5)), (1.2, 0.9, 0.8))
    np.testing.assert_allclose(led((0, 0, 0), (-2.4, 1.8, -0.5)), (-1.2, 0.9, -0.8))


def test_half_a_turn_goes_counter_clockwise():
    assert led((0, 0, 0), (0, 0, np.pi))[2] == 0.8
    assert led((0, 0, np.pi), (0, 0, 0))[2] == 0.8


@pytest.mark.parametrize(
    ("pose", "goal", "wanted"),
    [
        # The beam's end may come to 0.1 m from the wall: its centre to 2.9 m along x,
        ((2.8, 0, 0), (3.8, 0, 0), (0.2, 0, 0)),
        ((-2.8, 0, 0), (-3.8, 0, 0), (-0.2, 0, 0)),
        # and to 2.85 m across.
        ((0, 2.8, 0), (0, 2.95, 0), (0, 0.1, 0)),
        ((0, -2.8, 0), (0, -2.95, 0), (0, -0.1, 0)),
        # Nearer it moves away, and does not turn before there is room: 0.15 of 0.3 m is missing.
        ((3.05, 0, 0), (3.5, 0, 0.0), (-0.3, 0, 0)),
    ],
)
def test_it_keeps_its_outline_the_margin_off_the_walls(pose, goal, wanted):
    np.testing.assert_allclose(led(pose, goal), wanted, atol=1e-12)


def test_a_turn_is_as_slow_as_it_is_cramped():
    # Along the wall at 2.8 m; the coming 0.8 rad lift an end by sin 0.8, and there is 0.1 m.
    pose, goal = (0, 2.5, 0), (0, 2.5, 1.2)
    lift = np.sin(0.8) + 0.05 * np.cos(0.8)
    missing = 2.5 - (3 - 0.1 - lift)
    twist = led(pose, goal)
    assert missing > 0.3
    np.testing.assert_allclose(twist, (0, max(-2 * missing, -1.5), 0), atol=1e-12)
    higher = 2.9 - lift + 0.15  # 0.15 m are missing: half the spin
    np.testing.assert_allclose(led((0, higher, 0), (0, higher, 1.2)), (0, -0.3, 0.4), atol=1e-12)
    np.testing.assert_allclose(led((0, -higher, 0), (0, -higher, -1.2)), (0, 0.3, -0.4), atol=1e-12)


def test_in_a_room_too_narrow_for_it_the_middle_is_aimed_for():
    narrow = np.array([[-4.0, -0.1]]), np.array([[4.0, 0.5]])
    sideways = Gains(approach=2.0, margin=0.3)
    assert led((0, 0.0, 0), (0, 1.0, 0), room=narrow, gains=sideways)[1] == pytest.approx(0.4)


def test_each_world_has_its_own_outline_and_rectangle():
    outline = np.concatenate([BEAM, 0.5 * BEAM])
    low, high = np.array([[-4.0, -3.0]] * 2), np.array([[4.0, 3.0], [3.0, 3.0]])
    pose, goal = np.array([[2.8, 0, 0], [2.3, 0, 0]]), np.array([[3.8, 0, 0], [3.8, 0, 0]])
    twist = approach(pose, goal, outline, low, high, GAINS)
    np.testing.assert_allclose(twist[:, 0], [0.2, 0.2], atol=1e-12)  # to 2.9 m and to 2.4 m
