"""The human study of section VI with simulated people: 12 pairs, 3 guides, 10 trials each.

All trials run side by side in one `Transport`, one a world. Every pair has rooms, starts and goals
of its own, the same with each guide, so that within a pair only the guide differs.
"""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.files import written
from coopenv.geometry import frames
from coopenv.physics.scene import Box
from coopenv.tasks import DoorwayTask
from coopenv.transport import Transport

from ...seeds import evaluation_seeds
from ..claims import number, save_rows
from ..tables import Table
from .analysis import GUIDES
from .config import DyadsConfig
from .people import Pairs, Traits
from .trials import entered_first, grips_in_world, table_of

SOURCE = "simulated people"
REST = 0.5  # [s] for which the beam rests on the final platform when a trial ends
STILL = 0.05, 0.05  # [m/s], [rad/s] below which it rests


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DyadsRun:
    """What the simulated study recorded; worlds are pair-major, then guide, then trial."""

    trials: Table  # see coopenv.agents.studies.dyads.trials
    arrived: IntArray  # (pair, guide): trials in which the beam came to rest on the final platform
    first: IntArray  # (pair, guide): trials in which agent 1 entered the final platform first
    duration: FloatArray  # (pair, guide): mean over trials [s]
    people: Traits  # (pair, 2)
    turned_wrong: FloatArray  # (pair, guide): mean angle from the goal's at the end [rad]


def simulate(config: DyadsConfig | None = None) -> DyadsRun:
    """Run all trials and return them as a table."""
    config = config if config is not None else DyadsConfig()
    pair, guide, trial = (
        each.ravel() for each in np.indices((config.pairs, len(GUIDES), config.trials))
    )
    people = config.people.draw(config.seed, config.pairs)
    names = np.array(GUIDES)[guide]
    told = np.stack([names != "none", names == "both"], axis=-1)
    environment = config.environment
    core = Transport(num_worlds=len(pair), config=environment)
    seeds = evaluation_seeds(config.seed, config.pairs * config.trials)
    rooms = [seeds[k] for k in (pair * config.trials + trial).tolist()]
    pose, twist, applied, goal = _recorded(
        core, Pairs(environment, people[pair], told), rooms, config.seed
    )

    task = environment.task
    assert isinstance(task, DoorwayTask)
    grips = grips_in_world(pose, core.team.grips)
    steps, arrived = _ends(twist, grips, task, config.dt)
    low, high = np.array(task.goal_platform)
    entered = entered_first(grips[:-1], Box(center=(low + high) / 2, size=high - low))
    kept = np.arange(len(applied))[:, None] < steps  # (step, world)
    at, world = np.nonzero(kept)
    trials = table_of(
        pair=pair[world] + 1,
        condition=names[world],
        trial=trial[world] + 1,
        time=at * config.dt,
        pose=pose[at, world],
        applied=applied[at, world],
        grips=core.team.grips[0],
        first=entered[world],
    )
    shape = (config.pairs, len(GUIDES), config.trials)
    last = pose[steps, np.arange(len(steps))]
    off = np.abs(frames.wrapped((last - goal)[:, 2]))
    return DyadsRun(
        trials=trials,
        arrived=arrived.reshape(shape).sum(axis=-1),
        first=(entered == 1).reshape(shape).sum(axis=-1),
        duration=(config.dt * steps).reshape(shape).mean(axis=-1),
        people=people,
        turned_wrong=off.reshape(shape).mean(axis=-1),
    )


def course_rows(run: DyadsRun) -> list[dict[str, str]]:
    """How the trials went, one row a guide."""
    pairs, trials = len(run.arrived), run.trials["trial"].nunique()
    return [
        {
            "guide": guide,
            "trials": str(pairs * trials),
            "ended at rest": str(run.arrived[:, i].sum()),
            "agent 1 first": str(run.first[:, i].sum()),
            "duration [s]": number(run.duration[:, i].mean()),
            "off the goal's angle [rad]": number(run.turned_wrong[:, i].mean()),
        }
        for i, guide in enumerate(GUIDES)
    ]


def save(run: DyadsRun, out: Path) -> list[str]:
    """Write the trials as Parquet, and who the people were; names of the files."""
    with written(out / "trials.parquet") as part:
        run.trials.to_parquet(part, index=False)
    files = save_rows(course_rows(run), out / "course")
    return ["trials.parquet", *files, *save_rows(people_rows(run.people), out / "people")]


def people_rows(people: Traits) -> list[dict[str, str]]:
    """Everybody's traits, one row a person; units as in `People`."""
    rows = []
    for pair, agent in np.ndindex(people.delay.shape):
        row = {"pair": str(pair + 1), "agent": str(agent + 1)}
        for entry in fields(people):
            values = np.atleast_1d(getattr(people, entry.name)[pair, agent])
            row[entry.name] = ", ".join(number(float(value)) for value in values)
        rows.append(row)
    return rows


def _recorded(
    core: Transport, pairs: Pairs, rooms: list[int], seed: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Poses and twists at the steps' ends and at the start, wrenches, goals; time first."""
    core.reset(seed=rooms)
    start = core.transition
    assert start is not None
    # the same room with each guide, but not the same tremor
    pairs.reset(start, np.random.default_rng([seed, 6]).spawn(core.num_worlds))
    steps = core.horizon
    pose, twist = np.empty((2, steps + 1, core.num_worlds, 3))
    applied = np.empty((steps, core.num_worlds, 2, 3))
    pose[0], twist[0] = start.next_state.pose, start.next_state.twist
    for step in range(steps):
        before = core.transition
        assert before is not None
        wrench = pairs.act(before)
        action = frames.actions_from_wrenches(wrench, core.team.frame, core.team.limits, 3)
        core.step(np.clip(action, -1.0, 1.0))
        after = core.transition
        assert after is not None
        applied[step] = after.applied
        pose[step + 1], twist[step + 1] = after.next_state.pose, after.next_state.twist
    return pose, twist, applied, start.next_state.goal.copy()


def _ends(
    twist: FloatArray, grips: FloatArray, task: DoorwayTask, dt: float
) -> tuple[IntArray, BoolArray]:
    """Steps that each trial lasts, and whether the beam then rested on the final platform."""
    low, high = np.array(task.goal_platform)
    there = ((grips >= low) & (grips <= high)).all(axis=(-1, -2))
    slow = (np.linalg.norm(twist[..., :2], axis=-1) < STILL[0]) & (abs(twist[..., 2]) < STILL[1])
    still = np.cumsum(there & slow, axis=0)  # (step, world)
    count = round(REST / dt)
    rested = np.zeros(still.shape, dtype=np.bool_)
    rested[count:] = still[count:] - still[:-count] == count
    arrived = np.asarray(rested.any(axis=0))
    return np.where(arrived, rested.argmax(axis=0), len(twist) - 1), arrived
