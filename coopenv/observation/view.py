"""The agents' view: goal, motion and wrenches of a step in each agent's frame, one row an agent.

`VIEW` is the table of a row: its blocks in order, with their sizes. Where each begins, and how wide
a row is, follows from it.
"""

from collections import namedtuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import IntArray
from coopenv.compiled import compiled, inlined
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.measured import SHARES
from coopenv.observation.block import Block, EachOther
from coopenv.transition import Transition
from coopenv.wrench.measures import RELATIVE_COST

WRENCH_UNIT = "N, N, N·m"

VIEW = (
    Block(
        name="goal",
        size=4,
        describe="way from the object to its goal: Δx, Δy, cos Δθ, sin Δθ; 0 where not told",
        unit="m, m, 1, 1",
        frame="agent",
        needs_told=(0, 0, 1, 1),
    ),
    Block(
        name="twist",
        size=3,
        describe="velocity of the object's centre of mass, and its spin",
        unit="m/s, m/s, rad/s",
        frame="agent",
    ),
    Block(
        name="own_wrench",
        size=3,
        describe="force and torque this agent applied",
        unit=WRENCH_UNIT,
        frame="agent",
    ),
    Block(
        name="partner_wrench",
        size=EachOther(3),
        describe="force and torque each other agent applied",
        unit=WRENCH_UNIT,
        frame="agent",
    ),
    Block(
        name="own_internal",
        size=3,
        describe="internal part of this agent's wrench",
        unit=WRENCH_UNIT,
        frame="agent",
    ),
    Block(
        name="partner_internal",
        size=EachOther(3),
        describe="internal part of each other agent's wrench",
        unit=WRENCH_UNIT,
        frame="agent",
    ),
    Block(
        name="load_share",
        size=2,
        describe="this agent's share of the force and of the torque; 1/n where undefined",
        low=0.0,
        high=1.0,
        unit="1",
    ),
    Block(
        name="relative_cost",
        size=1,
        describe="γ, the fraction of the applied wrench's cost that was compensated",
        unit="1",
    ),
)
VIEW_PARTS = tuple(block.name for block in VIEW)
DECOMPOSED = ("own_internal", "partner_internal", "load_share", "relative_cost")

_NO_MEASURES = np.empty((0, 0))
_PART = namedtuple("_PART", VIEW_PARTS)(*range(len(VIEW)))  # the number of each, for the kernel


def write_view(
    transition: Transition, begin: IntArray, decomposed: bool, seen: npt.NDArray[np.float32]
) -> None:
    """Write parts of the view into rows ``(world, agent, feature)``.

    Parameters
    ----------
    transition
        Which step.
    begin
        Of each block of `VIEW` in a row; -1 for one that is not wanted.
    decomposed
        Whether one of `DECOMPOSED` is wanted.
    seen
        Written.
    """
    state, conditions, applied = transition.next_state, transition.conditions, transition.applied
    if decomposed:
        measures = transition.measures
        manipulation = np.ascontiguousarray(transition.decomposition.manipulation)
    else:
        measures, manipulation = _NO_MEASURES, applied
    _write_view(
        *sharing_rows(len(applied)), begin, state.pose, state.twist, state.goal, conditions.told,
        conditions.team.frame, applied, manipulation, measures, seen,
    )  # fmt: skip


@compiled
def _write_part(
    start, stop, begin, pose, twist, goal, told, frame, applied, manipulation, measures, seen
):
    """See `write_view`; of worlds from ``start`` to before ``stop``.

    Parameters
    ----------
    pose, twist, goal
        ``(world, 3)`` each, world frame.
    told
        ``(world, agent, 2)``: whether an agent is told the goal's place and its angle.
    frame
        ``(world, agent, 2)``.
    applied, manipulation
        ``(world, agent, 3)`` each, object frame; of the latter perhaps more than the agents'.
    measures
        As `Transition.measures`.
    """
    num_agents = frame.shape[1]
    for k in range(start, stop):
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        dx, dy, turn = goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1], goal[k, 2] - pose[k, 2]
        cos_turn, sin_turn = np.cos(turn), np.sin(turn)
        for i in range(num_agents):
            row, c_own, s_own = seen[k, i], frame[k, i, 0], frame[k, i, 1]
            c, s = rotated(cos_object, sin_object, c_own, s_own)

            at = begin[_PART.goal]
            if at >= 0:
                away, across = rotated_back(c, s, dx, dy)
                row[at], row[at + 1] = (away, across) if told[k, i, 0] else (0.0, 0.0)
                row[at + 2], row[at + 3] = (cos_turn, sin_turn) if told[k, i, 1] else (0.0, 0.0)

            at = begin[_PART.twist]
            if at >= 0:
                row[at], row[at + 1] = rotated_back(c, s, twist[k, 0], twist[k, 1])
                row[at + 2] = twist[k, 2]

            own, others = begin[_PART.own_wrench], begin[_PART.partner_wrench]
            for step in range(num_agents):  # its own, then the others' in order
                at = own if step == 0 else others
                if at >= 0:
                    other = (i + step) % num_agents
                    x, y, torque = applied[k, other, 0], applied[k, other, 1], applied[k, other, 2]
                    _write_wrench(x, y, torque, c_own, s_own, row, at + 3 * max(step - 1, 0))

            own, others = begin[_PART.own_internal], begin[_PART.partner_internal]
            for step in range(num_agents):
                at = own if step == 0 else others
                if at >= 0:
                    other = (i + step) % num_agents
                    x = applied[k, other, 0] - manipulation[k, other, 0]
                    y = applied[k, other, 1] - manipulation[k, other, 1]
                    torque = applied[k, other, 2] - manipulation[k, other, 2]
                    _write_wrench(x, y, torque, c_own, s_own, row, at + 3 * max(step - 1, 0))

            at = begin[_PART.load_share]
            if at >= 0:
                row[at], row[at + 1] = measures[k, SHARES + i], measures[k, SHARES + num_agents + i]
            at = begin[_PART.relative_cost]
            if at >= 0:
                row[at] = measures[k, RELATIVE_COST]


@inlined
def _write_wrench(x, y, torque, c, s, row, at):
    """Write an agent's wrench as it is seen along the axis (c, s) of the object frame."""
    row[at], row[at + 1] = rotated_back(c, s, x, y)
    row[at + 2] = torque


@compiled
def _write_view(
    board, parts, begin, pose, twist, goal, told, frame, applied, manipulation, measures, seen
):
    """`_write_part` of all worlds, `spread`."""
    arguments = (
        begin, pose, twist, goal, told, frame, applied, manipulation, measures, seen,
    )  # fmt: skip
    spread(board, parts, len(applied), _write_part, arguments)
