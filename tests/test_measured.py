"""Splitting wrenches and measuring what comes of it, at once and one after the other."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Transport
from coopenv.errors import InvalidInput
from coopenv.measured import measured, split_and_measured
from coopenv.wrench import Decomposer, Settings

ON_A_LINE = np.array([(-0.9, 0.0), (0.9, 0.0)])


@pytest.mark.parametrize("count", [1, 5])
@pytest.mark.parametrize("alike", [True, False])
def test_wrenches_are_split_and_measured_at_once_to_the_same_bits(count, alike):
    generator = np.random.default_rng(count)
    grips = ON_A_LINE * generator.uniform(0.5, 1.5, (count, 1, 1))
    grips = np.repeat(ON_A_LINE[None], count, axis=0) if alike else grips
    decomposer = Decomposer(grips[0] if alike else grips, Settings(torque_weight=0.3))
    applied = generator.normal(size=(count, 2, 3))
    decomposition, found = split_and_measured(decomposer, applied, grips)
    other = decomposer(applied)
    np.testing.assert_array_equal(decomposition.manipulation, other.manipulation)
    assert found is not None
    for mine, theirs in zip(found, measured(other, grips, 2), strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_what_no_search_on_a_line_splits_is_left_to_its_solver():
    grips = np.array([[(-0.9, 0.1), (0.9, 0.3)]])
    applied = np.random.default_rng(0).normal(size=(1, 2, 3))
    for settings in (Settings(), Settings(method="moore_penrose")):
        decomposer = Decomposer(grips, settings)
        decomposition, found = split_and_measured(decomposer, applied, grips)
        assert found is None
        np.testing.assert_array_equal(decomposition.manipulation, decomposer(applied).manipulation)


@pytest.mark.parametrize("shape", [(2, 3, 3), (2, 1, 3), (2, 2, 6), (3, 2, 3), (1, 2, 3)])
def test_wrenches_that_are_not_those_of_the_team_are_refused(shape):
    core = Transport(num_worlds=2)
    core.reset(seed=0)
    assert core.transition is not None
    other = replace(core.transition, applied=np.ones(shape))
    with pytest.raises(InvalidInput, match=r"applied must be of shape \(2, 2, 3\), got"):
        assert other.decomposition
