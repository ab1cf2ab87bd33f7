"""References in compiled code: what is counted, and that what is not counted is not missed."""

import gc
import sys
from importlib import import_module
from typing import NamedTuple

import numpy as np
import pytest
from numba.core.codegen import CPUCodeLibrary
from numba.core.runtime.nrt import rtsys

from coopenv.compiled import anywhere, compiled, fused, inlined

DECORATORS = [compiled, inlined, fused, anywhere]


class Rows(NamedTuple):
    whole: np.ndarray
    row: np.ndarray
    factor: float


def reassigned_views(a, k):
    total, row = 0.0, a[0]
    for i in range(len(a)):
        total += row[k] * a[i][k]
        row = a[i]
    return total


def swapped_views(a, k):
    one, other = a[0], a[1]
    for _ in range(k):
        one, other = other, one
    return one[0] - 2.0 * other[1]


def chosen_view(a, k):
    row = a[0] if k > 1 else a[1, :]
    if a[k, k] > 2.0:
        row = a[-1]
    return row[0] + row[1]


def tuples(a, k):
    pair = (a, a[k])
    first, second = pair
    return first[0, 0] * second[1] + pair[1][0] + len(pair)


def named_tuples(a, k):
    rows = Rows(a, a[k], 2.0)
    rows.row[0] += 1.0
    rows.whole[1:, 0] = rows.factor
    return rows.row[0] * rows.factor + rows.whole.shape[1]


def slices(a, k):
    part = a[1:, ::2]
    inner = part[:k]
    return part[0, 0] + inner[0, 1] + max(part.shape[0], len(inner)) + np.hypot(part[0, 0], 2.0)


def allocation(a, k):
    made = np.zeros(3)
    for i in range(3):
        made[i] = a[k, i]
        made = made[::-1]
    return made[0] + 2.0 * made[1]


def allocations_in_a_loop(a, k):
    made = np.ones(1)
    for i in range(20):
        made = np.full(3, made[0] + a[k, 0] + i)
    return made[1]


def copies(a, k):
    return a[k].copy()[0] + a.T.copy()[k][1]


def chosen_elements(a, k):
    return a[k][a[k] > 1.0].sum()


def listed_elements(a, k):
    return a[k][np.array([0, 2])][1]


def whole_arrays(a, k):
    return (2.0 * a + a[k]).sum()


def contiguous_copies(a, k):
    return np.dot(a[:, k], a[k])


def rows_that_overlap(a, k):
    a[1:] = a[:-1]
    return a[2, k]


def rows_one_by_one(a, k):
    total = 0.0
    for row in a:
        total += row[k]
    return total


def flat_elements(a, k):
    total = 0.0
    for number in a.flat:
        total += number * k
    return total


def lists(a, k):
    rows = [a[0], a[k]]
    return rows[1][0] + len(rows)


def returned_view(a, k):
    return a[k]


def returned_tuple(a, k):
    return a, a[k], 2.0


def returned_array(a, k):
    return np.array([a[k, 0], 2.0])


BORROW = [reassigned_views, swapped_views, chosen_view, tuples, named_tuples, slices]
COUNT = [
    allocation,
    allocations_in_a_loop,
    copies,
    chosen_elements,
    listed_elements,
    whole_arrays,
    contiguous_copies,
    rows_that_overlap,
    rows_one_by_one,
    flat_elements,
    lists,
    returned_view,
    returned_tuple,
    returned_array,
]
CASES = [(body, each) for body in BORROW for each in DECORATORS]
CASES += [(body, each) for body in COUNT for each in (compiled, fused)]


def _entry(body, decorate):
    """What Python calls: it has the body as a part."""
    part = decorate(body)

    @compiled
    def entry(a, k):
        return part(a, k)

    return entry


def _array():
    return np.arange(9.0).reshape(3, 3) ** 2


@pytest.fixture(scope="module", autouse=True)
def allocations_counted():
    import_module("numba.core.runtime._nrt_python").memsys_enable_stats()


@pytest.fixture
def counting(monkeypatch):
    """Names of the functions that count references, as they are given to LLVM."""
    found = set()
    add = CPUCodeLibrary.add_ir_module

    def noting(self, module):
        functions = [one for one in module.functions if "cpython" not in one.name]
        found.update(one.name for one in functions if 'call void @"NRT_' in str(one))
        add(self, module)

    monkeypatch.setattr(CPUCodeLibrary, "add_ir_module", noting)
    return lambda body: any(body.__name__ in name for name in found)


@pytest.mark.filterwarnings("ignore:np.dot")
@pytest.mark.parametrize(("body", "decorate"), CASES)
def test_results_are_those_of_python_and_nothing_leaks(body, decorate):
    entry = _entry(body, decorate)
    array = _array()
    wanted = body(_array(), 1)
    np.testing.assert_equal(entry(_array(), 1), wanted)
    before, held = rtsys.get_allocation_stats(), sys.getrefcount(array)
    for _ in range(20):
        result = entry(array, 1)
    result = None
    gc.collect()
    after = rtsys.get_allocation_stats()
    assert result is None
    assert sys.getrefcount(array) == held
    assert after.alloc - before.alloc == after.free - before.free
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free


@pytest.mark.parametrize("body", BORROW)
def test_a_function_that_only_borrows_counts_nothing(body, counting):
    _entry(body, compiled)(_array(), 1)
    assert not counting(body)


@pytest.mark.filterwarnings("ignore:np.dot")
@pytest.mark.parametrize("body", COUNT)
def test_a_function_that_makes_or_gives_references_counts_them(body, counting):
    _entry(body, compiled)(_array(), 1)
    assert counting(body)


@pytest.mark.parametrize("decorate", DECORATORS)
def test_what_a_helper_returns_lives_on_when_all_else_is_gone(decorate):
    helper = decorate(returned_tuple)

    @compiled
    def of_own(k):
        whole, row, factor = helper(np.full((3, 3), 7.0), k)
        return (row, factor) if whole[k, k] > 0.0 else (whole[0], 0.0)

    kept = [of_own(k % 3)[0] for k in range(50)]
    for _ in range(50):
        np.full((3, 3), np.nan)
    assert all(np.all(row == 7.0) for row in kept)
    given = [_entry(returned_view, decorate)(_array(), 2) for _ in range(3)]
    gc.collect()
    np.testing.assert_equal(given, [_array()[2]] * 3)


def test_an_array_outlives_the_helpers_that_borrow_it():
    helpers = [compiled(reassigned_views), fused(named_tuples), inlined(slices)]
    first, second, third = helpers

    @compiled
    def entry(a, k):
        total = 0.0
        for _ in range(10):
            made = a.copy()
            total += first(made, k) + second(made, k) + third(made, k) + made[k, k]
        return total

    a, wanted = _array(), 0.0
    for _ in range(10):
        made = a.copy()
        wanted += reassigned_views(made, 1) + named_tuples(made, 1) + slices(made, 1) + made[1, 1]
    before = rtsys.get_allocation_stats()
    assert entry(a, 1) == wanted
    after = rtsys.get_allocation_stats()
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free >= 10
