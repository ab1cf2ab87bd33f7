"""What a process holds: objects, shapes of pymunk, bytes, files and threads; and how it grows."""

import ctypes
import gc
import os
import sys
import threading
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from coopenv import Transport


class Memory(NamedTuple):
    """What a process holds at one moment."""

    blocks: int  # of memory that Python has handed out
    c_bytes: int  # that C code has taken with malloc; 0 where the C library does not tell
    files: int  # open descriptors; 0 where the system does not tell
    threads: int


class Growth(NamedTuple):
    """What came to stay between two moments."""

    objects: dict[str, int]  # that the garbage collector follows, by type
    memory: Memory


class _Mallinfo(ctypes.Structure):
    """The structure of glibc's mallinfo2."""

    _names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in _names.split()]


def memory() -> Memory:
    """Collect garbage and measure what is left."""
    for _ in range(3):  # what finalisers let go of is garbage of the next turn
        gc.collect()
    files = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    return Memory(sys.getallocatedblocks(), c_bytes(), files, threading.active_count())


def objects() -> Counter[str]:
    """Number of live objects of each type."""
    counts: Counter[str] = Counter()  # one by one: to take all at once it asks whether they are a
    for one in gc.get_objects():  # mapping, of which every abstract class keeps a note that counts
        counts[f"{type(one).__module__}.{type(one).__name__}"] += 1
    return counts


def c_bytes() -> int:
    """Bytes that C code holds, large arrays of NumPy included."""
    try:
        tell = ctypes.CDLL(None).mallinfo2
    except (AttributeError, OSError, TypeError):
        return 0
    tell.restype = _Mallinfo
    told = tell()
    return told.uordblks + told.hblkhd


def growth(trial: Callable[[], object], *, warm_up: int, times: int) -> Growth:
    """What ``times`` calls of ``trial`` add to what ``warm_up`` calls before them left."""
    gc.collect()
    gc.freeze()  # what was there before is not searched again and again, which takes long
    for _ in range(warm_up):
        trial()
    memory()
    alive = objects()  # counted first, so that the count itself is part of what was there before
    before = memory()
    for _ in range(times):
        trial()
    after = memory()
    more = {name: n - alive[name] for name, n in objects().items() if n > alive[name]}
    return Growth(more, Memory(*(now - then for now, then in zip(after, before, strict=True))))


def check_flat(grown: Growth, *, fewer_than: int, c_bytes: int) -> None:
    """Assert that next to nothing stays, and no file and no thread.

    Parameters
    ----------
    grown
        What came to stay.
    fewer_than
        So many objects of each type may; ten times as many blocks of Python's memory.
    c_bytes
        Less than so many bytes of C code may.
    """
    many = {name: count for name, count in grown.objects.items() if count >= fewer_than}
    assert not many, f"objects that stay: {many}"
    more = grown.memory
    assert more.blocks < 10 * fewer_than, f"{more.blocks} blocks of Python's memory stay"
    assert more.c_bytes < c_bytes, f"{more.c_bytes} bytes of C code stay"
    assert more.files <= 0, f"{more.files} files stay open"
    assert more.threads <= 0, f"{more.threads} threads stay"


def shapes(core: Transport) -> tuple[int, int]:
    """Numbers of pymunk shapes in a core's spaces, and of those that their static bodies hold."""
    spaces = core.world.spaces
    return (
        sum(len(space.shapes) for space in spaces),
        sum(len(space.static_body.shapes) for space in spaces),
    )
