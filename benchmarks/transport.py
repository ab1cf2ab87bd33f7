"""Environment steps per second, beside the bare physics and VMAS in the same run.

Everything is on: decomposition, measures, default reward, observation and infos. "Bare" is what
pymunk itself costs for the same bodies, moving as briskly: set every force, step, read every pose
and twist, five times a control step or as often as the default has substeps. VMAS, where it is
installed, runs
its two-agent ``transport`` at the same number of worlds.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from typing import Any

import gymnasium
import numpy as np
import pymunk.batch as batch

from coopenv import Box, Scene, Sensor, Transport, TransportTask
from coopenv.agents.partners import PARTNERS
from coopenv.arrays import FloatArray
from coopenv.observation import DEFAULT_BLOCKS

SIZES = (1, 16, 256, 1024)
SENSED_SIZES = (256, 1024)
PARTNERED = 1024  # worlds in which partners are timed
FOUR_BOXES = Scene(
    obstacles=tuple(
        Box(center=(x, y), size=(0.4, 0.3), angle=x * y)
        for x, y in ((2.2, 2.0), (-2.0, 2.2), (2.0, -2.2), (-2.2, -2.0))
    )
)
RANGES = (*DEFAULT_BLOCKS, "obstacles")  # 12 rays an agent
IMPERFECT = (*DEFAULT_BLOCKS, Sensor("obstacles", noise=0.02, bias=0.01, delay=2))
REPEATS = 9
TARGET_RATIO = 1.5  # full step to five bare substeps, at 256 worlds and more
TARGET_RANGES = 0.5  # µs a world that ranges add for each agent
TARGET_PARTNER = 1.0  # what a partner adds to a step, to bare pymunk at the same substeps
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


def compare_senses(num_worlds: int) -> list[str]:
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


def full_step(core: Transport, steps: int, actions: FloatArray | None = None) -> float:
    """Seconds a batched control step, resets of ended worlds included; random unless given."""
    if actions is None:
        actions = random_actions(core, steps)
    core.reset(seed=0)
    began = time.perf_counter()
    for k in range(steps):
        *_, terminated, truncated, _ = core.step(actions[k])
        ended = terminated | truncated
        if ended.any():
            core.reset(mask=ended)
    return (time.perf_counter() - began) / steps


def random_actions(core: Transport, steps: int) -> FloatArray:
    """``(step, world, learner, 3)``."""
    shape = (steps, core.num_worlds, len(core.learners), 3)
    return np.random.default_rng(0).uniform(-1, 1, shape)


def bare_step(core: Transport, substeps: int, steps: int) -> float:
    """Seconds that pymunk alone takes for the same bodies: forces in, step, poses out.

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
    began = time.perf_counter()
    for step in range(steps):
        for space, forces, command, report in spaces:
            for _ in range(substeps):
                command.set_float_buf(forces[step])
                batch.set_space_bodies(space, told, command)
                space.step(core.dt / substeps)
                report.clear()
                batch.get_space_bodies(space, asked, report)
                np.frombuffer(report.float_buf())
    elapsed = time.perf_counter() - began
    for space in core.world.spaces:
        space.damping = 1.0
    return elapsed / steps


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


def partner_costs() -> list[list[str]]:
    """What each kind of partner adds to a step, beside the bare physics; a line a kind.

    Added to the step of a team that moves at random, and to that of one that is told to move as
    the partner and the learner do: pymunk takes longer where bodies move faster.
    """
    never = TransportTask(position_tolerance=1e-9)  # or partners would be charged for resets
    alone = Transport(num_worlds=PARTNERED, task=never)
    cores = {name: Transport(num_worlds=PARTNERED, task=never, partner=name) for name in PARTNERS}
    steps = 20
    moves = {name: joint_actions(core, steps) for name, core in cores.items()}
    seen = {name: [] for name in cores}
    for _ in range(REPEATS):
        for name, core in cores.items():
            bare = bare_step(alone, alone.substeps, steps)
            full, random = full_step(core, steps), full_step(alone, steps)
            same = full_step(alone, steps, moves[name])
            own, physics = partner_work(core, steps)
            added = (full - random, full - same)
            seen[name].append((*added, own, physics, *np.divide((*added, own), bare)))
    lines = []
    for name, times in seen.items():
        *costs, random, same, own = np.median(times, axis=0)
        micro = [f"{cost / PARTNERED * 1e6:.2f}" for cost in costs]
        lines.append([name, *micro, f"{random:.2f}", f"{same:.2f}", f"{own:.2f}"])
    return lines


def joint_actions(core: Transport, steps: int) -> FloatArray:
    """What everybody does, ``(step, world, agent, 3)``, when the learners act at random."""
    core.reset(seed=0)
    joint = []
    for action in random_actions(core, steps):
        core.step(action)
        assert core.transition is not None
        joint.append(core.transition.action)
    return np.array(joint)


def partner_work(core: Transport, steps: int) -> tuple[float, float]:
    """Seconds of a step that the partner takes for itself, and that the core's physics takes."""
    company, last = core._company, core.transition
    assert company is not None
    assert last is not None
    action = np.zeros((core.num_worlds, len(core.learners), 3))
    wrench = np.zeros((core.num_worlds, 3))
    began = time.perf_counter()
    for _ in range(steps):
        company.joint(action, last)
        company.info(last)
    between = time.perf_counter()
    for _ in range(steps):
        core.world.step(wrench)
    return (between - began) / steps, (time.perf_counter() - between) / steps


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    lines = []
    for num_worlds in SIZES:
        row = compare(num_worlds)
        lines.append(
            [
                f"{num_worlds:,}",
                f"{row.full:.2f}",
                f"{row.bare_same:.2f}",
                f"{row.bare_five:.2f}",
                f"{row.ratio:.2f}",
                f"{1e6 / row.full:,.0f}",
                "not installed" if row.vmas is None else f"{1e6 / row.vmas:,.0f}",
                "" if row.vmas is None else f"{row.vmas / row.full:.1f} ×",
            ]
        )
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
    sensed = [compare_senses(num_worlds) for num_worlds in SENSED_SIZES]
    single = [[f"{single_gymnasium():,.0f}", f"≥ {TARGET_SINGLE:,}"]]
    return [
        (f"Full step (target: ≤ {TARGET_RATIO} × five bare substeps from 256)", columns, lines),
        (
            f"Senses: full step [µs/world] with 12 rays an agent among four boxes "
            f"(target: ≤ {TARGET_RANGES} µs more an agent)",
            [
                "worlds",
                "no ranges",
                "ranges",
                "noisy, late ranges",
                "bare, 5 substeps",
                "ranges / bare 5",
                "ranges, an agent",
            ],
            sensed,
        ),
        (
            f"Partners in {PARTNERED:,} worlds (target: ≤ {TARGET_PARTNER:g} × bare pymunk)",
            [
                "partner",
                "adds to a random team's step [µs/world]",
                "adds to a step of the same motion",
                "its own work",
                "the core's physics",
                "first / bare pymunk, same substeps",
                "second / bare",
                "own / bare",
            ],
            partner_costs(),
        ),
        ("gymnasium.make(...).unwrapped, one world", ["steps/s", "target"], single),
    ]
