"""How long single calls take, down to the worst of many: what a control loop asks."""

import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray


class Times(NamedTuple):
    """What was measured of a loop."""

    wall: FloatArray  # (call,) [µs]
    processor: FloatArray  # (call,) [µs]
    taken: int  # how often the machine took the processor away
    kept: int  # blocks of memory that Python holds more afterwards


def times_of_calls(call: Callable[[FloatArray], object], wrenches: FloatArray) -> Times:
    """Time every call, one for each of ``wrenches``."""
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
