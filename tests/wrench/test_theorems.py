"""What the paper proves or claims about the optimum, on random wrenches."""

import numpy as np
import pytest

from coopenv import wrench
from tests.wrench.cases import pair_cases

WEIGHTS = (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98)
LEVER = 0.8
SYMMETRIC = np.array([[-LEVER, 0.0], [LEVER, 0.0]])


def total(d, part):
    return np.linalg.norm(d.manipulation[..., part], axis=-1).sum(axis=-1)


def spread_over_weights(applied, include_induced):
    """How much Σ‖f_M‖ and Σ‖t_M‖ vary with the torque weight, per sample."""
    found = [
        wrench.decompose(applied, SYMMETRIC, torque_weight=w, include_induced=include_induced)
        for w in (1e-4, *WEIGHTS, 1 - 1e-4)
    ]
    forces = np.array([total(d, slice(2)) for d in found])
    torques = np.array([total(d, slice(2, 3)) for d in found])
    return np.ptp(forces, axis=0), np.ptp(torques, axis=0)


def depends_on_weight(applied):
    """Equation 24 as corrected, for s = 0 and grips symmetric about the centre of mass."""
    induced = np.array([-LEVER, LEVER]) * applied[..., 1]
    torque = applied[..., 2]
    smaller = np.take_along_axis(induced, np.abs(induced).argmin(axis=-1)[:, None], axis=-1)[:, 0]
    sign = np.sign(induced[:, 0])
    same = (sign != 0) & (sign == np.sign(induced[:, 1]))
    answer = np.zeros(len(applied), dtype=bool)
    for k, j in ((0, 1), (1, 0)):
        order = (np.sign(torque[:, k]) == sign) & (np.sign(torque[:, j]) == -sign)
        answer |= same & order & (np.abs(2 * smaller + torque[:, k]) > np.abs(torque[:, j]))
    return answer


def test_the_weight_matters_exactly_where_equation_24_says():
    applied = np.random.default_rng(0).normal(size=(4000, 2, 3))
    force, torque = spread_over_weights(applied, include_induced=False)
    expected = depends_on_weight(applied)
    assert 100 < expected.sum() < 2000
    assert max(force[~expected].max(), torque[~expected].max()) <= 1e-9
    assert (torque[expected] > 1e-9).all()


def test_with_induced_torque_counted_the_weight_never_matters():
    applied = np.random.default_rng(1).normal(size=(4000, 2, 3))
    force, torque = spread_over_weights(applied, include_induced=True)
    assert max(force.max(), torque.max()) <= 1e-9


def test_equation_24_needs_symmetric_grips():
    applied = np.random.default_rng(2).normal(size=(2000, 2, 3))
    walker = [[-0.5, 0.0], [0.0, 0.0]]
    found = [
        total(wrench.decompose(applied, walker, torque_weight=w, include_induced=True), slice(2))
        for w in (0.1, 0.9)
    ]
    assert np.abs(found[0] - found[1]).max() > 0.1


def assert_monotone(applied, grips, tolerance, include_induced=False):
    """Σ‖f_M‖ does not fall, nor the torque that is costed rise, as w grows (section III-D)."""
    found = [
        wrench.decompose(applied, grips, torque_weight=w, include_induced=include_induced)
        for w in WEIGHTS
    ]
    scale = np.abs(applied).max()
    force = np.array([total(d, slice(grips.shape[-1])) for d in found]) / scale
    torque = np.array([total(d, slice(grips.shape[-1], None)) for d in found]) / scale
    if include_induced:
        torque += np.array([induced_total(d) for d in found]) / scale
    assert (np.diff(force, axis=0) >= -tolerance).all()
    assert (np.diff(torque, axis=0) <= tolerance).all()


def induced_total(d):
    """Σ‖t_fM‖."""
    return np.linalg.norm(wrench.induced_torque(d.manipulation, d.grips), axis=-1).sum(axis=-1)


@pytest.mark.parametrize("include_induced", [False, True])
def test_with_growing_torque_weight_force_does_not_fall_and_torque_does_not_rise(include_induced):
    for case in pair_cases(np.random.default_rng(3), 40):
        assert_monotone(case.applied, case.grips, 1e-9, include_induced)


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_monotonicity_holds_for_more_effectors(dimension, include_induced):
    rng = np.random.default_rng(4)
    for n in (3, 5):
        grips = rng.normal(size=(n, dimension))
        applied = rng.normal(size=(100, n, 3 * dimension - 3))
        assert_monotone(applied, grips, 1e-6, include_induced)


def test_with_induced_torque_counted_either_torque_alone_may_rise_with_its_weight():
    # section III-D says of each torque sum by itself that it does not
    rising = [
        [-4.611, -4.489, 0.446],
        [-2.913, -4.995, -2.615],
        [3.015, -3.099, -0.546],
        [2.366, 0.947, 0.953],
    ]
    grips = [[0.406, 0.841], [-0.564, 0.861], [0.860, 1.624], [0.413, 0.025]]
    pure, induced = torques_over_weights(np.array(rising), np.array(grips))
    # of this wrench before it was rounded to three decimals
    np.testing.assert_allclose(pure, [0.050, 0.506, 0.764, 0.907, 0.992], atol=4e-3)
    assert (np.diff(pure) > 0.05).all()
    assert (np.diff(pure + induced) < 0.0).all()

    rng = np.random.default_rng(0)
    applied, grips = rng.normal(size=(300, 3, 3)), rng.normal(size=(300, 3, 2))
    pure, induced = torques_over_weights(applied, grips)
    assert (np.diff(pure, axis=0) > 1e-3).any(axis=0).mean() > 0.05
    assert (np.diff(induced, axis=0) > 1e-3).any(axis=0).mean() > 0.1


def torques_over_weights(applied, grips):
    """Σ‖t_M‖ and Σ‖t_fM‖ at w = 0.1, 0.3, 0.5, 0.7 and 0.9 for s = 1."""
    found = [
        wrench.decompose(applied, grips, torque_weight=w, include_induced=True)
        for w in (0.1, 0.3, 0.5, 0.7, 0.9)
    ]
    pure = np.array([total(d, slice(2, 3)) for d in found])
    return pure, np.array([induced_total(d) for d in found])


@pytest.mark.parametrize(("num_effectors", "dimension"), [(2, 2), (3, 2), (5, 2), (2, 3), (4, 3)])
@pytest.mark.parametrize("include_induced", [False, True])
def test_wrenches_of_virtual_masses_are_free_of_internal_wrench(
    num_effectors, dimension, include_induced
):
    rng = np.random.default_rng(num_effectors)
    masses = rng.uniform(1.0, 4.0, num_effectors)
    grips = rng.normal(size=(num_effectors, dimension))
    grips -= masses @ grips / masses.sum()
    applied = wrench.allocate(
        rng.normal(size=(20, 3 * dimension - 3)),
        grips,
        "parametrized",
        virtual_masses=masses,
        virtual_inertias=rng.uniform(0.5, 2.0, num_effectors),
    )
    for weight in (0.05, 0.5, 0.95):
        d = wrench.decompose(applied, grips, torque_weight=weight, include_induced=include_induced)
        assert not d.fell_back.any()
        assert d.relative_cost.max() <= 1e-7  # the feasible set is a point: √ of the rounding
        np.testing.assert_allclose(d.manipulation, applied, atol=1e-3)
