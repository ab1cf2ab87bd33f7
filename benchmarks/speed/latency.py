"""How long single decompositions of a control loop take, down to the worst of 100,000.

    python -m benchmarks.speed.latency

Each loop is measured as it is, then with Python's garbage collector off, so that the difference is
the collector's. Beside the time of a call stands the processor time of the same calls: what of the
worst is not processor time, the machine gave to others.
"""

import gc
import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks import pages
from coopenv import wrench
from coopenv.arrays import FloatArray

CALLS = 100_000
PAGE = pages.DOCS / "decomposition.md"
COLUMNS = [
    "loop",
    "collector",
    "median [µs]",
    "99.9 % [µs]",
    "worst [µs]",
    "worst, processor [µs]",
    "taken from it",
    "blocks kept",
]
LOOPS = {
    "a pair in the plane": np.array([(-0.9, 0.0), (0.9, 0.0)]),
    "a trio in space": np.random.default_rng(0).normal(size=(3, 3)),
}


class Times(NamedTuple):
    """What was measured of a loop."""

    wall: FloatArray  # (call,) [µs]
    processor: FloatArray  # (call,) [µs]
    taken: int  # how often the machine took the processor away
    kept: int  # blocks of memory that Python holds more afterwards


def main() -> None:
    """Print the table; with ``--write`` also put it on its page."""
    pages.show(PAGE, {"latency": pages.markdown(COLUMNS, rows())})


def rows() -> list[list[str]]:
    """What was measured."""
    return [
        _row(name, grips, collected) for name, grips in LOOPS.items() for collected in (True, False)
    ]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows."""
    return [("Latency of a control loop", COLUMNS, rows())]


def _row(name: str, grips: FloatArray, collected: bool) -> list[str]:
    decomposer = wrench.Decomposer(grips).compile()
    size = 3 * grips.shape[1] - 3
    wrenches = np.random.default_rng(1).normal(size=(CALLS, len(grips), size))
    gc.collect()
    if not collected:
        gc.disable()
    try:
        times = measured(decomposer, wrenches)
    finally:
        gc.enable()
    middle, rare = np.quantile(times.wall, (0.5, 0.999))
    numbers = (middle, rare, times.wall.max(), times.processor.max())
    counts = (times.taken, times.kept)
    return [name, "on" if collected else "off", *map("{:.1f}".format, numbers), *map(str, counts)]


def measured(call: Callable[[FloatArray], object], wrenches: FloatArray) -> Times:
    """Time every call."""
    times = np.empty((2, len(wrenches)), dtype=np.int64)
    call(wrenches[0])
    blocks, taken = sys.getallocatedblocks(), _times_taken()
    for k, applied in enumerate(wrenches):
        processor, wall = time.thread_time_ns(), time.perf_counter_ns()
        call(applied)
        times[0, k] = time.perf_counter_ns() - wall
        times[1, k] = time.thread_time_ns() - processor
    taken, kept = _times_taken() - taken, sys.getallocatedblocks() - blocks
    wall, processor = times / 1e3
    return Times(wall, processor, taken, kept)


def _times_taken() -> int:
    """How often this process had to leave the processor so far; 0 where nobody counts."""
    try:
        import resource
    except ImportError:
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


if __name__ == "__main__":
    main()
