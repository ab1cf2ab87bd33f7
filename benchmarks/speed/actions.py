"""The full step with each kind of action, beside that with wrenches: part of ``make bench``.

python -m benchmarks.speed.actions --write      # puts the table into docs/accuracy.md

All take their steps in turn, so that what else runs on the machine slows them alike, and of every
step its median over the repeats counts.
"""

import numpy as np

from benchmarks.pages import DOCS, markdown, show
from benchmarks.speed.transport import REPEATS
from coopenv import Transport
from coopenv.bench import full_steps, random_actions

PAGE = DOCS / "accuracy.md"
ACTIONS = ("wrench", "motion", "impedance")  # the first is what the others stand beside
SIZES = (1, 256, 1024)
STEPS = 60  # of a repeat; no episode ends in them
TARGET = 1.3  # motion to wrenches, at 256 worlds
COLUMNS = ["worlds", *(f"{name} [µs/world]" for name in ACTIONS)]
COLUMNS += [f"{name} / wrench" for name in ACTIONS[1:]]


def compare(num_worlds: int) -> list[str]:
    """One row: medians of the steps' times, and of their ratios."""
    cores = [Transport(num_worlds=num_worlds, action=name) for name in ACTIONS]
    actions = [random_actions(core, STEPS) for core in cores]
    seen = []
    for _ in range(REPEATS + 1):
        runs = [full_steps(core, given) for core, given in zip(cores, actions, strict=True)]
        seen.append([*zip(*runs, strict=True)])
    times = np.median(seen[1:], axis=0) / num_worlds * 1e6  # (step, action)
    ratios = np.median(times[:, 1:] / times[:, :1], axis=0)
    medians = np.median(times, axis=0)
    return [f"{num_worlds:,}", *(f"{m:.2f}" for m in medians), *(f"{r:.2f}" for r in ratios)]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows."""
    title = f"Kinds of action (target: motion ≤ {TARGET} × wrenches at 256 worlds)"
    return [(title, COLUMNS, [compare(num_worlds) for num_worlds in SIZES])]


def main() -> None:
    """Print the table; with ``--write`` also put it on the page."""
    ((_, columns, rows),) = tables()
    show(PAGE, {"actions": markdown(columns, rows)})


if __name__ == "__main__":
    main()
