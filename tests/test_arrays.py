"""Numbers and arrays that users give: what is taken, and what is refused by our own error."""

import timeit
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from coopenv.arrays import (
    finite_array,
    number,
    number_array,
    plain_array,
    positive,
    positive_range,
    stated_array,
    whole,
)
from coopenv.errors import InvalidInput

NO_NUMBERS = [
    pytest.param("1.0", id="text"),
    pytest.param(b"1", id="bytes"),
    pytest.param(1 + 0j, id="complex"),
    pytest.param(np.complex64(1), id="complex64"),
    pytest.param(np.timedelta64(1, "s"), id="duration"),
    pytest.param(np.datetime64(1, "s"), id="date"),
    pytest.param(None, id="nothing"),
    pytest.param({}, id="dict"),
    pytest.param(10**400, id="beyond floats"),
]


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_what_is_no_real_number_is_refused_and_not_converted(value):
    for read in (number, positive, finite_array):
        with pytest.raises(InvalidInput, match="x must"):
            read(value, "x")
    with pytest.raises(InvalidInput, match="x must"):
        finite_array(np.array([value, 2.0], dtype=object), "x")
    if not isinstance(value, int):  # an exact seed may be as large as it likes
        with pytest.raises(InvalidInput, match="x must"):
            whole(value, "x", at_least=0)


@pytest.mark.parametrize("value", [3, 3.0, np.float32(3), np.int8(3), Fraction(3), Decimal(3)])
def test_a_number_of_any_real_kind_is_taken(value):
    assert number(value, "x") == positive(value, "x") == whole(value, "x", at_least=0) == 3
    assert finite_array([value], "x").tolist() == [3.0]


def test_bounds_are_named():
    with pytest.raises(InvalidInput, match=r"dt must be at most 10, got 11; give it in s"):
        positive(11, "dt", unit="s", at_most=10)
    with pytest.raises(InvalidInput, match=r"dt must be at least 0.1, got 0.01"):
        positive(0.01, "dt", at_least=0.1)
    with pytest.raises(InvalidInput, match=r"weight must be at most 1e\+12, got 1e\+300"):
        positive(1e300, "weight")
    with pytest.raises(InvalidInput, match=r"n must be at most 7, got 8; lower it"):
        whole(8, "n", at_least=1, at_most=7)
    with pytest.raises(InvalidInput, match=r"mass must not begin below 1e-15"):
        positive_range((1e-300, 1.0), "mass", at_least=1e-15)


def test_masked_values_are_refused_and_do_not_count_again():
    masked = np.ma.masked_array([1.0, 2.0], mask=[False, True])
    for read in (finite_array, plain_array):
        with pytest.raises(InvalidInput, match="x must have no masked values, got 1"):
            read(masked, "x")
        with pytest.raises(InvalidInput, match="x must have no masked values, got 2"):
            read([[masked, [3.0, 4.0]], (masked, [5.0, 6.0])], "x")
    with pytest.raises(InvalidInput, match="x must be a number"):
        number(masked[1], "x")


def test_a_masked_element_is_found_at_any_depth_and_beside_plain_numbers():
    masked = np.ma.masked_array([1.0, 2.0], mask=[False, True])
    for value in ([1.0, np.ma.masked], [[1.0, 2.0], masked], [[(3.0, 4.0)], [masked]], ([masked],)):
        with pytest.raises(InvalidInput, match="x must have no masked values, got 1"):
            number_array(value, "x")


def test_looking_for_masked_values_costs_no_more_than_making_the_array():
    nested = np.zeros((30_000, 2, 3)).tolist()

    def seconds(make) -> float:
        return min(timeit.repeat(make, number=1, repeat=5))

    # the number of calls of Python for an element, not the speed of the machine
    assert seconds(lambda: number_array(nested, "x")) < 4 * seconds(lambda: np.asarray(nested))


def test_lists_that_hold_themselves_are_refused():
    nested: list = []
    nested.append(nested)
    with pytest.raises(InvalidInput, match="x must be an array of numbers"):
        number_array(nested, "x")


def test_an_array_without_masked_values_is_taken():
    kept = np.ma.masked_array([1.0, 2.0], mask=[False, False])
    assert finite_array(kept, "x").tolist() == plain_array(kept, "x").tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    "value", [True, np.True_, [1.0, False], ((0.5, True), (1.0, 2.0)), np.array([True, False])]
)
def test_true_and_false_are_no_numbers_of_a_parameter(value):
    with pytest.raises(
        InvalidInput, match=r"x must be made of numbers, got .*; write 1\.0 or 0\.0"
    ):
        stated_array(value, "x")
    assert finite_array(value, "x").size  # of a recording they are


def test_a_parameter_of_numbers_is_taken_in_any_form():
    for value in (2, 2.0, [1, 2.0], ((0.5, 1), (1.0, 2.0)), np.ones((2, 2)), np.float32(1)):
        np.testing.assert_array_equal(stated_array(value, "x"), finite_array(value, "x"))


def test_a_plain_array_is_handed_on_as_it_is():
    given = np.ones(3, dtype=np.float32)
    assert plain_array(given, "x") is given
    for dtype in (object, complex, "U3", "M8[s]", "m8[s]"):
        with pytest.raises(InvalidInput, match="x must be an array of numbers"):
            plain_array(np.zeros(3, dtype), "x")
