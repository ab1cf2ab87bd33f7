"""Constraint violation method against its original formula."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput

BEAM = np.array([[-1.0, 0.0], [1.0, 0.0]])
UNIT = {"masses": [1.0, 1.0], "inertias": [1.0, 1.0]}


def cross(vector):
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def test_footnote_2():
    internal = wrench.constraint_violation([[8 / 3, 0, 0], [4 / 3, 0, 0]], BEAM, **UNIT)
    np.testing.assert_allclose(internal, [[2 / 3, 0, 0], [-2 / 3, 0, 0]], atol=1e-15)
    assert abs(internal[1, 0]) > 0.0  # though effector 2 applied no force at all


def test_it_is_the_constraint_force_of_the_original_formula():
    rng = np.random.default_rng(0)
    n = 3
    grips, desired, omega = rng.normal(size=(n, 3)), rng.normal(size=(n, 6)), rng.normal(size=3)
    masses, root = rng.uniform(1, 3, n), rng.normal(size=(n, 3, 3))
    inertias = root @ root.transpose(0, 2, 1) + np.eye(3)
    matrix, rest, mass = np.zeros((12, 18)), np.zeros(12), np.zeros((18, 18))
    for i in range(1, n):  # every effector moves with the first
        row, arm = 6 * (i - 1), grips[i] - grips[0]
        matrix[row : row + 6, 6 * i : 6 * i + 6] = np.eye(6)
        matrix[row : row + 6, :6] = -np.eye(6)
        matrix[row : row + 3, 3:6] = cross(arm)
        rest[row : row + 3] = np.cross(omega, np.cross(omega, arm))
    for i in range(n):
        mass[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = masses[i] * np.eye(3)
        mass[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = inertias[i]
    inner = np.linalg.inv(matrix @ np.linalg.inv(mass) @ matrix.T)
    on_effectors = matrix.T @ inner @ (rest - matrix @ desired.ravel())
    found = wrench.constraint_violation(
        desired, grips, masses=masses, inertias=inertias, angular_velocity=omega
    )
    np.testing.assert_allclose(found.ravel(), -on_effectors, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_it_balances_and_vanishes_for_rigid_motions(dimension):
    rng = np.random.default_rng(1)
    grips, size = rng.normal(size=(4, dimension)), 3 * dimension - 3
    given = {"masses": rng.uniform(1, 2, 4), "inertias": rng.uniform(1, 2, 4)}
    internal = wrench.constraint_violation(rng.normal(size=(5, 4, size)), grips, **given)
    np.testing.assert_allclose(wrench.object_wrench(internal, grips), 0.0, atol=1e-13)
    motion = wrench.grasp_matrix(grips).T @ rng.normal(size=size)
    rigid = wrench.constraint_violation(motion.reshape(4, size), grips, **given)
    np.testing.assert_allclose(rigid, 0.0, atol=1e-13)


def test_turning_at_constant_speed_needs_centripetal_acceleration():
    desired = np.zeros((3, 2, 3))
    desired[..., :2] = -4.0 * BEAM
    found = wrench.constraint_violation(desired, BEAM, angular_velocity=[2.0, -2.0, 2.0], **UNIT)
    np.testing.assert_allclose(found, 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"desired_acceleration": np.zeros((2, 6))}, "desired_acceleration must be of shape"),
        ({"desired_acceleration": np.full((2, 3), np.nan)}, "desired_acceleration must be finite"),
        ({"masses": [1.0, 0.0]}, "masses must be 2 positive numbers"),
        ({"inertias": [1.0]}, "inertias must be 2 positive numbers"),
        ({"desired_acceleration": np.zeros((4, 2, 3)), "angular_velocity": [1, 2]}, "angular_vel"),
    ],
)
def test_bad_input_is_refused(change, message):
    given = {"desired_acceleration": np.zeros((2, 3)), "grips": BEAM, **UNIT, **change}
    with pytest.raises(InvalidInput, match=message):
        wrench.constraint_violation(**given)
    with pytest.raises(InvalidInput, match=r"angular_velocity must be of shape \(\.\.\., 3\)"):
        wrench.constraint_violation(np.zeros((2, 6)), np.zeros((2, 3)), angular_velocity=1, **UNIT)


def test_as_many_spins_as_sets_of_grips_are_needed():
    grips = np.broadcast_to(BEAM, (3, *np.shape(BEAM)))
    with pytest.raises(InvalidInput, match="angular_velocity must be of a batch shape"):
        wrench.constraint_violation(
            np.zeros((2, 3)), grips, angular_velocity=[1.0, 2.0, 3.0, 4.0], **UNIT
        )
