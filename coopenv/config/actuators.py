"""Checks of actuators against the rest of a configuration, and default ones for drawn numbers."""

import numpy as np

from coopenv.physics.actuators import Actuators
from coopenv.physics.strengths import ACTUATORS
from coopenv.randomisation import Ranges


def actuators_for(
    actuators: Actuators | None, ranges: Ranges | None, num_agents: int
) -> Actuators | None:
    """The actuators of an environment: if none are given but ``ranges`` have some, default ones.

    ``None`` where every command acts as it is.

    Raises
    ------
    InvalidInput
        If a sequence is not of one number an agent.
    """
    drawn = ranges is not None and any(getattr(ranges, name) is not None for name in ACTUATORS)
    if actuators is None:
        return Actuators() if drawn else None
    actuators.check(num_agents)
    return actuators


def longest_delay(actuators: Actuators, ranges: Ranges | None) -> int:
    """The longest delay that there may be in an environment [control steps]."""
    if ranges is not None and ranges.delay is not None:
        return ranges.delay[1]
    return int(np.max(actuators.delay))
