"""What compiled code reads and writes through pointers is what lies in memory."""

import numpy as np
from numba import njit

from coopenv.compiled.lanes.memory import after, array_at, four_at, lane, table_at


@njit
def _sum_two_fields(address):
    four = four_at(address)
    after(four, 2)[0] = four[0] + four[1]


def test_the_fields_of_four_lie_side_by_side():
    memory = np.arange(16.0).reshape(4, 4)
    expected = memory.copy()
    expected[2] = memory[0] + memory[1]
    _sum_two_fields(memory.ctypes.data)
    np.testing.assert_array_equal(memory, expected)


@njit
def _single(address):
    one = lane(four_at(address), 2)
    one[1] = one[0] * 2
    one[2] += one[1]


def test_one_of_four_is_read_and_written_alone():
    memory = np.arange(12.0).reshape(3, 4)
    expected = memory.copy()
    expected[1, 2] = 2.0 * memory[0, 2]
    expected[2, 2] += expected[1, 2]
    _single(memory.ctypes.data)
    np.testing.assert_array_equal(memory, expected)


@njit
def _transpose_corner(address):
    t = table_at(address)
    for r in range(2):
        t[0, r + 1], t[r + 1, 0] = t[r + 1, 0], t[0, r + 1]


def test_a_table_has_rows_of_six():
    memory = np.arange(36.0).reshape(6, 6)
    expected = memory.copy()
    expected[0, 1:3], expected[1:3, 0] = memory[1:3, 0], memory[0, 1:3]
    _transpose_corner(memory.ctypes.data)
    np.testing.assert_array_equal(memory, expected)


@njit
def _double(address):
    array = array_at(address, (2, 3))
    array[:] *= 2.0


def test_an_array_at_an_address_is_the_memory_there():
    memory = np.arange(8.0)
    _double(memory[1:].ctypes.data)
    np.testing.assert_array_equal(memory, [0, 2, 4, 6, 8, 10, 12, 7])
