"""Teams drawn at random: how strong they are, by what they act, and how late."""

from typing import Any

import numpy as np

from coopenv import Actuators, Hands, TransportConfig
from coopenv.config import ACTIONS
from coopenv.pushes import PUSHES


def any_team(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Limits, kind of action, hands if they act, and who is told the goal."""
    agents = config.num_agents
    action = str(rng.choice(list(ACTIONS)))
    table = rng.uniform(-1.0, 1.0, (rng.integers(2, 30), 3)).tolist()
    told = tuple(int(k) for k in np.flatnonzero(rng.random(agents) < 0.5))
    return {
        "action": action,
        "pushes": str(rng.choice(list(PUSHES))) if rng.random() < 0.7 else table,
        "hands": any_hands(rng, agents) if action in ("motion", "impedance") else None,
        "force_limit": tuple(rng.uniform(1.0, 20.0, agents)),
        "torque_limit": tuple(rng.uniform(0.5, 10.0, agents)),
        "informed": None if rng.random() < 0.3 else told,
    }


def any_hands(rng: np.random.Generator, agents: int) -> Hands:
    """Hands of all agents alike, or of each its own."""

    def one_or_each(low: float, high: float) -> float | tuple[float, ...]:
        """In geometric proportion."""
        drawn = np.exp(rng.uniform(np.log(low), np.log(high), agents))
        return _one_or_each(rng, drawn.tolist())

    joint = bool(rng.random() < 0.2)  # a ball joint
    softest, slowest = rng.uniform(0.1, 1.0, 2)
    return Hands(
        stiffness=one_or_each(5.0, 1_000.0),
        torque_stiffness=0.0 if joint else one_or_each(0.5, 100.0),
        damping=0.0 if rng.random() < 0.2 else one_or_each(1.0, 100.0),
        torque_damping=0.0 if joint else one_or_each(0.1, 20.0),
        speed=one_or_each(0.1, 3.0),
        turn_rate=one_or_each(0.1, 3.0),
        stiffness_factors=(softest, rng.uniform(1.0, 4.0)),
        damping_factors=(slowest, rng.uniform(1.0, 4.0)),
    )


def any_actuators(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Actuators of all agents alike, or of each its own, some of which let all through."""
    agents = config.num_agents
    delays = rng.integers(0, 6, agents).tolist()
    constants = (rng.uniform(0.01, 0.5, agents) * (rng.random(agents) < 0.7)).tolist()
    rates = np.exp(rng.uniform(np.log(0.5), np.log(20.0), agents)).tolist()
    limits = [None if rng.random() < 0.3 else rate for rate in rates]
    return {
        "actuators": Actuators(
            delay=_one_or_each(rng, delays),
            time_constant=_one_or_each(rng, constants),
            rate_limit=_one_or_each(rng, limits),
        )
    }


def _one_or_each(rng: np.random.Generator, drawn: list[Any]) -> Any:
    """The first for all agents, or one for each."""
    return tuple(drawn) if rng.random() < 0.5 else drawn[0]
