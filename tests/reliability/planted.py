"""A campaign with planted faults, for the tests of the soak test's runner: seeds say which."""

import ctypes
import os
import time
from pathlib import Path

NAME = "planted"
SHARE = 1.0
TIMEOUT = 3.0  # [s]
WRONG, CRASHES, HANGS, EXITS, PRINTS, COLD = 2, 4, 6, 8, 9, 10
warmed: list[int] = []


def warm_up() -> None:
    """A trial of the seed `COLD` needs it."""
    warmed.append(os.getpid())


def trial(seed: int, folder: Path) -> dict[str, int]:
    """Break in the way of the seed; others count one step in a tenth of a second."""
    assert not list(folder.iterdir())
    (folder / "left").write_text("behind")
    if seed == WRONG and "PLANTED_MENDED" not in os.environ:
        raise AssertionError(f"world 3 left its room at step {seed}\n" + "and more\n" * 30)
    if seed == CRASHES:
        ctypes.string_at(0)
    if seed == HANGS:
        time.sleep(3600)
    if seed == EXITS:
        os._exit(7)
    if seed == COLD:
        assert warmed == [os.getpid()], "the worker was not warmed up, or more than once"
    if seed == PRINTS:
        print("noise")
    time.sleep(0.1)
    return {"steps": 1}
