"""Benchmark of going on from a state, for docs/state.md: what comes back to the bit, and how near.

Worlds of every id are pushed about at random, each push held for over a second. Again and again
their state is kept, random actions follow, the state is put back, and the same actions follow.

    python -m benchmarks.state            # prints the table
    python -m benchmarks.state --write    # and writes docs/state.md
"""

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from benchmarks.pages import DOCS, markdown, show
from coopenv import Transport
from coopenv.arrays import BoolArray, FloatArray
from coopenv.envs.registry import PREFIX, find_config

NUM_WORLDS, NUM_STATES, BETWEEN, HOLD = 64, 20, 10, 25
STEPS, MOMENTS = 100, (1, 20, 100)  # [control steps] after the state
PAGE = DOCS / "state.md"
COLUMNS = (
    "id",
    "states that touch",
    *(f"apart at step {moment}: median, 99 %, most" for moment in MOMENTS),
    "states that touch nothing till then",
    "of these to the bit",
)


@dataclass(frozen=True)
class Row:
    """What was found in the worlds of one id."""

    name: str
    apart: FloatArray  # (state in contact, moment) [m] at most between two places of one point
    free: int  # states of worlds that touched nothing in the step before nor in those after
    exact: int  # of these: every pose and twist came back to the bit


@dataclass(frozen=True)
class Run:
    """`STEPS` steps from one state."""

    pose: FloatArray  # (step, world, 3)
    twist: FloatArray
    touched: BoolArray  # (world,) whether anything was touched
    ended: BoolArray  # (world,) whether an episode ended, so that another place began


def measure(name: str, num_states: int = NUM_STATES) -> Row:
    """Keep states and go on from them twice."""
    core = Transport(num_worlds=NUM_WORLDS, config=find_config(name, {"horizon": 10**6}))
    core.reset(seed=0)
    rng = np.random.default_rng(1)
    shape = NUM_WORLDS, len(core.learners), core.action_size
    apart, free, exact = [], 0, 0
    ended, touching = (np.zeros(NUM_WORLDS, dtype=np.bool_) for _ in range(2))
    push = np.zeros(shape)
    for step in range(num_states * BETWEEN):
        if step % HOLD == 0:
            push = rng.uniform(-1.0, 1.0, shape)
        _, _, terminated, _, info = core.step(push, restart=ended)
        ended, touching = terminated, _touch(info)
        if (step + 1) % BETWEEN:
            continue
        state, actions = core.get_state(), rng.uniform(-1.0, 1.0, (STEPS, *shape))
        first = _run(core, actions, ended)
        core.set_state(state)
        second = _run(core, actions, ended)
        core.set_state(state)
        alike = (first.pose == second.pose).all((0, 2)) & (first.twist == second.twist).all((0, 2))
        untouched = ~(touching | first.touched)
        free, exact = free + untouched.sum(), exact + (untouched & alike).sum()
        counted = touching & ~(first.ended | second.ended)
        apart.append(_apart(core, first.pose, second.pose)[:, counted].T)
    return Row(name, np.concatenate(apart), int(free), int(exact))


def _touch(info: Any) -> BoolArray:
    return (info["contact_impulse"] != 0) | (info["contact_shift"] != 0)


def _run(core: Transport, actions: FloatArray, ended: BoolArray) -> Run:
    poses, twists, touched, any_ended = [], [], np.zeros_like(ended), ended.copy()
    for action in actions:
        _, _, ended, _, info = core.step(action, restart=ended)
        poses.append(core.world.pose)
        twists.append(core.world.twist)
        touched, any_ended = touched | _touch(info), any_ended | ended
    return Run(np.array(poses), np.array(twists), touched, any_ended)


def _apart(core: Transport, one: FloatArray, other: FloatArray) -> FloatArray:
    """How far apart the same point of a body may be, ``(moment, world)`` [m]."""
    at = np.array(MOMENTS) - 1
    away = one[at] - other[at]
    reach = np.array([body.reach for body in core.bodies])
    return np.hypot(away[..., 0], away[..., 1]) + reach * np.abs(away[..., 2])


def table(rows: list[Row]) -> str:
    """The page's table."""
    lines = []
    for row in rows:
        quantiles = 1000 * np.percentile(row.apart, (50, 99, 100), axis=0).T  # [mm]
        cells = [", ".join(f"{number:.1f}" for number in each) + " mm" for each in quantiles]
        lines.append([row.name, str(len(row.apart)), *cells, str(row.free), str(row.exact)])
    return markdown(COLUMNS, lines)


def main() -> None:
    """Print the table; with ``--write`` also put it on the page."""
    ids = [name for name in gymnasium.registry if name.startswith(PREFIX)]
    show(PAGE, {"table": table([measure(name) for name in ids])})


if __name__ == "__main__":
    main()
