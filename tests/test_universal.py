"""Gufuncs that are compiled when they are first called."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from coopenv.compiled import gufunc

LAYOUT, SIGNATURE = "(n)->()", "void(float64[:], float64[:])"


def _total(values, result):
    """Write the sum."""
    result[0] = 0.0
    for i in range(values.shape[0]):
        result[0] += values[i]


module_total = gufunc(LAYOUT, SIGNATURE)(_total)
_total.__name__ = module_total.__dict__["__name__"] = "module_total"


def test_it_broadcasts_as_a_gufunc_from_the_first_call_on():
    total = gufunc(LAYOUT, SIGNATURE)(_total)
    for values in ([1.0, 2.0], np.ones((4, 3, 2)), np.ones((3, 0))):
        np.testing.assert_array_equal(total(values), np.sum(values, axis=-1))
    out = np.empty(3)
    assert total(np.ones((3, 2)), out=out) is out
    assert total.ufunc.signature == total.signature == LAYOUT
    assert total.__doc__ == "Write the sum."


def test_it_is_compiled_once_when_threads_call_it_first_at_the_same_time():
    total = gufunc(LAYOUT, SIGNATURE)(_total)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: total([1.0, 2.0]), range(8)))
        made = set(pool.map(lambda _: id(total.ufunc), range(8)))
    assert found == [3.0] * 8
    assert len(made) == 1


def test_it_is_copied_and_pickled_by_its_name():
    for made in (copy.deepcopy(module_total), pickle.loads(pickle.dumps(module_total))):
        assert made is module_total
    assert module_total([1.0, 2.0]) == 3.0
    assert pickle.loads(pickle.dumps(module_total)) is module_total
