"""The lower and the higher of two numbers in compiled code."""

import math
from typing import Any

import numpy as np
import pytest
from numba import TypingError

from coopenv.compiled import compiled

NUMBERS = (-np.inf, -1.5, -0.0, 0.0, 2.0, np.inf, np.nan)


@compiled
def extremes(a, b):
    return min(a, b), max(a, b)


def same(one, other):
    return (one == other and math.copysign(1.0, one) == math.copysign(1.0, other)) or one != one


@pytest.mark.parametrize("a", NUMBERS)
@pytest.mark.parametrize("b", NUMBERS)
def test_they_are_those_that_python_takes(a, b):
    for mine, python in zip(extremes(a, b), (min(a, b), max(a, b)), strict=True):
        assert same(mine, python)
        assert np.isnan(mine) == np.isnan(python)


def test_of_an_integer_and_a_float_they_are_floats():
    assert extremes(2, 1.5) == (1.5, 2.0)
    assert extremes(3, -4) == (-4, 3)
    assert all(isinstance(one, int) for one in extremes(3, -4))


def test_constants_may_be_among_them():
    @compiled
    def clipped(x):
        return max(min(x, 1), 0.25)

    assert [clipped(x) for x in (-3.0, 0.5, 7.0)] == [0.25, 0.5, 1.0]


def test_of_more_than_two_and_of_tuples_they_are_numbas():
    @compiled
    def others(a, b, c):
        pair = (a, b)
        return min(a, b, c), max(pair), max(a, max(b, c))

    assert others(3.0, 1.0, 2.0) == (1.0, 3.0, 3.0)


def test_of_what_is_no_number_they_are_numbas():
    @compiled
    def earlier(a, b):
        return min(a, b)

    first, last = np.datetime64("2026-01-01"), np.datetime64("2026-02-01")
    assert earlier(last, first) == first

    @compiled
    def lowest(x, flag):
        other: Any = None
        if flag:
            other = x
        return min(x + 1.0, other)

    assert lowest(1.0, True) == 1.0
    with pytest.raises(TypingError, match="min"):
        earlier("a", 1.0)


def test_a_kernel_may_name_its_own_variables_so():
    @compiled
    def named(a, b):
        max = a + b
        return max

    assert named(1.0, 2.0) == 3.0
