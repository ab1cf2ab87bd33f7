"""Cone programs of wrenches: in which axes and units Clarabel sees them."""

import numpy as np
import pytest

from coopenv.wrench.conic.bound import default_duals
from coopenv.wrench.conic.parts import Parts, Prices, cost_of, parts_of
from coopenv.wrench.conic.program import wrench_program

PRICES = Prices(0.5, 0.5, 0.5)


def force_columns(applied, grips):
    """What a unit of each variable of the first force stands for, in parts of its length."""
    wrenches, places = applied[None], grips[None]
    whole = parts_of(wrenches, places)
    duals = default_duals(whole, PRICES)
    own = type(duals)(*(values[0] for values in duals))
    sample, cost = Parts(*(part[0] for part in whole)), float(cost_of(whole, PRICES)[0])
    _, parts = wrench_program(sample, grips, PRICES, cost, own)
    return parts[0][0].block / np.linalg.norm(sample.force[0])


def leaning(rng, sine, dimension):
    """A pair whose first force has that sine of the angle to its lever."""
    grips, applied = rng.normal(size=(2, dimension)), rng.normal(size=(2, 3 * dimension - 3))
    along = grips[0] / np.linalg.norm(grips[0])
    across = rng.normal(size=dimension)
    across -= (across @ along) * along
    across /= np.linalg.norm(across)
    applied[0, :dimension] = 7.0 * (np.sqrt(1.0 - sine * sine) * along + sine * across)
    return applied, grips, along


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("sine", [0.05, 0.5, 1.0])
def test_an_ordinary_force_has_the_axes_of_the_object(sine, dimension):
    # those along and across its lever gain nothing there
    applied, grips, _ = leaning(np.random.default_rng(0), sine, dimension)
    np.testing.assert_allclose(force_columns(applied, grips), np.eye(dimension), rtol=1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("sine", [0.02, 1e-5, 1e-10])
def test_a_force_nearly_along_its_lever_is_measured_in_its_sine_across(sine, dimension):
    applied, grips, along = leaning(np.random.default_rng(1), sine, dimension)
    columns = force_columns(applied, grips)
    np.testing.assert_allclose(columns[:, 0], along, rtol=1e-14)
    np.testing.assert_allclose(along @ columns[:, 1:], 0.0, atol=1e-15 * sine)
    np.testing.assert_allclose(np.linalg.norm(columns[:, 1:], axis=0), sine, rtol=1e-5)
