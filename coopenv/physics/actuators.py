"""Actuators: how late, how slowly and how steeply what agents command comes to act."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from coopenv.arrays import LARGEST, FloatArray, stated_array, whole
from coopenv.errors import InvalidInput
from coopenv.physics.strengths import ACTUATORS, PerAgent, check_count, per_agent

# Columns of a table of actuators, one row an agent.
DELAY, TIME_CONSTANT, RATE_LIMIT = range(3)

LONGEST_DELAY = 10**4  # [control steps]; every command under way is kept
UNLIMITED = LARGEST  # [1/s] in a table: more than any command can change by in the shortest step


@dataclass(frozen=True, slots=True, kw_only=True)
class Actuators:
    """A delay, then a first-order lag, then a limit of the rate: what lies behind every action.

    What they do to commands is in `coopenv.stepping.actuation`. Each number is one for all agents,
    or a sequence of one an agent; the defaults let every command through as it is.

    Parameters
    ----------
    delay
        Control steps from a command to the step in which it begins to act.
    time_constant
        Of the lag: of a change that is held, e⁻¹ is left after this time.
    rate_limit
        By how much each component of an action may change in a second: with 4, the way from none
        to full takes 0.25 s. ``None``, or ``None`` for an agent: as fast as it likes.

    Raises
    ------
    InvalidInput
        If a value breaks its rule.
    """

    delay: int | Sequence[int] = 0  # [control steps]
    time_constant: PerAgent = 0.0  # [s]
    rate_limit: float | Sequence[float | None] | None = None  # [1/s]

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "delay", _delays(self.delay))
        _set(
            self,
            "time_constant",
            per_agent(self.time_constant, "actuators.time_constant", or_zero=True),
        )
        _set(self, "rate_limit", _rates(self.rate_limit))

    def check(self, num_agents: int) -> None:
        """Raise `InvalidInput` where a sequence is not of one number an agent."""
        for entry in fields(self):
            check_count(getattr(self, entry.name), f"actuators.{entry.name}", num_agents)

    def table(self, num_agents: int) -> FloatArray:
        """``(agent, 3)``: the columns that this module numbers; no limit is `UNLIMITED`."""
        table = np.empty((num_agents, len(ACTUATORS)))
        table[:, DELAY], table[:, TIME_CONSTANT] = self.delay, self.time_constant
        rates = self.rate_limit if isinstance(self.rate_limit, tuple) else (self.rate_limit,)
        table[:, RATE_LIMIT] = [UNLIMITED if rate is None else rate for rate in rates]
        return table


def _delays(value: Any) -> int | tuple[int, ...]:
    """One whole number, or a tuple of one an agent."""
    name = "actuators.delay"
    given = stated_array(value, name)
    if given.ndim > 1 or given.size == 0:
        raise InvalidInput(
            f"{name} must be one whole number or one an agent, got {value!r}; count control steps"
        )
    steps = given.ravel().tolist()
    whole_steps = tuple(whole(each, name, at_least=0, at_most=LONGEST_DELAY) for each in steps)
    return whole_steps if given.ndim else whole_steps[0]


def _rates(value: Any) -> float | tuple[float | None, ...] | None:
    """``None``, one positive number, or a tuple of either, one an agent."""
    if value is None:
        return None
    name = "actuators.rate_limit"
    if isinstance(value, list | tuple) and any(each is None for each in value):
        given = [each if each is None else per_agent(each, name, or_zero=False) for each in value]
        if all(each is None or isinstance(each, float) for each in given):
            return tuple(given)  # pyright: ignore[reportReturnType]
    return per_agent(value, name, or_zero=False)
