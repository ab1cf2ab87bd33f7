"""Environment steps per second, beside the bare physics and VMAS in the same run.

Everything is on: decomposition, measures, default reward, observation and infos. "Bare" is what
pymunk itself costs for the same bodies, moving as briskly: set every force, step, read every pose
and twist, five times a control step or as often as the default has substeps. VMAS, where it is
installed, runs
its two-agent ``transport`` at the same number of worlds.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from typing import Any

import gymnasium
import numpy as np
import pymunk.batch as batch

from coopenv import Transport
from coopenv.arrays import FloatArray

SIZES = (1, 16, 256, 1024)
REPEATS = 9
TARGET_RATIO = 1.5  # full step to five bare substeps, at 256 worlds and more
TARGET_SINGLE = 8_000  # steps/s of the single Gymnasium environment


@dataclass(frozen=True)
class Row:
    """Medians at one number of worlds [µs a world and control step]."""

    num_worlds: int
    full: float
    bare_five: float
    bare_same: float
    ratio: float  # full / bare_five, median of the repeats' own ratios
    vmas: float | None


def compare(num_worlds: int) -> Row:
    """Time everything side by side, alternating within each repeat."""
    steps = max(30, min(1000, 20_000 // num_worlds))
    core = Transport(num_worlds=num_worlds)
    runs: dict[str, Callable[[], float]] = {
        "full": lambda: full_step(core, steps),
        "five": lambda: bare_step(core, 5, steps),
        "same": lambda: bare_step(core, core.substeps, steps),
    }
    if find_spec("vmas"):
        runs["vmas"] = vmas_run(num_worlds, max(20, steps // 10))
    for run in runs.values():
        run()
    times = {name: [] for name in runs}
    for _ in range(REPEATS):
        for name, run in runs.items():
            times[name].append(run() / num_worlds * 1e6)
    return Row(
        num_worlds=num_worlds,
        full=median(times["full"]),
        bare_five=median(times["five"]),
        bare_same=median(times["same"]),
        ratio=median(np.divide(times["full"], times["five"])),
        vmas=median(times["vmas"]) if "vmas" in times else None,
    )


def full_step(core: Transport, steps: int) -> float:
    """Seconds a batched control step of a team that acts at random."""
    return sum(full_steps(core, random_actions(core, steps))) / steps


def full_steps(core: Transport, actions: FloatArray) -> Iterator[float]:
    """Seconds of each batched control step, resets of ended worlds included."""
    core.reset(seed=0)
    for action in actions:
        began = time.perf_counter()
        *_, terminated, truncated, _ = core.step(action)
        ended = terminated | truncated
        if ended.any():
            core.reset(mask=ended)
        yield time.perf_counter() - began


def random_actions(core: Transport, steps: int) -> FloatArray:
    """``(step, world, learner, action_size)``."""
    shape = (steps, core.num_worlds, len(core.learners), core.action_size)
    return np.random.default_rng(0).uniform(-1, 1, shape)


def bare_step(core: Transport, substeps: int, steps: int) -> float:
    """Seconds a control step that pymunk alone takes for the same bodies."""
    return sum(bare_steps(core, substeps, steps)) / steps


def bare_steps(core: Transport, substeps: int, steps: int) -> Iterator[float]:
    """Seconds of each control step of pymunk alone: forces in, step, poses out.

    They start where the core starts them and move as briskly: random wrenches of the team's
    strength, new in every control step, and pymunk's own damping in place of the drag.
    """
    core.reset(seed=0)
    fields = batch.BodyFields
    told = fields.FORCE | fields.TORQUE
    asked = fields.POSITION | fields.ANGLE | fields.VELOCITY | fields.ANGULAR_VELOCITY
    generator, body = np.random.default_rng(0), core.bodies[0]
    strength = core.num_agents * core.team.limits[0, 0, [0, 0, 1]]  # [N, N, N·m]
    spaces = []
    for space in core.world.spaces:
        space.damping = np.exp(-body.linear_drag / body.mass)  # of velocity kept, a second
        count = len(space.bodies)
        forces = strength * generator.uniform(-1, 1, (steps, count + 2, 3))
        command, report = batch.Buffer(), batch.Buffer()
        command.set_float_buf(np.zeros((count + 2, 3)))
        spaces.append((space, forces, command, report))
    for step in range(steps):
        began = time.perf_counter()
        for space, forces, command, report in spaces:
            for _ in range(substeps):
                command.set_float_buf(forces[step])
                batch.set_space_bodies(space, told, command)
                space.step(core.dt / substeps)
                report.clear()
                batch.get_space_bodies(space, asked, report)
                np.frombuffer(report.float_buf())
        yield time.perf_counter() - began
    for space in core.world.spaces:
        space.damping = 1.0


def vmas_run(num_worlds: int, steps: int) -> Callable[[], float]:
    """A function that times VMAS's two-agent transport: seconds a batched step."""
    import torch

    vmas: Any = import_module("vmas")
    torch.set_num_threads(1)
    env = vmas.make_env("transport", num_envs=num_worlds, n_agents=2, device="cpu", seed=0)
    env.reset()
    generator = torch.Generator().manual_seed(0)
    actions = [2 * torch.rand(num_worlds, 2, generator=generator) - 1 for _ in env.agents]

    def run() -> float:
        began = time.perf_counter()
        for _ in range(steps):
            env.step(actions)
        return (time.perf_counter() - began) / steps

    return run


def single_gymnasium() -> float:
    """Steps a second of ``gymnasium.make``'s environment without its wrappers, median."""
    env = gymnasium.make("coopenv/BeamTransport-v0").unwrapped
    actions = np.random.default_rng(0).uniform(-1, 1, (150, 6)).astype(np.float32)
    rates = []
    for repeat in range(REPEATS + 1):
        env.reset(seed=repeat)
        began = time.perf_counter()
        for action in actions:
            env.step(action)
        rates.append(len(actions) / (time.perf_counter() - began))
    return median(rates[1:])


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    columns = [
        "worlds",
        "full step [µs/world]",
        "bare, same substeps",
        "bare, 5 substeps",
        "full / bare 5",
        "coopenv [steps/s]",
        "VMAS transport [steps/s]",
        "ratio",
    ]
    title = f"Full step (target: ≤ {TARGET_RATIO} × five bare substeps from 256)"
    single = [[f"{single_gymnasium():,.0f}", f"≥ {TARGET_SINGLE:,}"]]
    return [
        (title, columns, [_line(compare(num_worlds)) for num_worlds in SIZES]),
        ("gymnasium.make(...).unwrapped, one world", ["steps/s", "target"], single),
    ]


def _line(row: Row) -> list[str]:
    return [
        f"{row.num_worlds:,}",
        f"{row.full:.2f}",
        f"{row.bare_same:.2f}",
        f"{row.bare_five:.2f}",
        f"{row.ratio:.2f}",
        f"{1e6 / row.full:,.0f}",
        "not installed" if row.vmas is None else f"{1e6 / row.vmas:,.0f}",
        "" if row.vmas is None else f"{row.vmas / row.full:.1f} ×",
    ]
