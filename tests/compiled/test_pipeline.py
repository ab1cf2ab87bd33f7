"""What our pipeline leaves out of numba's, and what it remembers."""

import operator
from typing import Any

import numpy as np
import pytest
from numba import TypingError
from numba.core.types import functions

from coopenv.compiled import compiled, inlined


@pytest.fixture
def asked(monkeypatch):
    """How often numba looks for what each operator makes of types, ready to note failures."""
    counts = {}

    looking: Any = functions

    class Counting(looking._ResolutionFailures):
        def __init__(self, context, function_type, args, kwargs, depth):
            super().__init__(context, function_type, args, kwargs, depth)
            key = function_type.typing_key, *args
            counts[key] = counts.get(key, 0) + 1

    monkeypatch.setattr(functions, "_ResolutionFailures", Counting)
    return counts


def test_a_kernel_may_add_whole_arrays():
    @compiled
    def combined(a, b):
        return a + 2.0 * b - np.sqrt(b)

    a, b = np.arange(5.0), np.arange(5.0) ** 2
    np.testing.assert_allclose(combined(a, b), a + 2 * b - np.sqrt(b), rtol=1e-15)


def test_a_kernel_may_have_functions_of_its_own():
    @compiled
    def applied(x):
        def doubled(y):
            return 2.0 * y + x

        return doubled(x) + sum([doubled(float(i)) for i in range(3)])

    assert applied(3.0) == 9.0 + (3.0 + 5.0 + 7.0)


def test_what_an_operator_makes_of_types_is_asked_once(asked):
    @inlined
    def part(x, y):
        return x * y + x * x - y * y

    @compiled
    def entry(x, y):
        return part(x, y) * (x * y) + part(y, x)

    assert entry(2.0, 3.0) == (6 + 4 - 9) * 6 + (6 + 9 - 4)
    products = [count for (called, *_), count in asked.items() if called is operator.mul]
    assert sum(products) <= 1  # none if another kernel has asked before


def test_what_an_index_makes_of_an_array_is_asked_once(asked):
    @inlined
    def part(array, k):
        return array[k, 0] + array[k, 1]

    @compiled
    def entry(array, k):
        return part(array, k) + array[k, 0] * array[k, 1] + array[k][0]

    assert entry(np.array([[1.0, 2.0], [3.0, 5.0]]), 1) == 3 + 5 + 15 + 3
    reads = [count for (called, *_), count in asked.items() if called is operator.getitem]
    assert all(count == 1 for count in reads)


def test_what_an_operator_cannot_do_is_refused_every_time():
    @compiled
    def shifted(x, y):
        return x << y

    for _ in range(2):
        with pytest.raises(TypingError, match="lshift"):
            shifted(2.0, 3.0)
