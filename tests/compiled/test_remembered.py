"""What numba is asked once, and that it is asked again when there is something new."""

import gc
import operator
import weakref
from typing import Any

import numpy as np
import pytest
from numba import njit, objmode, types
from numba.core import errors
from numba.extending import intrinsic, overload

from coopenv.compiled import compiled, fused_entry
from coopenv.compiled.lighter import lighter


def answer():
    """To be overloaded after kernels have been compiled."""


def test_what_is_registered_between_two_kernels_is_known_to_the_second():
    @compiled
    def before(x):
        return x + 1.0

    assert before(1.0) == 2.0

    @overload(answer)
    def _():
        return lambda: 42.0

    @compiled
    def after(x):
        return x + answer()

    assert after(1.0) == 43.0


def test_an_intrinsic_that_is_new_is_known():
    @compiled
    def before(x):
        return 2.0 * x

    assert before(1.0) == 2.0

    def twice(typingctx, x):
        return x(x), lambda context, builder, signature, given: builder.fadd(given[0], given[0])

    doubled: Any = intrinsic(twice)

    @compiled
    def after(x):
        return doubled(x)

    assert after(1.5) == 3.0


def test_errors_say_where_they_come_from():
    @compiled
    def wrong(x):
        return x.nothing

    with pytest.raises(errors.TypingError, match=r"(?s)nothing.*During: typing of get attribute"):
        wrong(1.0)


def test_what_is_replaced_is_numbas_again_afterwards():
    names = [name for name in dir(errors) if not name.startswith("__")]
    before = [getattr(errors, name) for name in names]

    def fail():
        with lighter():
            assert [getattr(errors, name) for name in names] != before
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert [getattr(errors, name) for name in names] == before


@njit
def interpreted(x):
    with objmode(y="float64"):
        y = float(str(x)) + 1.0
    return y


def test_interpreted_parts_of_other_functions_know_their_variables():
    @compiled
    def whole(x):
        return 2.0 * interpreted(x)

    assert whole(1.5) == 5.0


def test_nothing_is_kept_of_a_kernel_that_is_gone():
    def made():
        held = np.arange(3.0)

        @compiled
        def last():
            return held[2]

        assert last() == 2.0
        return weakref.ref(held)

    gone = made()
    gc.collect()
    assert gone() is None


def test_an_operator_of_ones_own_is_compiled_with_the_flags_of_each_caller():
    @overload(operator.xor)
    def _(a, b):
        if isinstance(a, types.Array) and isinstance(b, types.Float):
            return lambda a, b: (a[0] + b) - a[0]
        return None

    @fused_entry
    def first(a, b):
        return a ^ b

    @compiled
    def exact(a, b):
        return a ^ b

    array = np.array([1e17])
    assert first(array, 1.0) in (0.0, 1.0)
    assert exact(array, 1.0) == 0.0


def test_kernels_of_many_types_are_each_compiled_for_theirs():
    @compiled
    def part(x, y):
        return x * y

    @compiled
    def whole(a, b, c):
        return part(a, b), part(c, c), part(b, c)

    assert whole(2, 1.5, 3) == (3.0, 9, 4.5)
    assert isinstance(whole(2, 1.5, 3)[1], int)
    np.testing.assert_array_equal(part(np.arange(3.0), 2.0), [0.0, 2.0, 4.0])
    assert types.float64 in part.signatures[0]
