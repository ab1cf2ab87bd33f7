"""Atomic writing of files: whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written(path: str | os.PathLike) -> Iterator[Path]:
    """A temporary path beside ``path``, which replaces it once the block ends without an error.

    Both have the same suffix, as writers choose the format by it.

    >>> with written("table.csv") as part:
    ...     _ = part.write_text("a,b")
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".part-{os.getpid()}-{path.name}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
