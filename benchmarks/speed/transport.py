"""Environment steps per second, on one core and on all, beside bare physics and VMAS.

    python -m benchmarks.speed.transport --write     # also writes README's table

Everything is on: decomposition, measures, default reward, observation and infos. "Bare" is what
pymunk itself costs for the same bodies on one core, moving as briskly: set every force, step, read
every pose and twist, five times a control step. VMAS, where it is installed, runs its two-agent
``transport`` at the same number of worlds, on all cores.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any

import gymnasium
import numpy as np
import pymunk.batch as batch

from benchmarks.pages import markdown, show
from coopenv import Transport, beam_transport_v0
from coopenv.bench import full_step
from coopenv.compiled.parallel.crew import cores

SIZES = (1, 16, 64, 256, 1024, 4096, 16_384)
REPEATS = 9
TARGET_RATIO = 1.5  # full step to five bare substeps, at 256 worlds and more
TARGET_SINGLE = 13_000  # steps/s of the single Gymnasium environment
PAGE = Path(__file__).parents[2] / "README.md"


@dataclass(frozen=True)
class Row:
    """Medians at one number of worlds [µs a world and control step]."""

    num_worlds: int
    one: float  # full step, one thread
    all: float  # full step, as many threads as are taken by default
    gain: float  # one / all, median of the repeats' own ratios, as `ratio`
    bare: float  # five substeps of pymunk alone
    ratio: float  # one / bare
    vmas: float | None


def compare(num_worlds: int) -> Row:
    """Time everything side by side, alternating within each repeat."""
    steps = max(60, min(1000, 50_000 // num_worlds))
    alone = Transport(num_worlds=num_worlds, threads=1)
    shared = Transport(num_worlds=num_worlds)
    runs: dict[str, Callable[[], float]] = {
        "one": lambda: full_step(alone, steps),
        "all": lambda: full_step(shared, steps),
        "bare": lambda: bare_step(alone, 5, steps),
    }
    if find_spec("vmas"):
        runs["vmas"] = vmas_run(num_worlds, max(10, steps // 10))
    for run in runs.values():
        run()
    times = {name: [] for name in runs}
    for _ in range(REPEATS):
        for name, run in runs.items():
            times[name].append(run() / num_worlds * 1e6)
    return Row(
        num_worlds=num_worlds,
        one=median(times["one"]),
        all=median(times["all"]),
        gain=median(np.divide(times["one"], times["all"])),
        bare=median(times["bare"]),
        ratio=median(np.divide(times["one"], times["bare"])),
        vmas=median(times["vmas"]) if "vmas" in times else None,
    )


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
    torch.set_num_threads(cores())
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
    return _rate(env, list(actions))


def single_parallel() -> float:
    """Steps a second of PettingZoo's parallel view, median."""
    env = beam_transport_v0.parallel_env()
    actions = np.random.default_rng(0).uniform(-1, 1, (150, 2, 3)).astype(np.float32)
    return _rate(env, [dict(zip(env.possible_agents, action, strict=True)) for action in actions])


def _rate(env: Any, actions: Sequence[Any]) -> float:
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
        "one thread [µs a world]",
        "default",
        "gain",
        "pymunk alone, 5 substeps",
        "one thread / pymunk",
        "coopenv [steps/s]",
        "VMAS `transport` [steps/s]",
        "ratio",
    ]
    title = f"Full step (target: ≤ {TARGET_RATIO} × five bare substeps from 256)"
    single = [
        ["`gymnasium.make(...).unwrapped`", f"{single_gymnasium():,.0f}", f"{TARGET_SINGLE:,}"],
        ["`parallel_env()`", f"{single_parallel():,.0f}", f"{TARGET_SINGLE:,}"],
    ]
    return [
        (title, columns, [_line(compare(num_worlds)) for num_worlds in SIZES]),
        ("One world", ["view", "steps/s", "wanted"], single),
    ]


def _line(row: Row) -> list[str]:
    return [
        f"{row.num_worlds:,}",
        f"{row.one:.2f}",
        f"{row.all:.2f}",
        f"{row.gain:.2f}",
        f"{row.bare:.2f}",
        f"{row.ratio:.2f}",
        f"{1e6 / min(row.one, row.all):,.0f}",
        "not installed" if row.vmas is None else f"{1e6 / row.vmas:,.0f}",
        "" if row.vmas is None else f"{row.vmas / min(row.one, row.all):.1f} ×",
    ]


def main() -> None:
    """Print the tables; with ``--write`` also put them on README."""
    (_, columns, rows), (_, views, rates) = tables()
    show(PAGE, {"speed": markdown(columns, rows), "single": markdown(views, rates)})


if __name__ == "__main__":
    main()
