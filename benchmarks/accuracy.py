"""Benchmark of simulation accuracy against the number of physics substeps, for docs/accuracy.md.

Free motion is integrated exactly whatever the number; only contacts depend on it. Beams of the
default body are driven into the walls of the default room by two agents who push at their limits
in random directions, changed every half second, and compared with the same run at many substeps.

What hands that give way add to it is in `benchmarks.hands`.

    python -m benchmarks.accuracy            # prints the tables
    python -m benchmarks.accuracy --write    # and writes docs/accuracy.md
"""

import time
from dataclasses import dataclass

import numpy as np

from benchmarks import hands
from benchmarks.pages import DOCS, show
from coopenv import Body, Scene, TransportConfig
from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated
from coopenv.physics.world import World
from coopenv.wrench import object_wrench

NUM_WORLDS, NUM_STEPS, HOLD, DT = 512, 200, 10, 0.05
REFERENCE, CHOICES = 200, (1, 2, 3, 5, 10, 20)
LATE = 40  # [control steps] when positions are compared: later, bounces decide
PAGE = DOCS / "accuracy.md"


@dataclass(frozen=True)
class Row:
    """One number of substeps."""

    substeps: int
    free_error: float  # [m, rad] worst pose error of free motion
    depth: float  # [m] deepest overlap with a wall at the end of any control step
    escaped: int  # worlds whose body ended outside
    deviation: float  # [m] mean distance to the reference's positions after 2 s
    cost: float  # [µs] a world and control step, median


def drive(substeps: int, size: float, seed: int = 0) -> tuple[FloatArray, float, float]:
    """Poses ``(step, world, 3)`` of a run, the deepest overlap [m] and the cost [µs]."""
    body, scene = Body(), Scene(size=(size, size))
    limits = TransportConfig(body=body).limits()[:, [0, 0, 1]]
    world = World([body] * NUM_WORLDS, [scene] * NUM_WORLDS, dt=DT, substeps=substeps)
    generator = np.random.default_rng(seed)
    start = np.zeros((NUM_WORLDS, 3))
    start[:, :2] = generator.uniform(-1.5, 1.5, (NUM_WORLDS, 2))
    start[:, 2] = generator.uniform(-np.pi, np.pi, NUM_WORLDS)
    world.place(np.arange(NUM_WORLDS), start)
    poses, costs, depth = [], [], 0.0
    wrench = np.zeros((NUM_WORLDS, 3))
    for step in range(NUM_STEPS):
        if step % HOLD == 0:
            pushes = limits * generator.choice([-1.0, 1.0], (NUM_WORLDS, body.num_agents, 3))
            wrench = object_wrench(pushes, body.grips)
        began = time.perf_counter()
        world.step(wrench)
        costs.append(time.perf_counter() - began)
        poses.append(world.pose)
        depth = max(depth, float((np.abs(corners(body, world.pose)) - size / 2).max()))
    return np.array(poses), depth, float(np.median(costs)) / NUM_WORLDS * 1e6


def corners(body: Body, pose: FloatArray) -> FloatArray:
    """Outline of every world ``(world, vertex, 2)`` [m]."""
    c, s = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
    x, y = np.array(body.outline).T
    return np.stack(rotated(c, s, x, y), axis=-1) + pose[:, None, :2]


def table() -> list[Row]:
    """One row for each of `CHOICES`."""
    free, _, _ = drive(REFERENCE, size=100.0)
    touched, _, _ = drive(REFERENCE, size=6.0)
    rows = []
    for substeps in CHOICES:
        poses, depth, cost = drive(substeps, size=6.0)
        away = np.linalg.norm(poses[LATE, :, :2] - touched[LATE, :, :2], axis=-1)
        rows.append(
            Row(
                substeps=substeps,
                free_error=float(np.abs(drive(substeps, size=100.0)[0] - free).max()),
                depth=depth,
                escaped=int((np.abs(poses[-1, :, :2]) > 3.0).any(axis=-1).sum()),
                deviation=float(away.mean()),
                cost=cost,
            )
        )
    return rows


def as_markdown(rows: list[Row]) -> str:
    """The page's table."""
    head = (
        "| substeps | free motion: worst error | deepest overlap | escaped | position after 2 s: "
        "mean deviation | µs a world and step |"
    )
    lines = [
        f"| {row.substeps} | {row.free_error:.0e} | {1000 * row.depth:.1f} mm | "
        f"{row.escaped} of {NUM_WORLDS} | {100 * row.deviation:.1f} cm | {row.cost:.2f} |"
        for row in rows
    ]
    return "\n".join([head, "|---|---|---|---|---|---|", *lines])


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    texts = {
        "table": as_markdown(table()),
        "hands": hands.substeps_table(),
        "wrench of a step": hands.wrench_table(),
    }
    show(PAGE, texts)


if __name__ == "__main__":
    main()
