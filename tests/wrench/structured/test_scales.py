"""The structured solver where levers and torques are large or small beside one another."""

import itertools

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.grasp import moment, sum_at_centre
from tests.wrench.cases import LEVERS, grips_on_line, pair_families
from tests.wrench.structured.cases import families

DECADES = range(-6, 7)  # of levers, against 1 m, and of torques, against forces and 1 m
COARSE = (-6, -3, 0, 3, 6)
CERTIFIED = 1e-7  # bound in parts of J(h)
BALANCED = 5e-13  # `tolerances.BALANCED` for the largest component, here for a length
SENSIBLE = 1e8  # torque made by a force / pure torque, and the reverse


def solve(applied, grips, torque_weight=0.5, include_induced=False, solver="structured"):
    return wrench.decompose(
        applied,
        grips,
        solver=solver,
        torque_weight=torque_weight,
        include_induced=include_induced,
    )


def relative_errors(decomposition):
    """What misses from balance and what leaves a ball, in parts of the largest force or torque."""
    applied, grips = decomposition.applied, decomposition.grips
    dimension = grips.shape[-1]
    force = np.linalg.norm(applied[..., :dimension], axis=-1).max(axis=-1)
    lever = np.linalg.norm(grips, axis=-1).max(axis=-1)
    torque = np.linalg.norm(applied[..., dimension:], axis=-1).max(axis=-1)
    torque = np.maximum(np.maximum(torque, lever * force), 1e-300)
    force = np.maximum(force, torque / np.maximum(lever, 1e-300) * 1e-15)
    missing = np.abs(sum_at_centre(decomposition.internal, grips))
    left = decomposition.residuals()
    return np.max(
        [
            missing[..., :dimension].max(axis=-1) / force,
            missing[..., dimension:].max(axis=-1) / torque,
            left.force / force,
            left.induced_torque / torque,
            left.torque / torque,
        ],
        axis=0,
    )


def scaled(applied, torque_decade, dimension):
    made = applied.copy()
    made[..., dimension:] *= 10.0**torque_decade
    return made


@pytest.mark.parametrize("num_effectors", [2, 3, 5])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("decades", "count"), [(COARSE, 6), pytest.param(DECADES, 40, marks=pytest.mark.slow)]
)
def test_levers_and_torques_of_any_size_are_certified(decades, count, dimension, num_effectors):
    rng = np.random.default_rng([dimension, num_effectors])
    bound, ordinary, fell_back = [], [], []
    for lever, torque in itertools.product(decades, decades):
        applied = rng.normal(size=(count, num_effectors, 3 * dimension - 3))
        grips = rng.normal(size=(count, num_effectors, dimension)) * 10.0**lever
        applied = scaled(applied, torque, dimension)
        for weight, induced in itertools.product((0.05, 0.5, 0.95), (False, True)):
            d = solve(applied, grips, weight, induced)
            assert relative_errors(d).max() <= BALANCED
            if SENSIBLE**-1 <= 10.0 ** (lever - torque) <= SENSIBLE:
                bound.append(d.gap / d.applied_cost)
                fell_back.append(d.fell_back)
            if abs(lever - torque) <= 6:
                ordinary.append(d.gap / d.applied_cost)
    assert (np.concatenate(ordinary) > CERTIFIED).mean() <= 1e-4
    assert np.concatenate(ordinary).max() <= 1e-6
    doubtful = np.concatenate(bound) > CERTIFIED
    assert doubtful.mean() <= 2e-3  # all of them near the sensible ratios' ends
    assert (np.concatenate(bound) > 1e-5).mean() <= 1e-3
    assert np.concatenate(fell_back).mean() <= 2e-3


@pytest.mark.parametrize("dimension", [2, 3])
def test_one_effector_may_apply_a_millionth_or_a_million_times_as_much(dimension):
    rng = np.random.default_rng(dimension)
    bound = []
    for lever, decade in itertools.product(COARSE[:-1], COARSE):
        applied = rng.normal(size=(20, 3, 3 * dimension - 3))
        applied[:, 0] *= 10.0**decade
        d = solve(applied, rng.normal(size=(20, 3, dimension)) * 10.0**lever)
        assert relative_errors(d).max() <= BALANCED
        bound.append(d.gap / d.applied_cost)
    assert (np.concatenate(bound) > CERTIFIED).mean() <= 5e-3


