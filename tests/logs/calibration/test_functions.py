"""What a correction gives back is what was there before a laboratory's error, made otherwise."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs import calibration

c: Any = calibration  # arrays of any kind may be given
RNG = np.random.default_rng(5)
SPATIAL = RNG.normal(size=(50, 6)) * [20, 20, 20, 3, 3, 3]
PLANAR = RNG.normal(size=(50, 3)) * [20, 20, 3]
EXACT = {"rtol": 0, "atol": 1e-12}


def test_a_turned_sensor_is_turned_back_in_the_plane_and_in_space():
    angle = np.radians(30)
    read = PLANAR.copy()  # the sensor's x axis is 30° from the object's
    read[:, 0] = np.cos(angle) * PLANAR[:, 0] + np.sin(angle) * PLANAR[:, 1]
    read[:, 1] = np.cos(angle) * PLANAR[:, 1] - np.sin(angle) * PLANAR[:, 0]
    matrix = c.Sensor(rotation=30.0).checked("s").matrix(2, np.pi / 180, "s")
    np.testing.assert_allclose(c.turned(read, matrix), PLANAR, **EXACT)
    mounted = Rotation.from_euler("ZYX", [30, -40, 110], degrees=True)
    read = np.hstack([mounted.inv().apply(SPATIAL[:, :3]), mounted.inv().apply(SPATIAL[:, 3:])])
    x, y, z, w = mounted.as_quat().tolist()
    for said in (
        mounted.as_matrix().tolist(),
        {"quaternion": [w, x, y, z]},
        {"quaternion": [x, y, z, w], "order": "xyzw"},
        {"euler": [30, -40, 110], "order": "ZYX"},
        {"euler": [110, -40, 30], "order": "xyz"},
    ):
        matrix = c.Sensor(rotation=said).checked("s").matrix(3, np.pi / 180, "s")
        np.testing.assert_allclose(c.turned(read, matrix), SPATIAL, **EXACT)


def test_a_wrench_about_the_sensor_is_moved_to_the_grip():
    offset = np.array([0.05, -0.02, 0.1])  # from the sensor to the grip
    read = SPATIAL.copy()
    for row in read:  # the grip's force at the end of the arm
        row[3:] += np.cross(offset, row[:3])
    np.testing.assert_allclose(c.moved(read, offset), SPATIAL, **EXACT)
    assert c.moved(np.array([0.0, 10.0, 0.0]), (0.05, 0.0)).tolist() == [0.0, 10.0, -0.5]


def test_cross_talk_is_undone_by_its_inverse():
    coupling = np.eye(6) + 0.03 * RNG.normal(size=(6, 6))
    read = np.array([coupling @ row for row in SPATIAL])
    np.testing.assert_allclose(c.uncoupled(read, np.linalg.inv(coupling)), SPATIAL, **EXACT)


def test_a_tare_leaves_nothing_of_a_rest_and_a_drift_nothing_of_two():
    held = SPATIAL.copy()
    held[:10] = 0.0
    held[40:] = 0.0
    bias = np.array([1.0, -2.0, 0.5, 0.1, 0.2, -0.3])
    np.testing.assert_allclose(c.tared(held + bias, slice(0, 10)), held, **EXACT)
    time = np.arange(50) * 0.1
    read = held + bias + np.outer(time, [0.1, 0.0, -0.2, 0.0, 0.01, 0.0])
    rests = [slice(0, 10), slice(40, 50)]
    means = [read[rest].mean(axis=0) for rest in rests]
    times = tuple(float(time[rest].mean()) for rest in rests)
    np.testing.assert_allclose(read - c.drift(time, times, *means), held, **EXACT)
    with pytest.raises(InvalidInput, match="rest must have rows"):
        c.tared(held, np.zeros(50, dtype=bool))
    with pytest.raises(InvalidInput, match="times must increase"):
        c.drift(time, times[::-1], *means)


def test_a_load_hangs_by_the_laws_of_motion_of_its_particles():
    """Eight particles at the corners of a box are the body; each has weight and inertia alone."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    mass, center, box = 0.8, np.array([0.02, -0.03, 0.09]), corners * [0.05, 0.02, 0.03]
    inertia = sum(mass / 8 * (p @ p * np.eye(3) - np.outer(p, p)) for p in box)
    gravity, origin, spin, rate = RNG.normal(size=(4, 50, 3)) * [[[9]], [[4]], [[3]], [[5]]]
    force, torque = np.zeros((50, 3)), np.zeros((50, 3))
    for particle in box + center:
        speeding = origin + np.cross(rate, particle) + np.cross(spin, np.cross(spin, particle))
        force += mass / 8 * (gravity - speeding)
        torque += np.cross(particle, mass / 8 * (gravity - speeding))
    pull = gravity - origin - np.cross(rate, center) - np.cross(spin, np.cross(spin, center))
    given = c.load_wrench(mass, center, pull, inertia=inertia, spin=spin, spin_rate=rate)
    np.testing.assert_allclose(given, np.hstack([force, torque]), **EXACT)


