"""Synthesis for two planar effectors off any line through the centre of mass."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from tests.wrench.cases import pair_families
from tests.wrench.synthesis.cases import assert_comes_back, miss

GRIPS = np.array([[0.8, 0.3], [-0.5, 0.9]])  # not on a line through the centre of mass


def round_trips(applied, grips, given=(True, True), **cost):
    """By how much the wishes that wrenches ``(m, 2, 3)`` fulfil miss when they come back."""
    d = wrench.decompose(applied, grips, **cost)
    force, torque = (
        share if keep else np.full_like(share, np.nan)
        for share, keep in zip(d.load_share, given, strict=True)
    )
    found = wrench.synthesize(
        d.object_wrench,
        grips,
        force_share=force,
        torque_share=torque,
        internal=d.internal,
        **cost,
    )
    return miss(found, grips, d.object_wrench, d.internal, force, torque, **cost)


OPEN = [(True, True), (True, False), (False, True), (False, False)]  # which shares are given


@pytest.mark.parametrize("given", OPEN)
@pytest.mark.parametrize("induced", [False, True])
def test_reachable_wishes_of_a_pair_off_the_axis_come_back(induced, given):
    rng = np.random.default_rng(5)
    for name, applied in pair_families(rng, 25).items():
        cost = {"torque_weight": rng.choice([0.05, 0.4, 0.5, 0.95]), "include_induced": induced}
        off = round_trips(applied, rng.normal(size=(2, 2)), given, **cost)
        assert off.max() <= 1e-6, name


@pytest.mark.slow
@pytest.mark.parametrize("given", OPEN)
@pytest.mark.parametrize("induced", [False, True])
def test_reachable_wishes_come_back_whatever_the_grips(induced, given):
    rng = np.random.default_rng(6)
    for weight in (0.05, 0.4, 0.5, 0.95):
        for name, applied in pair_families(rng, 60).items():
            grips = rng.normal(size=(len(applied), 2, 2))
            cost = {"torque_weight": weight, "include_induced": induced}
            assert round_trips(applied, grips, given, **cost).max() <= 1e-6, name


@pytest.mark.parametrize("length", [1e-6, 1e-3, 1e3, 1e6])
def test_wishes_come_back_at_any_scale(length):
    applied = np.random.default_rng(7).normal(size=(40, 2, 3)) * [1.0, 1.0, length] / length
    assert round_trips(applied, length * GRIPS).max() <= 1e-6


def test_a_squeeze_along_a_lever_comes_back():
    squeeze = np.array([[0.8, 0.3, 0.0], [-0.8, -0.3, 0.0]])
    moment = (GRIPS[0] - GRIPS[1]) @ [0.3, -0.8]
    squeeze[:, 2] = -0.5 * moment
    wanted = np.array([0.3, -0.4, 0.5])
    found = wrench.synthesize(wanted, GRIPS, internal=squeeze)
    assert_comes_back(found, GRIPS, wanted, squeeze)


def test_an_internal_torque_without_force_comes_back():
    twist = np.array([[0.0, 0.0, 0.4], [0.0, 0.0, -0.4]])
    wanted = np.array([1.0, 0.2, 0.5])
    found = wrench.synthesize(wanted, GRIPS, internal=twist)
    assert_comes_back(found, GRIPS, wanted, twist)


def test_torques_are_such_that_the_solver_splits_them_as_wanted():
    # both supply a part of the torque and keep a part: any split of the former costs the same
    applied = np.random.default_rng(8).normal(size=(120, 2, 3))
    d = wrench.decompose(applied, GRIPS)
    kept, supplied = np.abs(d.internal[..., 2]), np.abs(d.manipulation[..., 2])
    split = applied[((kept > 1e-2) & (supplied > 1e-2)).all(axis=-1)][:8]
    assert len(split) == 8
    assert round_trips(split, GRIPS, (True, False)).max() <= 1e-6


def test_what_a_pair_off_the_axis_cannot_do_is_named():
    across = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.6]])  # the forces turn by −0.6 N·m
    across[1, 2] = -(GRIPS[0] - GRIPS[1]) @ [0.0, -1.0]
    with pytest.raises(InvalidInput, match=r"^force_share must go with .* pulls against it"):
        wrench.synthesize([2.0, 0, 0.3], GRIPS, internal=across, force_share=[0.5, 0.5])


def test_internal_wrench_of_others_is_not_searched_and_says_so():
    squeeze = np.zeros((2, 6))
    squeeze[:, 0] = 1.0, -1.0
    grips = np.array([[0.5, 0, 0], [-0.5, 0, 0]])
    with pytest.raises(InvalidInput, match="unless the grips are two planar positions, got"):
        wrench.synthesize([1.0, 0, 0, 0, 0, 0], grips, internal=squeeze)


@pytest.mark.slow
@pytest.mark.parametrize("induced", [False, True])
def test_of_many_wishes_off_the_axis_hardly_any_is_refused(induced):
    rng = np.random.default_rng(7)
    cost = {"torque_weight": 0.4, "include_induced": induced}
    refused, rough, count = 0, 0, 0
    for applied in pair_families(rng, 20).values():
        for k in range(len(applied)):
            count += 1
            try:
                off = round_trips(applied[k : k + 1], rng.normal(size=(2, 2)), **cost).max()
            except InvalidInput:
                refused += 1
            else:
                rough += off > 1e-6
                assert off <= 1e-5
    assert refused <= 0.01 * count
    assert rough <= 0.01 * count
