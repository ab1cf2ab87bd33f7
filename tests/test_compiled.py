import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from coopenv import wrench

KERNEL = """
from numba import njit
from coopenv.compiled import gufunc

@gufunc("(n)->()", "void(float64[:], float64[:])")
def total(values, result):
    result[0] = 0.0
    for i in range(values.shape[0]):
        result[0] += values[i]
"""
CALL = "import kernel_in_two_minds as k; print(k.total([1.0, 2.0]))"
OTHER_NAMES = "import numba; f = numba.njit(lambda x: x); f(1); f(1.0); " + CALL


def run(script: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_cache_left_by_two_processes_at_once_is_mended(tmp_path):
    # numba caches kernel and loop apart; with the loop of another process the call would crash
    (tmp_path / "kernel_in_two_minds.py").write_text(KERNEL)
    assert run(CALL, tmp_path) == "3.0"
    for kernel in (tmp_path / "__pycache__").glob("kernel_in_two_minds.total*.nb[ic]"):
        kernel.unlink()
    assert run(OTHER_NAMES, tmp_path) == "3.0"
    assert run(CALL, tmp_path) == "3.0"


def test_threads_may_decompose_at_the_same_time():
    applied = np.random.default_rng(0).normal(size=(20_000, 2, 3))
    decomposer = wrench.Decomposer([[-0.9, 0.0], [0.9, 0.0]])
    expected = decomposer(applied).manipulation
    with ThreadPoolExecutor(2) as pool:
        for found in pool.map(lambda _: decomposer(applied).manipulation, range(6)):
            np.testing.assert_array_equal(found, expected)
