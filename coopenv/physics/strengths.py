"""Strengths of a team: numbers that are one for all agents or one each, and their table's columns.

A table has one row an agent: its limits, then, where there are any, its hands (`coopenv.Hands`) and
its actuators (`coopenv.Actuators`).
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

from coopenv.arrays import LARGEST, FloatArray, stated_array
from coopenv.errors import InvalidInput

LIMITS = ("force_limit", "torque_limit")
HANDS = ("stiffness", "torque_stiffness", "damping", "torque_damping", "speed", "turn_rate")
ACTUATORS = ("delay", "time_constant", "rate_limit")

PerAgent: TypeAlias = float | Sequence[float]


def columns(width: int) -> tuple[str, ...]:
    """Names of the columns of a table that is so wide, in order."""
    rest = width - len(LIMITS)
    hands = HANDS if rest >= len(HANDS) else ()
    return (*LIMITS, *hands, *(ACTUATORS if rest > len(hands) else ()))


def parted(strengths: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Limits, hands and actuators ``(..., agent, column)``, each in memory of its own.

    Hands and actuators that there are none of have no column.
    """
    names, first = columns(strengths.shape[-1]), len(LIMITS)
    last = first + (len(HANDS) if HANDS[0] in names else 0)
    return (
        strengths[..., :first].copy(),
        strengths[..., first:last].copy(),
        strengths[..., last:].copy(),
    )


def per_agent(value: Any, name: str, *, or_zero: bool) -> float | tuple[float, ...]:
    """One number, or a tuple of one an agent, in bounds; else raises `InvalidInput`."""
    given = stated_array(value, name)
    out = (given < 0) | (given > LARGEST) | ((given == 0) & (not or_zero))
    if given.ndim > 1 or given.size == 0 or out.any():
        rule = "zero or positive" if or_zero else "positive"
        raise InvalidInput(
            f"{name} must be {rule}, one number or one an agent, at most {LARGEST:g}, got "
            f"{value!r}; give it in SI units"
        )
    return tuple(given.tolist()) if given.ndim else given.item()


def check_count(value: Any, name: str, num_agents: int) -> None:
    """Raise `InvalidInput` where ``value`` is a tuple that is not of one number an agent."""
    if isinstance(value, tuple) and len(value) != num_agents:
        raise InvalidInput(
            f"{name} must be one number or one for each of {num_agents} agents, got {value!r}; "
            "add or drop numbers"
        )
