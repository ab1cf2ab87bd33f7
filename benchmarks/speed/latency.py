"""How long single decompositions of a control loop take, down to the worst of 100,000.

    python -m benchmarks.speed.latency

Each loop is measured as it is, then with Python's garbage collector off, so that the difference is
the collector's. Beside the time of a call stands the processor time of the same calls: what of the
worst is not processor time, the machine gave to others.
"""

import gc

import numpy as np

from benchmarks import pages
from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.bench import times_of_calls
from coopenv.bench.splits import GRIPS, drawn

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


def main() -> None:
    """Print the table; with ``--write`` also put it on its page."""
    pages.show(PAGE, {"latency": pages.markdown(COLUMNS, rows())})


def rows() -> list[list[str]]:
    """What was measured."""
    return [
        _row(name, grips, collected) for name, grips in GRIPS.items() for collected in (True, False)
    ]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows."""
    return [("Latency of a control loop", COLUMNS, rows())]


def _row(name: str, grips: FloatArray, collected: bool) -> list[str]:
    decomposer = wrench.Decomposer(grips).compile()
    wrenches = drawn(grips, CALLS)
    gc.collect()
    if not collected:
        gc.disable()
    try:
        times = times_of_calls(decomposer, wrenches)
    finally:
        gc.enable()
    middle, rare = np.quantile(times.wall, (0.5, 0.999))
    numbers = (middle, rare, times.wall.max(), times.processor.max())
    counts = (times.taken, times.kept)
    return [name, "on" if collected else "off", *map("{:.1f}".format, numbers), *map(str, counts)]


if __name__ == "__main__":
    main()
