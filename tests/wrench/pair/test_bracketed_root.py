"""Roots of functions of one number, by the plain Python of the compiled method."""

from math import cos, exp
from typing import Any

import pytest

from coopenv.wrench.pair.bracketed_root import MAX_STEPS, root_of


def root(function, low, high, resolution=0.0):
    """The root in a bracket, and at how many places it was looked for."""
    places = []

    def watched(x, shift):
        places.append(x)
        return function(x) - shift

    values = function(low), function(high)
    compiled: Any = root_of(watched)
    found = compiled.py_func(low, values[0], high, values[1], 0.0, resolution)
    return found, len(places)


@pytest.mark.parametrize(
    ("function", "low", "high", "expected"),
    [
        (lambda x: x**3 - 2.0, 0.0, 5.0, 2.0 ** (1 / 3)),
        (lambda x: cos(x) - x, 0.0, 1.0, 0.7390851332151607),
        (lambda x: exp(-x) - 1e-3, 0.0, 100.0, 6.907755278982137),
        (lambda x: x - 0.3, -1.0, 1.0, 0.3),
    ],
)
def test_roots_are_exact_to_rounding_from_either_side_and_soon_found(function, low, high, expected):
    for ends in ((low, high), (high, low)):
        found, steps = root(function, *ends)
        assert found == pytest.approx(expected, abs=4e-16 * expected)
        assert steps < 20


@pytest.mark.parametrize("jump", [0.3, -0.7, 1e-9])
def test_a_jump_through_zero_is_found_to_two_units_in_the_last_place(jump):
    found, steps = root(lambda x: 1.0 if x > jump else -2.0, -1.0, 1.0)
    assert found == pytest.approx(jump, abs=5e-16 * abs(jump))
    assert steps < MAX_STEPS


def test_the_better_end_of_what_remains_is_given():
    found, _ = root(lambda x: x if x > 0.3 else -5.0, 0.0, 1.0, resolution=1e-3)
    assert 0.3 < found < 0.301  # where it is 0.3 and not −5


@pytest.mark.parametrize("resolution", [1e-2, 1e-6])
def test_what_is_wanted_coarsely_is_found_sooner_within_its_resolution(resolution):
    found, steps = root(lambda x: x**3 - 2.0, 0.0, 5.0, resolution)
    exact, most = root(lambda x: x**3 - 2.0, 0.0, 5.0)
    assert abs(found - exact) <= resolution
    assert steps < most
