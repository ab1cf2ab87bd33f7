"""Tasks of every id with parameters drawn at random."""

from dataclasses import replace
from typing import Any

import numpy as np

from coopenv import (
    DoorwayTask,
    LiftTask,
    Reference,
    TrackingTask,
    TransportConfig,
    WalkerAvoidTask,
    WalkerTurnTask,
)
from coopenv.tasks.tracking import KINDS

LOOP = Reference(  # [s], [m, m, rad]
    times=(0.0, 2.0, 4.0, 6.0), poses=((0, 0, 0), (1, 0, 1), (1, 1, 3), (0, 0, 3.5))
)


def any_task(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """The id's own task, with tolerances that are met by chance or never, and other places."""
    wide = bool(rng.random() < 0.5)
    task: Any = replace(
        config.task,  # pyright: ignore[reportArgumentType] - every id's is a dataclass
        position_tolerance=rng.uniform(0.5, 2.0) if wide else rng.uniform(0.01, 0.3),
        angle_tolerance=rng.uniform(0.5, 3.2) if wide else rng.uniform(0.01, 0.3),
        speed_tolerance=5.0 if wide else 0.1,
        spin_tolerance=5.0 if wide else 0.1,
        angle_weight=rng.uniform(0.0, 1.0),
        clearance=rng.uniform(0.0, 0.2),
    )
    return {"task": replace(task, **_own(rng, task))}


def _own(rng: np.random.Generator, task: Any) -> dict[str, Any]:
    """What only this kind of task has."""
    if isinstance(task, DoorwayTask):
        guide = [("both", "one", "none", 1)[rng.integers(4)]]
        low = rng.uniform(0.4, 1.5)
        return {
            "guide": guide[0],
            "gap": (low, low + rng.uniform(0.05, 0.5)),
            "wall_thickness": rng.uniform(0.05, 0.6),
        }
    if isinstance(task, TrackingTask):
        kinds: list[Any] = [*KINDS, KINDS[1:], LOOP]
        return {
            "reference": kinds[rng.integers(len(kinds))],
            "duration": rng.uniform(1.0, 8.0),
            "segments": int(rng.integers(1, 5)),
            "preview": tuple(rng.uniform(0.05, 2.0, rng.integers(1, 4))),
        }
    if isinstance(task, WalkerAvoidTask):
        return {"obstacles": int(rng.integers(1, 4)), "veer": rng.uniform(0.0, 0.5)}
    if isinstance(task, LiftTask):
        low = rng.uniform(0.3, 1.2)
        return {
            "obstacle_height": (low, low + rng.uniform(0.0, 0.4)),
            "obstacle_width": rng.uniform(0.1, 0.5),
            "tilt_limit": rng.uniform(0.2, 3.1),
        }
    if isinstance(task, WalkerTurnTask):
        return {"turn": (rng.uniform(0.0, 0.5), rng.uniform(0.6, 2.5))}
    return {"min_distance": rng.uniform(0.0, 2.0)}
