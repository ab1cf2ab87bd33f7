"""Time of a decomposition and of its measures, alone and in batches.

    python -m benchmarks.speed.wrench

Every figure is a median of CPU times over repeats, so that other processes count little; kernels
are compiled before the clock starts. Wrenches are drawn from a normal distribution: those of a team
that agrees take less.
"""

import time
from collections.abc import Callable
from statistics import median
from typing import NamedTuple

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.wrench.measures import level_kernel
from coopenv.wrench.shares import share_of_load

REPEATS = 15
BATCHES = (1, 100, 100_000)
BEAM = ((-0.9, 0.0), (0.9, 0.0))
WALKER = ((-0.5, 0.0), (0.0, 0.0))
BENT = ((0.8, 0.3), (-0.5, 0.9))  # not on a line through the centre of mass
TARGETS = {  # [µs a sample]
    "pair, beam, batch of 1": 10.0,
    "pair, beam, batch of 100000": 1.0,
    "all measures, batch of 100000": 0.3,
    "a step's use of one sample": 15.0,
}


class Row(NamedTuple):
    """One figure."""

    name: str
    median: float
    unit: str


def median_time(call: Callable[[], object], samples: int = 1) -> float:
    """Median over repeats of the time a call takes [µs], each repeat at least 2 ms long."""
    call()
    began = time.process_time()
    call()
    loops = max(1, int(2e-3 / max(time.process_time() - began, 1e-7)))
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        for _ in range(loops):
            call()
        times.append((time.process_time() - began) / loops * 1e6)
    return median(times) / samples


def pair() -> list[Row]:
    """Decompositions of two planar effectors, and what the environment asks of one."""
    rows = []
    for grips_name, grips in (("beam", BEAM), ("walker", WALKER), ("off the axis", BENT)):
        decomposer = wrench.Decomposer(grips)
        for size in BATCHES:
            applied = draw(size, 2, 3)
            name = f"pair, {grips_name}, batch of {size}"
            rows.append(Row(name, median_time(lambda: decomposer(applied), size), "µs/sample"))  # noqa: B023
    decomposer, applied = wrench.Decomposer(BEAM), draw(1, 2, 3)
    rows.append(
        Row("a step's use of one sample", median_time(lambda: use(decomposer(applied))), "µs")
    )
    rows.append(
        Row("decompose(), all checks", median_time(lambda: wrench.decompose(applied, BEAM)), "µs")
    )
    return rows


def use(decomposition: wrench.Decomposition) -> None:
    """Ask for all that the environment's default observation and info need."""
    _ = decomposition.internal, decomposition.relative_cost, decomposition.load_share
    _ = decomposition.internal_force_level, decomposition.internal_torque_level


def measures() -> list[Row]:
    """Costs, levels and load shares, without the decomposition itself."""
    rows = []
    decomposer = wrench.Decomposer(BEAM)
    parameters = decomposer.level_parameters
    grips = decomposer.grips
    for size in BATCHES:
        applied = draw(size, 2, 3)
        manipulation = decomposer(applied).manipulation
        calls: dict[str, Callable[[], object]] = {
            "costs and levels": lambda: level_kernel(applied, manipulation, grips, parameters),  # noqa: B023
            "load share": lambda: share_of_load(applied, grips),  # noqa: B023
        }
        times = {name: median_time(call, size) for name, call in calls.items()}
        times["all measures"] = sum(times.values())
        rows += [Row(f"{name}, batch of {size}", t, "µs/sample") for name, t in times.items()]
    return rows


def conic() -> list[Row]:
    """Clarabel, one wrench after the other, set-up included."""
    rows = []
    for num_effectors in (2, 3, 10):
        for dimension, space in ((2, "plane"), (3, "space")):
            grips = np.random.default_rng(0).normal(size=(num_effectors, dimension))
            decomposer = wrench.Decomposer(grips, wrench.Settings(solver="conic"))
            applied = draw(20, num_effectors, 3 * dimension - 3)
            name = f"conic, n = {num_effectors}, {space}"
            time_each = median_time(lambda: decomposer(applied), 20)  # noqa: B023
            rows.append(Row(name, time_each, "µs/sample"))
    return rows


def draw(size: int, num_effectors: int, components: int) -> FloatArray:
    """Wrenches of unit variance; a single one has no batch axis."""
    applied = np.random.default_rng(1).normal(size=(size, num_effectors, components))
    return applied[0] if size == 1 else applied


def rows() -> list[Row]:
    """All figures of this module."""
    return [*pair(), *measures(), *conic()]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    lines = [
        [name, f"{value:,.3g}", unit, f"≤ {TARGETS[name]:g}" if name in TARGETS else ""]
        for name, value, unit in rows()
    ]
    return [("Decomposition and measures", ["what", "median", "unit", "target"], lines)]


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    for title, columns, lines in tables():
        table = Table(*columns, title=title, title_justify="left")
        for line in lines:
            table.add_row(*line)
        Console().print(table)


if __name__ == "__main__":
    main()