def test_orientations_of_every_convention_are_the_same_rotation():
    wanted = Rotation.from_quat(RNG.normal(size=(20, 4)))
    xyzw, matrix = wanted.as_quat(), wanted.as_matrix()
    for values, kind, order in (
        (xyzw[:, [3, 0, 1, 2]], "quaternion", "wxyz"),
        (xyzw, "quaternion", "xyzw"),
        (matrix.reshape(20, 9), "matrix", "rows"),
        (matrix.swapaxes(1, 2).reshape(20, 9), "matrix", "columns"),
        (wanted.as_euler("ZYX"), "euler", "ZYX"),
        (wanted.as_euler("xyz"), "euler", "xyz"),
    ):
        made = c.quaternions(values, kind, order)
        same = np.abs((made * xyzw[:, [3, 0, 1, 2]]).sum(axis=-1))
        np.testing.assert_allclose(same, 1.0, **EXACT)
    angle = np.linspace(-3, 3, 7)
    turned = Rotation.from_euler("z", angle[:, None]).as_quat()
    np.testing.assert_allclose(c.heading(c.quaternions(turned, "quaternion", "xyzw")), angle)


def test_nine_numbers_that_are_no_rotation_give_no_quaternion():
    mirror = np.diag([1.0, 1.0, -1.0]).ravel()
    made = c.quaternions([mirror, 1.1 * np.eye(3).ravel(), np.eye(3).ravel()], "matrix")
    assert made.tolist() == [[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]]
    assert np.isnan(c.quaternions([[np.nan, 0, 0]], "euler", "ZYX")).all()
    with pytest.raises(InvalidInput, match="order must be three axes"):
        c.quaternions([[0, 0, 0]], "euler")
    with pytest.raises(UnknownName, match="known: wxyz, xyzw"):
        c.quaternions([[1, 0, 0, 0]], "quaternion", "wxzy")


def test_a_low_pass_keeps_what_is_slow_without_delay_and_halves_what_is_at_its_cutoff():
    time = np.arange(4000) / 1000
    slow, middle, fast = (np.sin(2 * np.pi * f * time) for f in (0.5, 20, 200))
    made = c.low_pass(np.stack([slow, middle, fast], axis=-1), 1000.0, 20.0)[1000:3000]
    np.testing.assert_allclose(made[:, 0], slow[1000:3000], atol=1e-5)
    np.testing.assert_allclose(made[:, 1], middle[1000:3000] / 2, atol=1e-3)
    np.testing.assert_allclose(made[:, 2], 0.0, atol=1e-3)
    with pytest.raises(InvalidInput, match="cutoff must be below half the rate of 100 Hz"):
        c.low_pass(slow, 100.0, 50.0)


def test_the_twist_of_a_turn_at_a_constant_rate_is_that_rate():
    time = np.arange(200) / 100
    spin = np.array([0.4, -0.7, 1.1])  # object frame, which for such a turn is as good as the world
    turn = Rotation.from_rotvec(np.outer(time, spin)) * Rotation.from_rotvec([0.1, 0.2, 0.3])
    own = Rotation.from_rotvec([0.1, 0.2, 0.3]).inv().apply(spin)
    position = np.stack([time**2, 1 - time, time**3], axis=-1)
    velocity = np.stack([2 * time, 0 * time - 1, 3 * time**2], axis=-1)
    quaternion = turn.as_quat()[:, [3, 0, 1, 2]]
    quaternion[50:] *= -1  # the same orientations
    made = c.twist_from_pose(position, quaternion, 100.0, 0.1)
    np.testing.assert_allclose(made[:, :3], turn.inv().apply(velocity), atol=1e-9)
    np.testing.assert_allclose(made[:, 3:], np.tile(own, (200, 1)), atol=1e-6)


def test_acceleration_of_a_body_on_a_circle_points_to_its_middle():
    time = np.arange(200) / 100
    angle = 3.0 * time + 0.4 * time**2
    place = 2.0 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    twist = c.twist_from_pose(place, np.mod(angle, 2 * np.pi), 100.0, 0.06)
    np.testing.assert_allclose(twist[5:-5, 1], 2 * (3 + 0.8 * time[5:-5]), atol=1e-4)
    felt = c.acceleration(twist, 100.0, 0.06)[8:-8]
    np.testing.assert_allclose(felt[:, 0], -2 * (3 + 0.8 * time[8:-8]) ** 2, atol=1e-3)
    np.testing.assert_allclose(felt[:, 1:], np.tile([1.6, 0.8], (184, 1)), atol=2e-2)


def test_values_between_samples_are_on_the_line_and_orientations_on_the_arc():
    time = np.array([0.0, 0.1, 0.3])
    values = np.array([[0.0, 1.0], [2.0, 1.0], [4.0, -1.0]])
    at = np.array([0.0, 0.05, 0.1, 0.2, 0.3, 0.31])
    made = c.resampled(time, values, at)
    np.testing.assert_allclose(made[:5], [[0, 1], [1, 1], [2, 1], [3, 0], [4, -1]], **EXACT)
    assert np.isnan(made[5]).all()
    turn = Rotation.from_rotvec([[0, 0, 0], [0, 0, 2.0], [0, 1.0, 2.0]])
    quaternion = turn.as_quat()[:, [3, 0, 1, 2]] * [[1], [-1], [1]]
    got = c.resampled_orientation(time, quaternion, at)
    assert np.isnan(got[5]).all()
    half = turn[1] * Rotation.from_rotvec((turn[1].inv() * turn[2]).as_rotvec() / 2)
    wanted = [turn[0], Rotation.from_rotvec([0, 0, 1.0]), turn[1], half, turn[2]]
    same = [abs(row @ each.as_quat()[[3, 0, 1, 2]]) for row, each in zip(got, wanted, strict=False)]
    np.testing.assert_allclose(same, 1.0, **EXACT)
    angle = c.resampled_orientation(time, np.array([3.0, -3.0, -2.8]), np.array([0.05]))
    np.testing.assert_allclose(np.mod(angle, 2 * np.pi), np.pi)
