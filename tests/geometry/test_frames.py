"""Turning between the object's frame, the agents' and the world's."""

import numpy as np
import pytest

from coopenv.geometry import frames

GENERATOR = np.random.default_rng(0)
GRIPS = GENERATOR.uniform(-1, 1, (4, 3, 2))  # (world, agent, xy)
LIMITS = GENERATOR.uniform(1, 20, (4, 3, 2))


def test_an_agents_x_axis_points_from_its_grip_to_the_centre_of_mass():
    frame = frames.agent_frames(GRIPS)
    np.testing.assert_allclose(np.linalg.norm(frame, axis=-1), 1.0, rtol=1e-15)
    lengths = np.linalg.norm(GRIPS, axis=-1, keepdims=True)
    np.testing.assert_allclose(GRIPS + lengths * frame, 0.0, atol=1e-15)


def test_at_the_centre_of_mass_it_is_the_objects_axis():
    np.testing.assert_array_equal(frames.agent_frames(np.zeros((1, 2))), [(1.0, 0.0)])


@pytest.mark.parametrize("width", [2, 3])
def test_actions_from_wrenches_undo_wrenches_from_actions(width):
    action = GENERATOR.uniform(-1, 1, (4, 3, width))
    frame = frames.agent_frames(GRIPS)
    clipped, applied = frames.wrenches_from_actions(action, frame, LIMITS)
    np.testing.assert_array_equal(clipped, action)
    back = frames.actions_from_wrenches(applied, frame, LIMITS, width)
    np.testing.assert_allclose(back, action, rtol=0, atol=1e-14)


def test_turning_keeps_the_strength_of_a_force():
    action = GENERATOR.uniform(-1, 1, (4, 3, 3))
    _, applied = frames.wrenches_from_actions(action, frames.agent_frames(GRIPS), LIMITS)
    wanted = np.linalg.norm(action[..., :2], axis=-1) * LIMITS[..., 0]
    np.testing.assert_allclose(np.linalg.norm(applied[..., :2], axis=-1), wanted, rtol=1e-14)
    np.testing.assert_allclose(applied[..., 2], action[..., 2] * LIMITS[..., 1], rtol=1e-15)


def test_an_angle_is_wrapped_to_the_half_open_turn():
    angles = np.array([0.0, np.pi, -np.pi, 3 * np.pi, -7.0, 7.0, 100.0, -100.0])
    pose = np.stack([np.full(8, 1.5), np.full(8, -2.5), angles], axis=-1)
    wrapped = frames.wrap_pose(pose)
    np.testing.assert_array_equal(wrapped[:, :2], pose[:, :2])
    assert ((wrapped[:, 2] > -np.pi) & (wrapped[:, 2] <= np.pi)).all()
    np.testing.assert_allclose(np.exp(1j * wrapped[:, 2]), np.exp(1j * angles), atol=1e-13)
    np.testing.assert_array_equal(wrapped[1:3, 2], np.pi)
    np.testing.assert_array_equal(pose[:, 2], angles)  # the given pose stays as it was


def test_the_short_way_round_has_no_sign_and_no_more_than_half_a_turn():
    angle, other = GENERATOR.uniform(-20, 20, (2, 500))
    turn = frames.turn_between(angle, other)
    assert ((turn >= 0) & (turn <= np.pi)).all()
    np.testing.assert_allclose(turn, np.abs(frames.wrapped(angle - other)), atol=1e-13)
    assert frames.turn_between(0.5, 0.5) == 0.0


def test_rotating_twice_is_rotating_by_both_angles_and_back_is_the_inverse():
    first, second, x, y = GENERATOR.uniform(-3, 3, (4, 50))
    c, s = np.cos(first), np.sin(first)
    both = frames.rotated(c, s, np.cos(second), np.sin(second))
    np.testing.assert_allclose(both, (np.cos(first + second), np.sin(first + second)), atol=1e-14)
    there = frames.rotated(c, s, x, y)
    np.testing.assert_allclose(
        np.array(there).T, [rotation(a) @ (u, v) for a, u, v in zip(first, x, y, strict=True)]
    )
    np.testing.assert_allclose(frames.rotated_back(c, s, *there), (x, y), atol=1e-14)


def test_a_point_of_a_placed_frame_is_seen_where_it_was():
    at_x, at_y, angle, x, y = GENERATOR.uniform(-3, 3, (5, 50))
    pose = at_x, at_y, np.cos(angle), np.sin(angle)
    there = np.array(frames.placed(*pose, x, y))
    np.testing.assert_allclose(frames.seen_from(*pose, *there), (x, y), atol=1e-14)
    moved = frames.moved(np.array([x, y]).T[:1], (at_x[0], at_y[0], angle[0]))
    np.testing.assert_allclose(moved, there.T[:1], atol=1e-14)


def rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([(c, -s), (s, c)])
