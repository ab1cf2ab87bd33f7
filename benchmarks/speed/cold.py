"""How long a fresh process takes to its first answer, with an empty and with a warm cache.

    python -m benchmarks.speed.cold

Processor seconds beyond importing the dependencies, each row in processes of its own: first with an
empty folder for the cache, then again with what that left in it.
"""

import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks import pages

REPEATS = 3
PAGE = pages.DOCS / "install.md"
COLUMNS = ["a new process", "empty cache [CPU s]", "warm cache [CPU s]", "wanted, empty / warm"]

DEPENDENCIES = "import numpy, numba, gymnasium, pettingzoo, pymunk, clarabel"
BEGIN = f"import time; {DEPENDENCIES}; began = time.process_time(); import coopenv"
END = "print(time.process_time() - began)"
ROWS = {  # what comes after the import, and the seconds wanted with an empty and a warm cache
    "`import coopenv`": ("", "1.5 / 0.3"),
    "and a step of the default environment": (
        "env = gymnasium.make('coopenv/BeamTransport-v0'); env.reset(seed=0); "
        "env.step(env.action_space.sample())",
        "6",
    ),
    "and a decomposition of a pair": (
        "coopenv.wrench.decompose([[3, 1, 0.5], [-1, 2, 0]], [[-0.9, 0], [0.9, 0]])",
        "",
    ),
    "and a decomposition of a trio in space": (
        "rng = numpy.random.default_rng(0); "
        "coopenv.wrench.decompose(rng.normal(size=(3, 6)), rng.normal(size=(3, 3)))",
        "8",
    ),
}


def main() -> None:
    """Print the table; with ``--write`` also put it on its page."""
    pages.show(PAGE, {"cold": pages.markdown(COLUMNS, rows())})


def rows() -> list[list[str]]:
    """What was measured."""
    return [[name, *_measured(code), wanted] for name, (code, wanted) in ROWS.items()]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows."""
    return [("First answer of a new process", COLUMNS, rows())]


def _measured(code: str) -> tuple[str, str]:
    """Medians of repeats with an empty cache and with a warm one."""
    cold, warm = [], []
    for _ in range(REPEATS):
        with TemporaryDirectory() as folder:
            cold.append(_seconds(code, folder))
            warm.append(_seconds(code, folder))
    return f"{median(cold):.1f}", f"{median(warm):.2f}"


def _seconds(code: str, folder: str) -> float:
    done = subprocess.run(
        [sys.executable, "-c", "; ".join(filter(None, (BEGIN, code, END)))],
        cwd=Path(__file__).parents[2],
        env=os.environ | {"NUMBA_CACHE_DIR": folder},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


if __name__ == "__main__":
    main()
