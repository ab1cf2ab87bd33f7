"""Reward terms: success, time, effort, internal force and torque, load share and others.

Each is a class that returns ``(world, agent)``; penalties are negative.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput
from coopenv.transition import Transition
from coopenv.wrench import Decomposition, Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class Success:
    """A bonus in the step in which the task is done."""

    weight: float = 10.0  # [reward]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        return transition.per_agent(transition.success, self.weight)


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeCost:
    """A constant price of time."""

    weight: float = 0.5  # [reward / s]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        cost = np.empty(transition.applied.shape[:2])
        cost.fill(-self.weight * transition.dt)
        return cost


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """Price of what an agent applies: r_i = −weight · ‖f_i‖² − torque_weight · t_i²."""

    weight: float = 1e-4  # [reward / N²]
    torque_weight: float = 1e-4  # [reward / (N·m)²]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        x, y, torque = np.moveaxis(transition.applied, -1, 0)
        return -self.weight * (x * x + y * y) - self.torque_weight * torque * torque


@dataclass(frozen=True, slots=True, kw_only=True)
class InternalForce:
    """Penalise squeezing: r_i = −weight · ‖f_I,i‖  (eq. 5).

    Near ties between splits of equal cost ‖f_I,i‖ can jump; `RelativeCost` is continuous.
    """

    weight: float = 0.01  # [reward / N]
    settings: Settings | None = None  # another decomposition than the environment's

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        internal = _decomposition(transition, self.settings).internal
        return -self.weight * np.hypot(internal[..., 0], internal[..., 1])


@dataclass(frozen=True, slots=True, kw_only=True)
class InternalTorque:
    """Penalise twisting against each other: r_i = −weight · |t_o,I,i|, at the centre of mass.

    t_o,I,i = r_i × f_I,i + t_I,i  (eq. 4); like `InternalForce` it can jump near ties.
    """

    weight: float = 0.01  # [reward / (N·m)]
    settings: Settings | None = None  # another decomposition than the environment's

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        internal = _decomposition(transition, self.settings).internal
        grips = transition.team.grips
        torque = grips[..., 0] * internal[..., 1] - grips[..., 1] * internal[..., 0]
        return -self.weight * np.abs(torque + internal[..., 2])


@dataclass(frozen=True, slots=True, kw_only=True)
class RelativeCost:
    """Penalise the fraction of the applied wrench that fights itself: r = −weight · γ  (eq. 29)."""

    weight: float = 0.1  # [reward / step]
    settings: Settings | None = None  # another decomposition than the environment's

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        decomposition = _decomposition(transition, self.settings)
        return transition.per_agent(decomposition.relative_cost, -self.weight)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadShare:
    """Keep a wanted load share: r_i = −weight · |α_i − wanted_i|  (eq. 25); 0 where undefined."""

    weight: float = 0.1  # [reward / step]
    wanted: float | Sequence[float] | None = None  # one for all, or one an agent; None: 1/n
    of: Literal["force", "torque"] = "force"

    def __post_init__(self) -> None:
        if self.of not in ("force", "torque"):
            raise InvalidInput(f"of must be 'force' or 'torque', got {self.of!r}; choose one")
        if self.wanted is not None:
            wanted = finite_array(self.wanted, "wanted").tolist()
            object.__setattr__(self, "wanted", tuple(wanted) if np.ndim(wanted) else wanted)

    def check(self, num_agents: int) -> None:
        """Raise `InvalidInput` unless there is one wanted share, or one an agent."""
        if np.ndim(self.wanted or 0.0) and np.shape(self.wanted) != (num_agents,):
            raise InvalidInput(
                f"wanted must be one number or one for each of {num_agents} agents, got "
                f"{self.wanted!r}; add or drop entries"
            )

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        self.check(transition.team.num_agents)
        share = getattr(transition.decomposition.load_share, self.of)
        wanted = 1 / transition.team.num_agents if self.wanted is None else np.asarray(self.wanted)
        return np.nan_to_num(-self.weight * np.abs(share - wanted), nan=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionRate:
    """Penalise jerky actions: r_i = −weight · ‖a_i − a_i,before‖²."""

    weight: float = 0.01  # [reward]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        change = transition.action - transition.previous_action
        return -self.weight * np.square(change).sum(axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Penalise pushing against walls and obstacles: r = −weight · impulse."""

    weight: float = 0.05  # [reward / (N·s)]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        return transition.per_agent(transition.contact_impulse, -self.weight)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingError:
    """A price on the distance to the goal for as long as it lasts: r = −weight · distance · dt.

    For references that are to be followed; time itself costs nothing at zero distance.
    """

    weight: float = 2.0  # [reward / (m·s)]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        return transition.per_agent(transition.next_state.distance, -self.weight * transition.dt)


def _decomposition(transition: Transition, settings: Settings | None) -> Decomposition:
    """That of the environment, or another one that the term asks for."""
    return transition.decomposition if settings is None else transition.decompose(settings)
