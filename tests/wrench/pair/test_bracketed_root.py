"""Roots of functions of one number, by the plain Python of the compiled method."""

from itertools import pairwise
from math import cos, exp
from typing import Any

import pytest

from coopenv.wrench.pair.bracketed_root import MAX_STEPS, root_of


def root(function, low, high, resolution=0.0):
    """The root in a bracket, and the places at which it was looked for."""
    places = []

    def watched(x, shift):
        places.append(x)
        return function(x) - shift

    values = function(low), function(high)
    compiled: Any = root_of(watched)
    found = compiled.py_func(low, values[0], high, values[1], 0.0, resolution)
    return found, places


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
        found, places = root(function, *ends)
        assert found == pytest.approx(expected, abs=4e-16 * expected)
        assert len(places) < 20


@pytest.mark.parametrize("jump", [0.3, -0.7, 1e-9])
def test_a_jump_through_zero_is_found_to_two_units_in_the_last_place(jump):
    found, places = root(lambda x: 1.0 if x > jump else -2.0, -1.0, 1.0)
    assert found == pytest.approx(jump, abs=5e-16 * abs(jump))
    assert len(places) < MAX_STEPS


def test_the_better_end_of_what_remains_is_given():
    found, _ = root(lambda x: x if x > 0.3 else -5.0, 0.0, 1.0, resolution=1e-3)
    assert 0.3 < found < 0.301  # where it is 0.3 and not −5


@pytest.mark.parametrize("resolution", [1e-2, 1e-6])
def test_what_is_wanted_coarsely_is_found_sooner_within_its_resolution(resolution):
    found, places = root(lambda x: x**3 - 2.0, 0.0, 5.0, resolution)
    exact, more = root(lambda x: x**3 - 2.0, 0.0, 5.0)
    assert abs(found - exact) <= resolution
    assert len(places) < len(more)


@pytest.mark.parametrize("off", [1e-2, 1e-4, 1e-7, 1e-10])  # of the root, from an end
@pytest.mark.parametrize("bent", [0.1, 0.5])
def test_it_looks_nowhere_nearer_than_the_resolution_to_where_it_has_looked(bent, off):
    def rising(x):
        return (x - off) + bent * (x * x - off * off)

    for function, low, high in (
        (rising, 0.0, 1.0), (rising, 1.0, 0.0),
        (lambda x: -rising(1.0 - x), 0.0, 1.0), (lambda x: -rising(1.0 - x), 1.0, 0.0),
    ):  # fmt: skip
        _, places = root(function, low, high, resolution=1e-3)
        known = sorted([low, high, *places])
        assert min(b - a for a, b in pairwise(known)) > 0.99e-3
        assert (known[0], known[-1]) == (0.0, 1.0)
