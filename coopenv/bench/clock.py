"""Clocks of a measurement: what passed, and what this process had of the processor."""

import time
from collections.abc import Callable, Iterator
from statistics import median
from typing import NamedTuple

LEAST = 3  # repeats, however long they take
LONGEST = 1000  # repeats, however short they are


class Seconds(NamedTuple):
    """Of the same work."""

    passed: float
    processor: float  # of all threads


def repeated(work: Callable[[], float], seconds: float) -> Seconds:
    """Medians over repeats of some work, which tells how much of what passed counts [s].

    Parameters
    ----------
    work
        Does it once. What it leaves out, as resetting, counts on neither clock: its share of the
        processor is taken to be that of the time that passed.
    seconds
        For which it is repeated, at least three times.
    """
    found = list(_repeats(work, seconds))
    return Seconds(*(median(values) for values in zip(*found, strict=True)))


def _repeats(work: Callable[[], float], seconds: float) -> Iterator[Seconds]:
    began, count = time.perf_counter(), 0
    while count < LEAST or (time.perf_counter() - began < seconds and count < LONGEST):
        processor, all_of_it = time.process_time(), time.perf_counter()
        counted = work()
        processor, all_of_it = time.process_time() - processor, time.perf_counter() - all_of_it
        count += 1
        yield Seconds(counted, processor * counted / max(all_of_it, 1e-9))
