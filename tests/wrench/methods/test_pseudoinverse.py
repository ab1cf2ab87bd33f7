"""Pseudoinverse methods: allocation by a generalised inverse of the grasp matrix."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput, UnknownName

ALLOCATIONS = ("moore_penrose", "nonsqueezing", "parametrized")
BEAM = [[-0.9, 0.0], [0.9, 0.0]]


def balanced_grips(num_effectors, dimension, masses):
    grips = np.random.default_rng(0).normal(size=(num_effectors, dimension))
    return grips - (masses[:, None] * grips).sum(axis=0) / masses.sum()


@pytest.mark.parametrize("method", ALLOCATIONS)
@pytest.mark.parametrize("num_effectors", [1, 2, 3, 7])
@pytest.mark.parametrize("dimension", [2, 3])
def test_allocation_supplies_what_was_wanted(method, num_effectors, dimension):
    grips = balanced_grips(num_effectors, dimension, np.ones(num_effectors))
    wanted = np.random.default_rng(1).normal(size=(4, 5, 3 * dimension - 3))
    applied = wrench.allocate(wanted, grips, method)
    assert applied.shape == (4, 5, num_effectors, 3 * dimension - 3)
    np.testing.assert_allclose(wrench.object_wrench(applied, grips), wanted, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_parametrized_follows_equation_30_for_any_masses_and_inertias(dimension):
    rng = np.random.default_rng(2)
    masses, inertias = rng.uniform(0.5, 4.0, 3), rng.uniform(0.5, 4.0, 3)
    grips = balanced_grips(3, dimension, masses)
    wanted = rng.normal(size=3 * dimension - 3)
    applied = wrench.allocate(
        wanted, grips, "parametrized", virtual_masses=masses, virtual_inertias=inertias
    )
    np.testing.assert_allclose(wrench.object_wrench(applied, grips), wanted, atol=1e-12)
    # every effector's virtual body takes part in one rigid motion
    acceleration = applied[:, :dimension] / masses[:, None]
    angular = applied[:, dimension:] / inertias[:, None]
    np.testing.assert_allclose(angular, np.tile(angular[0], (3, 1)), atol=1e-12)
    full = np.zeros((3, 3))
    full[:, :dimension] = grips
    spin = np.array([0, 0, angular[0, 0]]) if dimension == 2 else angular[0]
    expected = wanted[:dimension] / masses.sum() + np.cross(spin, full)[:, :dimension]
    np.testing.assert_allclose(acceleration, expected, atol=1e-12)


def test_parametrized_takes_inertia_matrices_in_space():
    rng = np.random.default_rng(3)
    grips = balanced_grips(2, 3, np.ones(2))
    root = rng.normal(size=(2, 3, 3))
    inertias = root @ root.transpose(0, 2, 1) + np.eye(3)
    wanted = rng.normal(size=6)
    applied = wrench.allocate(wanted, grips, "parametrized", virtual_inertias=inertias)
    np.testing.assert_allclose(wrench.object_wrench(applied, grips), wanted, atol=1e-12)
    d = wrench.decompose(applied, grips, method="parametrized", virtual_inertias=inertias)
    np.testing.assert_allclose(d.internal, 0.0, atol=1e-12)


def test_nonsqueezing_shares_force_and_torque_equally_at_the_centre_of_mass():
    applied = wrench.allocate([2.0, 4.0, 6.0], BEAM, "nonsqueezing")
    np.testing.assert_allclose(applied[:, :2], [[1.0, 2.0], [1.0, 2.0]])
    np.testing.assert_allclose(applied[:, 2], [3.0 + 0.9 * 2.0, 3.0 - 0.9 * 2.0])


def test_moore_penrose_is_the_smallest():
    wanted = np.random.default_rng(4).normal(size=(20, 3))
    size = {m: np.square(wrench.allocate(wanted, BEAM, m)).sum((-1, -2)) for m in ALLOCATIONS}
    for other in ALLOCATIONS:
        assert (size["moore_penrose"] <= size[other] + 1e-12).all()


@pytest.mark.parametrize("method", ALLOCATIONS)
def test_grips_may_differ_from_sample_to_sample(method):
    grips = np.array(BEAM) * np.array([0.5, 1.0, 2.0])[:, None, None]
    wanted = np.random.default_rng(5).normal(size=(3, 3))
    applied = wrench.allocate(wanted, grips, method)
    for index in range(3):
        one = wrench.allocate(wanted[index], grips[index], method)
        np.testing.assert_allclose(applied[index], one, atol=1e-14)


def test_bad_input_is_refused():
    wanted = [1.0, 0.0, 0.0]
    with pytest.raises(UnknownName, match="did you mean 'nonsqueezing'"):
        wrench.allocate(wanted, BEAM, "non_squeezing")
    with pytest.raises(InvalidInput, match=r"object_wrench must be of shape \(\.\.\., 3\)"):
        wrench.allocate(np.zeros(6), BEAM)
    with pytest.raises(InvalidInput, match="object_wrench must be finite"):
        wrench.allocate([np.inf, 0.0, 0.0], BEAM)
    with pytest.raises(InvalidInput, match="virtual_masses must be left out"):
        wrench.allocate(wanted, BEAM, "nonsqueezing", virtual_masses=[1.0, 1.0])
    with pytest.raises(InvalidInput, match="virtual_masses must be 2 positive numbers"):
        wrench.allocate(wanted, BEAM, "parametrized", virtual_masses=[1.0, -1.0])
    with pytest.raises(InvalidInput, match="virtual_masses must have their centre at the object"):
        wrench.allocate(wanted, BEAM, "parametrized", virtual_masses=[1.0, 2.0])
    with pytest.raises(InvalidInput, match="virtual_inertias must be 2 positive numbers"):
        wrench.allocate(wanted, BEAM, "parametrized", virtual_inertias=[1.0, 0.0])
    with pytest.raises(InvalidInput, match="object_wrench must be of a batch shape"):
        wrench.allocate(np.zeros((4, 3)), np.tile(BEAM, (3, 1, 1)))
