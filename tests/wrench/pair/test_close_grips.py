"""Two planar grips close together, down to where only rounding parts them."""

import numpy as np
import pytest

from coopenv import wrench
from tests.wrench.cases import pair_families
from tests.wrench.pair.reference import least_cost

SEPARATIONS = (1e-17, 1e-16, 1e-15, 7e-15, 1e-13, 2e-12, 1e-11, 1e-9, 1e-6)  # [m]
ROUNDING = 1e-15  # of the longest lever: closer grips are one
AGREED = np.array([[-1.32, -1.765, -0.358], [1.172, 1.571, -0.301]])  # torques of one sign
PLACE = np.array([-0.136352088496291, 0.448969787646627])


def as_counted(grips):
    """The grips that are decomposed: one place where rounding parts them."""
    apart, levers = np.hypot(*(grips[0] - grips[1])), np.hypot(*grips.T)
    return np.tile(grips[levers.argmax()], (2, 1)) if apart <= ROUNDING * levers.max() else grips


def cases(seed, separation, directions):
    """One wrench of each family, at a pair of grips each, and the cost."""
    rng = np.random.default_rng(seed)
    for number, (name, applied) in enumerate(pair_families(rng, 1).items()):
        place = rng.normal(size=2)
        direction = rng.normal(size=2) if directions == "any" else place / np.hypot(*place)
        grips = np.array([place, place + separation * direction])
        induced = number % 4 == 3
        yield name, applied[0], grips, rng.choice([0.05, 0.5, 0.95]), induced


def decomposed(applied, grips, weight, induced):
    return wrench.decompose(applied, grips, torque_weight=weight, include_induced=induced)


@pytest.mark.parametrize("separation", SEPARATIONS)
def test_a_pair_that_only_rounding_parts_is_no_cheaper_or_dearer_than_one_place(separation):
    d = wrench.decompose(AGREED, [PLACE, PLACE + separation])
    assert d.relative_cost == pytest.approx(0.8127707608857807, abs=max(1e-13, 2 * separation))
    assert d.gap <= 1e-15 * d.applied_cost


@pytest.mark.parametrize("separation", SEPARATIONS)
def test_close_grips_cost_what_60_digits_say(separation):
    for name, applied, grips, weight, induced in cases(0, separation, "any"):
        d = decomposed(applied, grips, weight, induced)
        optimum = least_cost(applied, as_counted(grips), weight, induced)
        assert abs(d.cost - optimum) <= 2e-15 * d.applied_cost, name
        assert d.gap <= 1e-13 * d.applied_cost, name
        assert max(d.residuals()) <= 1e-15 * max(1.0, np.abs(applied).max()), name


@pytest.mark.parametrize("separation", SEPARATIONS)
def test_torques_as_small_as_what_forces_make_of_the_distance_are_no_trouble(separation):
    rng = np.random.default_rng(4)
    for applied, place, direction in zip(
        rng.normal(size=(10, 2, 3)), *rng.normal(size=(2, 10, 2)), strict=True
    ):
        applied[:, 2] *= separation
        grips = np.array([place, place + separation * direction])
        d = wrench.decompose(applied, grips)
        optimum = least_cost(applied, as_counted(grips))
        assert abs(d.cost - optimum) <= d.gap + 1e-15 * d.applied_cost
        assert d.gap <= 1e-13 * d.applied_cost


@pytest.mark.parametrize("separation", SEPARATIONS)
def test_on_nearly_a_line_the_bound_holds_however_close_the_grips(separation):
    for name, applied, grips, weight, induced in cases(1, separation, "along"):
        d = decomposed(applied, grips, weight, induced)
        optimum = least_cost(applied, as_counted(grips), weight, induced)
        assert abs(d.cost - optimum) <= d.gap + 1e-15 * d.applied_cost, name


def test_grips_closer_than_rounding_are_one():
    rng = np.random.default_rng(2)
    for applied in pair_families(rng, 30).values():
        place = rng.normal(size=(30, 1, 2))
        nudge = 10.0 ** rng.uniform(-19, -17, (30, 1, 1)) * rng.normal(size=(30, 1, 2))
        grips = np.concatenate([place, place + nudge], 1)
        apart, one = (
            wrench.decompose(applied, grips),
            wrench.decompose(applied, np.repeat(place, 2, axis=1)),
        )
        np.testing.assert_array_equal(apart.gap, 0.0)
        allowed = 1e-14 * one.applied_cost
        np.testing.assert_array_less(np.abs(apart.cost - one.cost), allowed + 1e-300)


def test_where_torques_oppose_each_other_the_cost_is_continuous_where_grips_meet():
    # where they agree the optimum jumps by itself: however close the grips, only internal forces on
    # one side of their line are plausible, or along it, and which depends on its direction
    rng = np.random.default_rng(3)
    applied, place = rng.normal(size=(2000, 2, 3)), rng.normal(size=(2000, 1, 2))
    both = np.concatenate([place, place], axis=1)
    applied[:, 1, 2] *= -np.sign(applied[:, 0, 2] * applied[:, 1, 2])
    induced = wrench.induced_torque(applied, both)[..., 0]
    applied, place = (part[induced.prod(axis=1) < 0.0] for part in (applied, place))
    direction = rng.normal(size=place.shape)
    one = wrench.decompose(applied, np.concatenate([place, place], axis=1)).relative_cost
    for separation in SEPARATIONS:
        grips = np.concatenate([place, place + separation * direction], axis=1)
        change = np.abs(wrench.decompose(applied, grips).relative_cost - one)
        assert change.max() <= max(1e3 * separation, 1e-14), separation
