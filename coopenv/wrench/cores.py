"""Threads for the parts of a batch, in kernels that release the interpreter's lock."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

PARTS = 4  # of a batch for each thread: some take longer than others


def on_all_cores(solve: Callable[[slice], None], num_samples: int, num_per_thread: float) -> None:
    """Call ``solve`` with slices that make up all samples.

    ``num_per_thread`` of them occupy a core long enough for a thread to be worth its start.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    workers = min(cores or 1, num_samples, int(num_samples / num_per_thread) + 1)
    if workers < 2:
        return solve(slice(None))
    edges = np.linspace(0, num_samples, PARTS * workers + 1).astype(int)
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(solve, map(slice, edges[:-1], edges[1:])))
