"""Prioritised torque method: the limit of the optimum as torque gets all the weight."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from tests.wrench.cases import pair_cases

BEAM = [[-0.9, 0.0], [0.9, 0.0]]


def pure_torque(d):
    return np.abs(d.manipulation[..., 2]).sum(axis=-1)


def force(d):
    return np.hypot(d.manipulation[..., 0], d.manipulation[..., 1]).sum(axis=-1)


def test_it_is_the_limit_of_the_optimum_as_torque_gets_all_the_weight():
    for case in pair_cases(np.random.default_rng(0), 40):
        found = wrench.decompose(case.applied, case.grips, method="prioritized_torque")
        limit = wrench.decompose(case.applied, case.grips, torque_weight=1 - 1e-9)
        scale = np.abs(case.applied).max()
        np.testing.assert_allclose(
            pure_torque(found), pure_torque(limit), atol=1e-8 * scale, err_msg=case.name
        )
        np.testing.assert_allclose(force(found), force(limit), atol=1e-6 * scale, err_msg=case.name)
        assert max(r.max() for r in found.residuals()) <= 1e-12 * scale, case.name


def test_forces_take_over_the_torque_they_can():
    # f_y of 1 and −1 N make 1.8 N·m against the 1 N·m applied: a part of the couple cancels it
    d = wrench.decompose([[0, 1, 1], [0, -1, 0]], BEAM, method="prioritized_torque")
    assert pure_torque(d) == 0.0
    np.testing.assert_allclose(d.internal[:, 1], [1 / 1.8, -1 / 1.8])


def test_the_weights_of_the_cost_do_not_matter():
    applied = np.random.default_rng(1).normal(size=(50, 2, 3))
    settings = [(0.1, False), (0.9, True)]
    found = [
        wrench.decompose(
            applied, BEAM, method="prioritized_torque", torque_weight=w, include_induced=s
        )
        for w, s in settings
    ]
    np.testing.assert_array_equal(found[0].manipulation, found[1].manipulation)
    assert (found[0].gap == 0.0).all()
    assert (found[0].relative_cost >= 0.0).all()


@pytest.mark.parametrize("grips", [np.eye(3, 2), np.zeros((2, 3)), [[-0.9, 0.1], [0.9, 0.1]]])
def test_grips_it_is_not_defined_for_are_refused(grips):
    with pytest.raises(InvalidInput, match="grips must be two planar positions on one line"):
        wrench.decompose(np.zeros((len(grips), 3)), grips, method="prioritized_torque")
