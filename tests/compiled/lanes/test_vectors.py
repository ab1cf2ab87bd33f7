"""Four numbers at once behave like four numbers, one after the other."""

import numpy as np
import pytest
from numba import TypingError, njit

from coopenv.compiled.lanes.memory import after, four_at
from coopenv.compiled.lanes.vectors import (
    larger,
    largest,
    root,
    size,
    smaller,
    smallest,
    some,
    splat,
    total,
    where,
)

X, Y, RESULTS = 0, 1, 2  # fields of the tests' memory


def four_numbers(rng):
    return np.concatenate([rng.normal(size=(2, 4)), np.zeros((16, 4))])


@njit
def _calculate(address):
    b = four_at(address)
    x, y = b[X], b[Y]
    results = after(b, RESULTS)
    results[0] = x + y - 2.0 * x
    results[1] = x / y
    results[2] = -x * 3
    results[3] = root(size(x))
    results[4] = where((x > 0.0) & (y <= 0.5), x, y)
    results[5] = where(x < y, 1, where(x >= y, 2.0, 3.0))
    results[6] = larger(x, y)
    results[7] = smaller(x, 0.0)
    results[8] = 7.0
    results[8] += x
    results[9] = splat(total(x)) + largest(x) - smallest(y)
    results[10] = 1.0 if some(x > y) else 0.0
    results[11] = 1.0 if some(x > x + 1.0) else 0.0


def test_lanes_calculate_as_numpy_does():
    rng = np.random.default_rng(0)
    for _ in range(20):
        memory = four_numbers(rng)
        x, y = memory[:2].copy()
        _calculate(memory.ctypes.data)
        expected = [
            x + y - 2.0 * x,
            x / y,
            -3.0 * x,
            np.sqrt(np.abs(x)),
            np.where((x > 0.0) & (y <= 0.5), x, y),
            np.where(x < y, 1.0, 2.0),
            np.maximum(x, y),
            np.minimum(x, 0.0),
            7.0 + x,
            np.full(4, x.sum() + x.max() - y.min()),
            np.full(4, float((x > y).any())),
            np.zeros(4),
        ]
        np.testing.assert_allclose(memory[RESULTS : RESULTS + 12], expected, rtol=1e-14, atol=1e-14)


def test_a_lane_has_the_same_bits_whatever_is_in_the_others():
    rng = np.random.default_rng(1)
    memory = four_numbers(rng)
    other = memory.copy()
    other[:2, [0, 1, 3]] = [[np.nan, 0.0, np.inf], [0.0, 0.0, -1.0]]
    for numbers in (memory, other):
        _calculate(numbers.ctypes.data)
    np.testing.assert_array_equal(other[: RESULTS + 9, 2], memory[: RESULTS + 9, 2])


def test_what_is_not_a_number_meets_no_condition():
    memory = four_numbers(np.random.default_rng(2))
    memory[X], memory[Y] = np.nan, 5.0
    _calculate(memory.ctypes.data)
    np.testing.assert_array_equal(memory[RESULTS + 5], 3.0)
    np.testing.assert_array_equal(memory[RESULTS + 6], 5.0)
    np.testing.assert_array_equal(memory[RESULTS + 10], 0.0)


@njit
def _mixed(address):
    x = four_at(address)[X]
    return some((x < 1.0) + x > 0.0)


@njit
def _ordered(a, b):
    return a < b


def test_operators_take_lanes_and_numbers_beside_lanes_and_nothing_else():
    with pytest.raises(TypingError, match=r"add.*Mask, Lanes"):
        _mixed(np.zeros((4, 4)).ctypes.data)
    with pytest.raises(TypingError, match=r"lt.*complex128, complex128"):
        _ordered(1j, 2j)
