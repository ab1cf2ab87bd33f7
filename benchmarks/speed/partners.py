"""Benchmark of scripted partners: the time they add to a step, beside bare physics."""

import time

import numpy as np

from benchmarks.speed.transport import REPEATS, bare_steps
from coopenv import Transport, TransportTask
from coopenv.agents.partners import PARTNERS
from coopenv.arrays import FloatArray
from coopenv.bench import full_steps, random_actions
from coopenv.envs.registry import PREFIX, find_config

WORLDS = 1024
STEPS = 40  # a run
WITH_WAYS = ("impedance", "walking", "robot")
ENVIRONMENTS = (
    "BeamTransport",
    "BeamDoorway",
    "BeamTracking",
    "WalkerTurn",
    "WalkerAvoid",
    "BeamLift",
)
TARGET = 1.0  # what a partner adds to a step, to bare pymunk at the same substeps


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    title = f"Partners in {WORLDS:,} worlds (target: ≤ {TARGET:g} × bare pymunk)"
    columns = [
        "partner",
        "adds to a random team's step [µs/world]",
        "adds to a step of the same motion",
        "its own work",
        "bare pymunk, same substeps",
        "first / bare",
        "second / bare",
        "own / bare",
    ]
    ways = f"Partners' own work in {WORLDS:,} worlds [µs/world]: who knows the way has to find it"
    return [(title, columns, _costs()), (ways, ["environment", *WITH_WAYS], _ways())]


def _ways() -> list[list[str]]:
    """A line an environment: the own work of a partner that heads straight, and of two others."""
    lines = []
    for env in ENVIRONMENTS:
        cores = [
            Transport(num_worlds=WORLDS, config=find_config(f"{PREFIX}{env}-v0", {"partner": name}))
            for name in WITH_WAYS
        ]
        for core in cores:
            core.reset(seed=0)
        runs = [[_own_work(core) for core in cores] for _ in range(REPEATS)]
        lines.append([env, *(f"{cost / WORLDS * 1e6:.2f}" for cost in np.median(runs, axis=0))])
    return lines


def _costs() -> list[list[str]]:
    """A line a kind: what it adds to the step of a team, and its share of that.

    Added to the step of a team that moves at random, and to that of one that is told to move as
    the partner and the learner do: pymunk takes longer where bodies move faster. All of them take
    their steps in turn.
    """
    never = TransportTask(position_tolerance=1e-9)  # or partners would be charged for resets
    random, told, bare = (Transport(num_worlds=WORLDS, task=never) for _ in range(3))
    lines = []
    for name in (name for name, kind in PARTNERS.items() if not kind.needs_hands):
        core = Transport(num_worlds=WORLDS, task=never, partner=name)
        same, seen = _joint_actions(core, STEPS), []
        for _ in range(REPEATS):
            runs = zip(
                full_steps(core, random_actions(core, STEPS)),
                full_steps(random, random_actions(random, STEPS)),
                full_steps(told, same),
                bare_steps(bare, bare.substeps, STEPS),
                strict=True,
            )
            full, at_random, alike, physics = np.mean(list(runs), axis=0)
            added, own = (full - at_random, full - alike), _own_work(core)
            seen.append((*added, own, physics, *np.divide((*added, own), physics)))
        *costs, first, second, third = np.median(seen, axis=0)
        micro = [f"{cost / WORLDS * 1e6:.2f}" for cost in costs]
        lines.append([name, *micro, f"{first:.2f}", f"{second:.2f}", f"{third:.2f}"])
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


def _own_work(core: Transport) -> float:
    """Seconds of a step that the partner takes for itself, asked again and again."""
    driven, last = core.driven, core.transition
    assert last is not None
    action = np.zeros((core.num_worlds, len(core.learners), 3))
    began = time.perf_counter()
    for _ in range(STEPS):
        driven.joint(action, last)
        driven.info(last)
    return (time.perf_counter() - began) / STEPS
