"""What scripted partners add to a step, beside the bare physics in the same run."""

import time

import numpy as np

from benchmarks.transport import REPEATS, bare_step, full_step, random_actions
from coopenv import Transport, TransportTask
from coopenv.agents.partners import PARTNERS
from coopenv.arrays import FloatArray

WORLDS = 1024
TARGET = 1.0  # what a partner adds to a step, to bare pymunk at the same substeps


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    title = f"Partners in {WORLDS:,} worlds (target: ≤ {TARGET:g} × bare pymunk)"
    columns = [
        "partner",
        "adds to a random team's step [µs/world]",
        "adds to a step of the same motion",
        "its own work",
        "the core's physics",
        "first / bare pymunk, same substeps",
        "second / bare",
        "own / bare",
    ]
    return [(title, columns, _costs())]


def _costs() -> list[list[str]]:
    """What each kind of partner adds to a step, beside the bare physics; a line a kind.

    Added to the step of a team that moves at random, and to that of one that is told to move as
    the partner and the learner do: pymunk takes longer where bodies move faster.
    """
    never = TransportTask(position_tolerance=1e-9)  # or partners would be charged for resets
    alone = Transport(num_worlds=WORLDS, task=never)
    cores = {name: Transport(num_worlds=WORLDS, task=never, partner=name) for name in PARTNERS}
    steps = 40
    moves = {name: _joint_actions(core, steps) for name, core in cores.items()}
    seen = {name: [] for name in cores}
    for _ in range(REPEATS):
        for name, core in cores.items():
            bare = bare_step(alone, alone.substeps, steps)
            full, random = full_step(core, steps), full_step(alone, steps)
            same = full_step(alone, steps, moves[name])
            own, physics = _own_work(core, steps)
            added = (full - random, full - same)
            seen[name].append((*added, own, physics, *np.divide((*added, own), bare)))
    lines = []
    for name, times in seen.items():
        *costs, random, same, own = np.median(times, axis=0)
        micro = [f"{cost / WORLDS * 1e6:.2f}" for cost in costs]
        lines.append([name, *micro, f"{random:.2f}", f"{same:.2f}", f"{own:.2f}"])
    return lines


def _joint_actions(core: Transport, steps: int) -> FloatArray:
    """What everybody does, ``(step, world, agent, 3)``, when the learners act at random."""
    core.reset(seed=0)
    joint = []
    for action in random_actions(core, steps):
        core.step(action)
        assert core.transition is not None
        joint.append(core.transition.action)
    return np.array(joint)


def _own_work(core: Transport, steps: int) -> tuple[float, float]:
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
