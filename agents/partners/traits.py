"""Traits of scripted partners: a row of numbers an episode that tells one from another.

All kinds are one model with different numbers, so that a batch in which every world has another
kind takes one pass. An episode has two such rows, between which a partner may switch.
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from coopenv.arrays import FloatArray, Range, number_range, stated_array, whole
from coopenv.chance import Chance
from coopenv.errors import InvalidInput

Span: TypeAlias = float | Range  # a number, or drawn between two in every episode
Steps: TypeAlias = int | tuple[int, int]  # likewise, of control steps, ends included

# Columns of a row
ROLE = 0  # one of the roles below
AWAY_X, AWAY_Y, AWAY_TURN = 1, 2, 3  # from the goal to its plan, world frame [m, m, rad]
STRENGTH = 4  # how much more than its part it gives
GAINS = 5  # six: see `coopenv.agents.controllers.guidance.gains_row`
HEAVINESS = 11  # fraction of the load that is left to whom it follows
EAGERNESS = 12  # [1/s] how briskly it takes up the motion it is led to
SHARE = 13  # of force and torque that it carries
FORCE_NOISE, TORQUE_NOISE = 14, 15  # standard deviations [N], [N·m]
DELAY = 16  # control steps
STAY = 17  # [s] mean time until it switches to its other row; 0: never
KIND = 18  # number of the population's member
YIELDING, TURN_YIELDING = 19, 20  # velocity of its hand for what it feels [m/s/N], [rad/s/(N·m)]
LEAD, TURN_LEAD = 21, 22  # how far its hand goes ahead of its grip at most [m], [rad]
EASING = 23  # [1/s] of the lead
NUM_TRAITS = 24

MOST_DELAY = 10**4  # control steps; what is delayed is kept in memory

PLANS, FOLLOWS, SHARES, WALKS, YIELDS, GUIDES = 0, 1, 2, 3, 4, 5  # roles
ON_WAY = (WALKS, GUIDES)  # roles of those who know the way of the task


def same_twice(count: int, **columns: Any) -> FloatArray:
    """Rows ``(episode, 2, NUM_TRAITS)`` of a partner that does not switch.

    ``columns`` are numbers or ``(episode,)`` arrays by the column's name in lower case.
    """
    rows = np.zeros((count, 2, NUM_TRAITS))
    rows[:, :, STRENGTH] = rows[:, :, HEAVINESS] = 1.0
    for name, value in columns.items():
        rows[:, :, globals()[name.upper()]] = np.reshape(value, (-1, 1))
    return rows


def drawn(span: Span, chance: Chance, name: str) -> FloatArray:
    """A number of each episode, ``(episode,)``, uniform over ``span``."""
    low, high = span if isinstance(span, tuple) else (span, span)
    return low + (high - low) * chance.uniform(name)


def checked_span(value: Any, name: str, *, low: float = 0.0, high: float = np.inf) -> Span:
    """``value`` as a number or a pair of them, or raise `InvalidInput` unless within bounds."""
    ends = stated_array(value, name)
    if ends.shape not in ((), (2,)) or (ends < low).any() or (ends > high).any():
        raise InvalidInput(
            f"{name} must be a number from {low:g} to {high:g}, or two for a range, got {value!r}; "
            "change it"
        )
    return number_range(value, name) if ends.ndim else ends.item()


def own_plan(offset: Span, turn: Span, chance: Chance) -> dict[str, FloatArray]:
    """Columns that move a plan off the goal: by ``offset`` anywhere, by ``turn`` to a side."""
    away = drawn(offset, chance, "offset")
    direction = 2 * np.pi * chance.uniform("bearing")
    side = np.where(chance.uniform("side") < 0.5, -1.0, 1.0)
    return {
        "away_x": away * np.cos(direction),
        "away_y": away * np.sin(direction),
        "away_turn": side * drawn(turn, chance, "turn"),
    }


def drawn_steps(steps: Steps, chance: Chance, name: str) -> FloatArray:
    """Control steps of each episode, ``(episode,)``, as often as not any of ``steps``."""
    low, high = steps if isinstance(steps, Sequence) else (steps, steps)
    return np.floor(drawn((low, high + 1), chance, name))


def checked_steps(value: Any, name: str) -> Steps:
    """``value`` as a whole number or a pair of them, or raise `InvalidInput`."""
    span = checked_span(value, name)
    if isinstance(span, tuple):
        low, high = (whole(end, name, at_least=0, at_most=MOST_DELAY) for end in value)
        return low, high
    return whole(value, name, at_least=0, at_most=MOST_DELAY)


def highest(span: Span | Sequence[float]) -> float:
    """The largest number of a span."""
    return max(span) if isinstance(span, Sequence) else span
