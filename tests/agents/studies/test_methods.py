"""A trial decomposed by several methods."""

import numpy as np
import pytest

from coopenv.agents.studies.methods import COMPARED, LOOKS, decompose_by_methods, largest, smallest
from coopenv.errors import InvalidInput, UnknownName
from coopenv.wrench import Settings, decompose

GRIPS = np.array([(-0.9, 0.0), (0.9, 0.0)])
APPLIED = np.random.default_rng(0).normal(size=(20, 2, 3))


def test_each_method_gives_what_decompose_gives():
    found = decompose_by_methods(APPLIED, GRIPS)
    assert tuple(found) == COMPARED
    for name, split in found.items():
        expected = decompose(APPLIED, GRIPS, method=name)
        np.testing.assert_array_equal(split.internal, expected.internal)
        assert split.internal_force_level.shape == (20,)


def test_settings_may_be_given_by_name_and_grips_by_sample():
    methods = {"heavy": Settings(method="parametrized", virtual_masses=(4.0, 4.0))}
    grips = np.repeat(GRIPS[None], 20, axis=0)
    found = decompose_by_methods(APPLIED, grips, methods)["heavy"]
    expected = decompose(APPLIED, GRIPS, method="parametrized", virtual_masses=(4.0, 4.0))
    np.testing.assert_allclose(found.internal, expected.internal, atol=1e-12)


def test_every_method_compared_has_a_look():
    assert set(COMPARED) <= set(LOOKS)
    assert len({(look.color, look.line) for look in LOOKS.values()}) == len(LOOKS)


def test_bad_input_is_refused():
    with pytest.raises(UnknownName, match="optimal"):
        decompose_by_methods(APPLIED, GRIPS, ["optimum"])
    with pytest.raises(InvalidInput, match="time, effector"):
        decompose_by_methods(APPLIED[0], GRIPS)
    with pytest.raises(InvalidInput, match="prioritized_torque"):
        decompose_by_methods(APPLIED, GRIPS + np.array([0.0, 0.3]))


def test_extremes_of_nothing_are_not_a_number():
    level = np.array([0.5, -2.0, 1.0])
    assert (largest(level), smallest(level)) == (2.0, 0.5)
    nowhere = np.zeros(3, dtype=bool)
    assert np.isnan([largest(level, nowhere), smallest(level, nowhere)]).all()