def test_the_unit_of_force_matters_only_to_rounding():
    rng = np.random.default_rng(4)
    applied, grips = rng.normal(size=(50, 3, 6)), rng.normal(size=(50, 3, 3)) * 1e4
    once = solve(applied, grips)
    for scale in (1e-6, 1e6):
        again = solve(applied * scale, grips)
        np.testing.assert_allclose(again.relative_cost, once.relative_cost, atol=3e-9)


@pytest.mark.parametrize(
    ("count", "decades"), [(2, COARSE), pytest.param(4, DECADES, marks=pytest.mark.slow)]
)
def test_the_exact_optimum_of_pairs_is_within_the_gap_at_any_scale(count, decades):
    rng = np.random.default_rng(3)
    outside, bound = [], []
    for lever, torque in itertools.product(decades, COARSE):
        if not SENSIBLE**-1 <= 10.0 ** (lever - torque) <= SENSIBLE:
            continue
        grips = grips_on_line(LEVERS[(lever + torque) % 4], 0.0) * 10.0**lever
        for name, applied in pair_families(rng, count).items():
            if name == "uneven":  # by 10⁸ on top of all else
                continue
            applied = scaled(applied, torque, 2)
            for weight, induced in itertools.product((0.05, 0.95), (False, True)):
                ours, exact = (
                    solve(applied, grips, weight, induced, solver)
                    for solver in ("structured", "pair")
                )
                unit = np.maximum(exact.applied_cost, 1e-300)
                outside.append((np.abs(ours.cost - exact.cost) - ours.gap) / unit)
                bound.append(ours.gap / unit)
    assert (np.concatenate(outside) > 1e-9).mean() <= 1e-3
    assert np.concatenate(outside).max() <= 3e-5
    assert (np.concatenate(bound) > CERTIFIED).mean() <= 5e-3


@pytest.mark.parametrize("dimension", [2, 3])
def test_degenerate_wrenches_are_certified_at_long_and_short_levers(dimension):
    rng = np.random.default_rng(dimension)
    bound = []
    for lever in (-5, -3, 3, 5):
        for name, applied in families(rng, 8, 3, dimension).items():
            if name == "nearly agreeing":  # within 1e-9: rounding of forces is worth too much
                continue
            grips = rng.normal(size=(len(applied), 3, dimension)) * 10.0**lever
            d = solve(applied, grips)
            assert relative_errors(d).max() <= BALANCED
            bound.append(d.gap / np.maximum(d.applied_cost, 1e-300))
    assert (np.concatenate(bound) > CERTIFIED).mean() <= 5e-3


def test_a_far_common_offset_of_the_grips_does_not_matter():
    # about the centre of mass, the torque that the pair's couple makes is a difference of large
    rng = np.random.default_rng(6)
    grips = rng.normal(size=(200, 2, 3)) + 1e4 * rng.normal(size=(200, 1, 3))
    d = solve(rng.normal(size=(200, 2, 6)), grips)
    assert (d.gap <= CERTIFIED * d.applied_cost).all()
    assert not d.fell_back.any()


def test_torques_too_small_to_see_count_in_the_gap():
    # 1e-14 of what the forces make, and yet a part of the cost
    applied = np.zeros((2, 3, 3))
    applied[:, :2, 0] = [1.0, -1.0]
    applied[:, :2, 1] = 1.0
    applied[:, :2, 2] = [4e-9, -4e-9]
    d = solve(applied, [[0.0, 1e6], [1e6, 0.0], [0.0, 0.0]], torque_weight=0.95)
    neglected = 0.95 * np.abs(applied[..., 2]).sum(axis=-1)
    assert (d.gap >= 0.9 * neglected).all()
    assert (d.gap <= 4.0 * neglected).all()


def test_induced_torques_of_short_levers_stay_in_their_balls():
    rng = np.random.default_rng(7)
    applied = scaled(rng.normal(size=(100, 2, 3)), 6, 2)
    grips = rng.normal(size=(100, 2, 2)) * 1e-8
    d = solve(applied, grips, torque_weight=0.05)
    reach = np.abs(moment(grips, applied))[..., 0].max(axis=-1)
    assert (d.residuals().induced_torque <= 1e-12 * reach).all()
