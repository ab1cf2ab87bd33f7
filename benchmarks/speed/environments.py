"""Every environment's full step with ranges on, beside pymunk alone: part of ``make bench``."""

import time

import gymnasium
import numpy as np

from benchmarks.speed.transport import REPEATS, bare_step, median
from coopenv import Transport
from coopenv.bench import full_step
from coopenv.envs.registry import PREFIX, find_config

SIZES = (256, 1024)
STEPS = 40  # no episode ends in them
COLUMNS = [
    "environment",
    "worlds",
    "full step, ranges on [µs/world]",
    "bare, 5 substeps",
    "full / bare 5",
    "a reset [µs/world]",
]


def compare(env: str, num_worlds: int) -> list[str]:
    """One row: steps of worlds that all have layouts, bodies and goals of their own."""
    config = find_config(env, {})
    names = {getattr(block, "name", block) for block in config.observe}
    observe = config.observe if "obstacles" in names else (*config.observe, "obstacles")
    core = Transport(num_worlds=num_worlds, config=find_config(env, {"observe": observe}))
    times = {"full": [], "bare": [], "reset": []}
    for _ in range(REPEATS + 1):
        times["full"].append(full_step(core, STEPS))
        times["bare"].append(bare_step(core, 5, STEPS))
        began = time.perf_counter()
        core.reset(seed=0)
        times["reset"].append(time.perf_counter() - began)
    full, bare, reset = (np.array(times[name][1:]) / num_worlds * 1e6 for name in times)
    return [
        env.removeprefix(PREFIX),
        f"{num_worlds:,}",
        f"{median(full):.2f}",
        f"{median(bare):.2f}",
        f"{median(full / bare):.2f}",
        f"{median(reset):.0f}",
    ]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows."""
    ours = [name for name in gymnasium.registry if name.startswith(PREFIX)]
    rows = [compare(env, size) for env in ours for size in SIZES]
    return [("Every environment, different layouts in every world", COLUMNS, rows)]
