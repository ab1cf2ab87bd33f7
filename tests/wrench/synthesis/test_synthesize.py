"""Synthesis of wrenches with wanted resultant, load shares and internal wrench."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from tests.wrench.cases import LEVERS, grips_on_line, pair_families
from tests.wrench.synthesis.cases import assert_comes_back

BEAM = np.array([[-0.9, 0.0], [0.9, 0.0]])
FORWARD = [2.0, 0.0, 0.0]


def assert_round_trip(applied, grips, **cost):
    d = wrench.decompose(applied, grips, **cost)
    share = d.load_share
    found = wrench.synthesize(
        d.object_wrench,
        grips,
        force_share=share.force,
        torque_share=share.torque,
        internal=d.internal,
        **cost,
    )
    assert_comes_back(found, grips, d.object_wrench, d.internal, *share, **cost)


@pytest.mark.parametrize("name", list(pair_families(np.random.default_rng(0), 1)))
def test_reachable_wishes_of_a_pair_come_back(name):
    # 11 families at 10 pairs of levers, 95 of each: 10,450 wishes that some wrench fulfils
    rng = np.random.default_rng(1)
    for k, levers in enumerate(LEVERS):
        applied = pair_families(rng, 95)[name]
        cost = {"torque_weight": (0.5, 0.3, 0.8)[k % 3], "include_induced": k % 2 == 1}
        assert_round_trip(applied, grips_on_line(levers, 0.7 * k), **cost)


@pytest.mark.parametrize("given", [(True, False), (False, True), (False, False)])
def test_shares_may_be_left_open(given):
    applied = np.random.default_rng(2).normal(size=(300, 2, 3))
    d = wrench.decompose(applied, BEAM)
    force, torque = (
        share if keep else None for share, keep in zip(d.load_share, given, strict=True)
    )
    found = wrench.synthesize(
        d.object_wrench, BEAM, force_share=force, torque_share=torque, internal=d.internal
    )
    assert_comes_back(found, BEAM, d.object_wrench, d.internal, force, torque)


@pytest.mark.parametrize("num_effectors", [1, 2, 3, 7])
@pytest.mark.parametrize("dimension", [2, 3])
def test_any_number_of_effectors_shares_as_wanted_with_nothing_internal(num_effectors, dimension):
    rng = np.random.default_rng(3)
    grips = rng.normal(size=(num_effectors, dimension))
    wanted = rng.normal(size=(8, 3 * dimension - 3))
    force = rng.dirichlet(np.ones(num_effectors), 8)
    found = wrench.synthesize(wanted, grips, force_share=force)
    assert_comes_back(found, grips, wanted, force=force)
    d = wrench.decompose(found, grips)
    assert d.relative_cost.max() <= 1e-7
    # a torque share is certain to be possible where some wrench without internal part has it
    torque = d.load_share.torque
    found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
    assert_comes_back(found, grips, wanted, force=force, torque=torque)


def test_open_force_shares_make_room_for_the_torque_shares():
    wanted = [0.0, 1.0, 0.3]  # equal force shares make ±0.45 N·m, more than effector 2 is to supply
    found = wrench.synthesize(wanted, BEAM, torque_share=[0.5, 0.5])
    assert_comes_back(found, BEAM, wanted, torque=np.array([0.5, 0.5]))


def test_nothing_wanted_is_nothing_done():
    np.testing.assert_array_equal(wrench.synthesize(np.zeros(3), BEAM), np.zeros((2, 3)))
    assert wrench.synthesize(np.zeros((0, 3)), BEAM).shape == (0, 2, 3)


def test_batches_broadcast():
    force = np.array([[0.3, 0.7], [np.nan, np.nan], [1.0, 0.0]])
    wanted = np.random.default_rng(4).normal(size=(5, 1, 3))
    found = wrench.synthesize(wanted, np.tile(BEAM, (3, 1, 1)), force_share=force)
    assert found.shape == (5, 3, 2, 3)
    assert_comes_back(found, BEAM, wanted, force=np.broadcast_to(force, (5, 3, 2)))


def test_internal_force_along_the_resultant_leaves_its_adversary_without_share():
    squeeze = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    found = wrench.synthesize(FORWARD, BEAM, internal=squeeze)
    np.testing.assert_allclose(found, [[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], atol=1e-9)
    with pytest.raises(InvalidInput, match=r"^force_share must .* pulls against it, whose share"):
        wrench.synthesize(FORWARD, BEAM, internal=squeeze, force_share=[0.6, 0.4])


def test_internal_force_across_the_resultant_goes_with_any_force_share():
    across = np.array([[0.0, 0.5, -0.45], [0.0, -0.5, -0.45]])
    across[:, 2] = 0.45  # 0.9 m · (0.5 + 0.5) N turns one way, the pure torques the other
    for share in ([0.2, 0.8], [1.0, 0.0]):
        found = wrench.synthesize(FORWARD, BEAM, internal=across, force_share=share)
        assert_comes_back(found, BEAM, FORWARD, across, force=np.array(share))


def test_the_wish_that_stands_in_the_way_is_named():
    with pytest.raises(InvalidInput, match=r"^torque_share must go with the rest .* possible are"):
        # forces of ½ N at ±0.9 m make ∓0.45 N·m: 0.05 N·m each needs pure torques that cancel
        wrench.synthesize([0, 1, 0.1], BEAM, force_share=[0.5, 0.5], torque_share=[0.5, 0.5])
    both = [[2, 0, 0], [-2, 0, 0]]
    with pytest.raises(InvalidInput, match=r"^force_share must go with the rest of the wish"):
        wrench.synthesize([1, 1, 0], BEAM, internal=both, force_share=[0.5, 0.5])


@pytest.mark.parametrize("levers", LEVERS)
def test_any_internal_wrench_goes_with_any_object_wrench_where_shares_are_open(levers):
    rng = np.random.default_rng(5)
    wanted = rng.integers(-2, 3, (60, 3)).astype(float)
    internal = rng.integers(-2, 3, (60, 2, 3)).astype(float)
    internal[:, 1, :2] = -internal[:, 0, :2]
    moment = (levers[0] - levers[1]) * internal[:, 0, 1]
    internal[:, 1, 2] = -internal[:, 0, 2] - moment
    grips = grips_on_line(levers, 0.0)
    found = wrench.synthesize(wanted, grips, internal=internal)
    assert_comes_back(found, grips, wanted, internal)


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"object_wrench": np.zeros(6)}, r"object_wrench must be of shape \(\.\.\., 3\)"),
        ({"object_wrench": [np.nan, 0, 0]}, "object_wrench must be finite"),
        ({"force_share": [0.5, 0.6]}, "force_share must not be negative and sum to 1"),
        ({"force_share": [1.5, -0.5]}, "force_share must not be negative and sum to 1"),
        ({"force_share": [np.nan, 0.5]}, "force_share must not be negative and sum to 1"),
        ({"force_share": "half"}, "force_share must be an array of numbers"),
        ({"torque_share": [1.0]}, r"torque_share must be of shape \(\.\.\., 2\)"),
        ({"torque_share": [0.5, 0.5]}, "torque_share must be left out where object_wrench has no"),
        ({"internal": [[1, 0, 0], [0, 0, 0]]}, "internal must balance"),
        ({"internal": np.zeros((2, 2))}, r"internal must be of shape \(\.\.\., 2, 3\)"),
        ({"internal": np.zeros((4, 2, 3)), "force_share": np.ones((3, 2)) / 2}, "must broadcast"),
        ({"torque_weight": 1.0}, r"torque_weight must be in \]0, 1\["),
    ],
)
def test_bad_wishes_are_refused(wish, message):
    with pytest.raises(InvalidInput, match=message):
        wrench.synthesize(**{"object_wrench": FORWARD, "grips": BEAM, **wish})


def test_internal_wrench_of_more_effectors_is_not_searched_and_says_so():
    grips = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])
    squeeze = np.concatenate([-grips, np.zeros((3, 1))], axis=1)
    with pytest.raises(InvalidInput, match="internal must be 0 or left out unless the grips are"):
        wrench.synthesize(FORWARD, grips, internal=squeeze)
