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
    clipped, applied, finite = frames.wrenches_from_actions(action, frame, LIMITS)
    np.testing.assert_array_equal(clipped, action)
    assert finite
    back = frames.actions_from_wrenches(applied, frame, LIMITS, width)
    np.testing.assert_allclose(back, action, rtol=0, atol=1e-14)


def test_turning_keeps_the_strength_of_a_force():
    action = GENERATOR.uniform(-1, 1, (4, 3, 3))
    _, applied, _ = frames.wrenches_from_actions(action, frames.agent_frames(GRIPS), LIMITS)
    wanted = np.linalg.norm(action[..., :2], axis=-1) * LIMITS[..., 0]
    np.testing.assert_allclose(np.linalg.norm(applied[..., :2], axis=-1), wanted, rtol=1e-14)
    np.testing.assert_allclose(applied[..., 2], action[..., 2] * LIMITS[..., 1], rtol=1e-15)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_is_noticed_anywhere(value):
    frame = frames.agent_frames(GRIPS)
    for place in np.ndindex(4, 3, 3):
        action = np.zeros((4, 3, 3))
        action[place] = value
        assert not frames.wrenches_from_actions(action, frame, LIMITS)[2]


def test_an_angle_is_wrapped_to_the_half_open_turn():
    angles = np.array([0.0, np.pi, -np.pi, 3 * np.pi, -7.0, 7.0, 100.0, -100.0])
    pose = np.stack([np.full(8, 1.5), np.full(8, -2.5), angles], axis=-1)
    wrapped = frames.wrap_pose(pose)
    np.testing.assert_array_equal(wrapped[:, :2], pose[:, :2])
    assert ((wrapped[:, 2] > -np.pi) & (wrapped[:, 2] <= np.pi)).all()
    np.testing.assert_allclose(np.exp(1j * wrapped[:, 2]), np.exp(1j * angles), atol=1e-13)
    np.testing.assert_array_equal(wrapped[1:3, 2], np.pi)
    np.testing.assert_array_equal(pose[:, 2], angles)  # the given pose stays as it was
