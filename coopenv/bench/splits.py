"""How many decompositions a second, of one wrench and of batches."""

import time
from typing import NamedTuple

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.bench.clock import repeated

LEAST_WORK = 2e-3  # [s] that a repeat takes at least
GRIPS = {
    "a pair in the plane": np.array([(-0.9, 0.0), (0.9, 0.0)]),
    "a trio in space": np.random.default_rng(0).normal(size=(3, 3)),
}
SPLITS = (  # whose, and how many at once
    ("a pair in the plane", 1),
    ("a pair in the plane", 100_000),
    ("a trio in space", 1),
    ("a trio in space", 1000),
)


class SplitRate(NamedTuple):
    """Medians of one kind of call."""

    effectors: str
    batch: int
    samples_per_second: float
    microseconds: float  # a sample, as time passed
    processor_microseconds: float


def split_rate(effectors: str, batch: int, seconds: float) -> SplitRate:
    """Time decompositions of wrenches drawn from a normal distribution; compiles first."""
    decomposer = wrench.Decomposer(GRIPS[effectors]).compile()
    applied = drawn(GRIPS[effectors], batch)
    began = time.perf_counter()
    decomposer(applied)
    loops = max(1, int(LEAST_WORK / max(time.perf_counter() - began, 1e-7)))

    def work() -> float:
        began = time.perf_counter()
        for _ in range(loops):
            decomposer(applied)
        return time.perf_counter() - began

    passed, processor = repeated(work, seconds)
    each = loops * batch
    return SplitRate(effectors, batch, each / passed, 1e6 * passed / each, 1e6 * processor / each)


def drawn(grips: FloatArray, count: int) -> FloatArray:
    """Wrenches of a team that does not agree, ``(count, n, 3)``, in space ``(count, n, 6)``."""
    size = 3 * grips.shape[1] - 3
    return np.random.default_rng(1).normal(size=(count, len(grips), size))
