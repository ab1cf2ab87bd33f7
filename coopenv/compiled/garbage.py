"""Compiling without Python's collector of garbage.

Compiling a kernel makes millions of objects that live until it is done. The collector looks through
them again and again and finds next to nothing, which takes a seventh of the time.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from coopenv.compiled.lighter import lighter
from coopenv.compiled.pipeline import Lean


@contextmanager
def kept() -> Iterator[None]:
    """Leave cycles of garbage where they are, until this ends."""
    if not gc.isenabled():
        yield
        return
    try:
        gc.disable()
        yield
    finally:
        gc.enable()


class Entry(Lean):
    """What compiles a function that Python calls, and all parts of it."""

    def compile_extra(self, func: Any) -> Any:
        """As numba does, which holds its lock meanwhile."""
        with kept(), lighter():
            return super().compile_extra(func)
