"""Benchmark of range sensors: the time they add to a step, beside bare physics in the same run."""

import numpy as np

from benchmarks.speed.transport import REPEATS, bare_step, median
from coopenv import Box, Scene, Sensor, Transport
from coopenv.bench import full_step
from coopenv.observation import DEFAULT_BLOCKS

SIZES = (256, 1024)
FOUR_BOXES = Scene(
    obstacles=tuple(
        Box(center=(x, y), size=(0.4, 0.3), angle=x * y)
        for x, y in ((2.2, 2.0), (-2.0, 2.2), (2.0, -2.2), (-2.2, -2.0))
    )
)
RANGES = (*DEFAULT_BLOCKS, "obstacles")  # 12 rays an agent
IMPERFECT = (*DEFAULT_BLOCKS, Sensor("obstacles", noise=0.02, bias=0.01, delay=2))
TARGET = 0.5  # µs a world that ranges add for each agent


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    title = (
        "Senses: full step [µs/world] with 12 rays an agent among four boxes "
        f"(target: ≤ {TARGET} µs more an agent)"
    )
    columns = [
        "worlds",
        "no ranges",
        "ranges",
        "noisy, late ranges",
        "bare, 5 substeps",
        "ranges / bare 5",
        "ranges, an agent",
    ]
    return [(title, columns, [_compare(num_worlds) for num_worlds in SIZES])]


def _compare(num_worlds: int) -> list[str]:
    """One row: the full step without and with ranges among four obstacles, and bare physics."""
    steps = max(30, 20_000 // num_worlds)
    blocks = {"plain": DEFAULT_BLOCKS, "ranges": RANGES, "imperfect": IMPERFECT}
    cores = {
        name: Transport(num_worlds=num_worlds, scene=FOUR_BOXES, observe=observe)
        for name, observe in blocks.items()
    }
    times = {name: [] for name in (*cores, "bare")}
    for _ in range(REPEATS + 1):
        for name, core in cores.items():
            times[name].append(full_step(core, steps) / num_worlds * 1e6)
        times["bare"].append(bare_step(cores["plain"], 5, steps) / num_worlds * 1e6)
    plain, ranges, imperfect, bare = (np.array(times[name][1:]) for name in times)
    return [
        f"{num_worlds:,}",
        *(f"{median(each):.2f}" for each in (plain, ranges, imperfect, bare)),
        f"{median(ranges / bare):.2f}",
        f"{median((ranges - plain) / cores['plain'].num_agents):.2f}",
    ]
