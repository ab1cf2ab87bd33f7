"""Where the torque weight matters, beside optima at several weights."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput

APPLIED = np.random.default_rng(5).normal(size=(1500, 2, 3))


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.5])
def test_it_matters_exactly_where_optima_at_several_weights_differ(angle):
    lever = 0.8 * np.array([np.cos(angle), np.sin(angle)])
    grips = np.stack([-lever, lever])
    found = [
        np.abs(wrench.decompose(APPLIED, grips, torque_weight=w).manipulation[..., 2]).sum(axis=-1)
        for w in (1e-4, 0.5, 1 - 1e-4)
    ]
    named = wrench.weight_matters(APPLIED, grips)
    assert 50 < named.sum() < 750
    np.testing.assert_array_equal(np.ptp(found, axis=0) > 1e-9, named)


def test_with_induced_torque_counted_it_never_matters():
    grips = np.array([(0.0, -0.5), (0.0, 0.5)])
    assert not wrench.weight_matters(APPLIED, grips, include_induced=True).any()
    assert wrench.weight_matters(APPLIED, grips).any()


def test_of_two_negative_induced_torques_the_smaller_magnitude_counts():
    grips = np.array([(-1.0, 0.0), (1.0, 0.0)])
    # t_f = −0.5 and −3 N·m, t_k = −1: |2 · (−0.5) − 1| = 2 beside t_j = 2.5, or 1.5
    at = [[(0.0, 0.5, -1.0), (0.0, -3.0, torque)] for torque in (2.5, 1.5)]
    assert wrench.weight_matters(at, grips).tolist() == [False, True]


def test_who_give_no_force_have_no_weight_to_ask_about():
    grips = np.array([(-1.0, 0.0), (1.0, 0.0)])
    applied = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -2.0)])
    assert wrench.weight_matters(applied, grips).shape == ()
    assert not wrench.weight_matters(applied, grips)


@pytest.mark.parametrize(
    ("grips", "message"),
    [
        ([(-0.5, 0.0), (0.0, 0.0)], "r and −r"),
        ([(-0.9, 0.0), (0.9, 1e-3)], "r and −r"),
        ([(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)], "applied must be of shape"),
    ],
)
def test_other_grips_are_refused(grips, message):
    with pytest.raises(InvalidInput, match=message):
        wrench.weight_matters(APPLIED, grips)
