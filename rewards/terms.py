"""Reward terms: success, time, effort, internal force, wasted cost, load share and others.

Each is a class that returns ``(world, agent)``; penalties are negative. Terms that price a
decomposition say what they can tell and what not; `docs/decomposition.md` compares them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from coopenv.arrays import FloatArray, number, positive, stated_array
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.transition import Transition
from coopenv.wrench import Decomposition, Settings
from coopenv.wrench.grasp import moment


@dataclass(frozen=True, slots=True, kw_only=True)
class Success:
    """A bonus in the step in which the task is done, and its loss in one in which it failed."""

    weight: float = 10.0  # [reward]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        success, terminated = transition.success, transition.terminated
        return _outcome(success, terminated, self.weight, transition.team.num_agents)


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

    def __post_init__(self) -> None:
        number(self.torque_weight, "torque_weight")

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        x, y, torque = np.moveaxis(transition.applied, -1, 0)
        return -self.weight * (x * x + y * y) - self.torque_weight * torque * torque


@dataclass(frozen=True, slots=True, kw_only=True)
class InternalForce:
    """Penalise squeezing: r_i = −weight · ‖f_I,i‖  (eq. 5).

    Tells each of two agents its part of the fight in newtons. Where splits of equal cost exist
    ‖f_I,i‖ is the solver's choice: it jumps near ties, and of four agents and more who is blamed
    can be arbitrary. `WastedCost` is neither.
    """

    weight: float = 0.01  # [reward / N]
    settings: Settings | None = None  # another decomposition than the environment's

    def __post_init__(self) -> None:
        _check_settings(self.settings)

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        internal = transition.of_agents(decomposed(transition, self).internal)
        return -self.weight * np.hypot(internal[..., 0], internal[..., 1])


@dataclass(frozen=True, slots=True, kw_only=True)
class InternalTorque:
    """Penalise twisting against each other: r_i = −weight · |t_o,I,i|, at the centre of mass.

    t_o,I,i = r_i × f_I,i + t_I,i  (eq. 4). As with `InternalForce`, it jumps near ties and who is
    blamed can be the solver's choice.
    """

    weight: float = 0.01  # [reward / (N·m)]
    settings: Settings | None = None  # another decomposition than the environment's

    def __post_init__(self) -> None:
        _check_settings(self.settings)

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        internal = transition.of_agents(decomposed(transition, self).internal)
        torque = moment(transition.team.grips, internal)[..., 0] + internal[..., 2]
        return -self.weight * np.abs(torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class RelativeCost:
    """Penalise the fraction of the applied wrench that fights itself: r = −weight · γ  (eq. 29).

    Unique and continuous but for no wrench at all, and the same for everyone: it does not tell who
    fights. Nor how hard: the noise of idle hands, of any size, reads 0.15 to 0.25, and pushing
    harder together lowers it. `WastedCost` is in newtons.
    """

    weight: float = 0.1  # [reward / step]
    settings: Settings | None = None  # another decomposition than the environment's

    def __post_init__(self) -> None:
        _check_settings(self.settings)

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        decomposition = decomposed(transition, self)
        return transition.per_agent(decomposition.relative_cost, -self.weight)


@dataclass(frozen=True, slots=True, kw_only=True)
class WastedCost:
    """Penalise what the team spends against itself: r = −weight · (J(h) − J(h_M)) / scale.

    Unique, continuous and in newtons, torques counting per metre (J is eq. 17): next to nothing for
    idle hands. At w = 0.5, two agents who press against each other with 10 N waste 10 N. It does
    not tell who fights, and little of squeezing across a common effort, which costs few newtons
    more: of 4 N across 10 N each, 0.8 N is waste and `InternalForce` finds all 4 N.
    """

    weight: float = 0.1  # [reward / step] at a waste of ``scale``
    scale: float = 10.0  # [N] what counts as 1
    settings: Settings | None = None  # another decomposition than the environment's

    def __post_init__(self) -> None:
        positive(self.scale, "scale", unit="N")
        _check_settings(self.settings)

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        decomposition = decomposed(transition, self)
        return transition.per_agent(decomposition.wasted_cost, -self.weight / self.scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadShare:
    """Keep a wanted load share: r_i = −weight · |f_iᵀf̂_o − wanted_i ‖f_o‖| / scale  (eq. 25).

    What agent i bears along the resultant, f̂_o its direction, is compared with its wanted part of
    the resultant; for ``of="torque"`` likewise with t_o,i and t_o (eq. 4). Where nobody pulls
    against the resultant that is ‖f_o‖ · |α_i − wanted_i|; pulling against it is charged in full.
    Where the resultant vanishes α_i is undefined, and all that an agent applies is charged, as in
    the limit of a resultant along its own force. Idle hands cost nothing.

    It tells how the load is shared, not whether forces across the resultant fight. Near a vanishing
    resultant its direction, and with it the price, can jump; never by more than what is applied.

    With ``scale=None`` the price is r_i = −weight · |α_i − wanted_i|, in parts of whatever the
    resultant is, and 0 where that vanishes: agents who cancel each other exactly then pay nothing.
    """

    weight: float = 0.1  # [reward / step] at a deviation of ``scale``
    wanted: float | Sequence[float] | None = None  # one for all, or one an agent; None: 1/n
    of: Literal["force", "torque"] = "force"
    scale: float | None = 10.0  # [N], of torque [N·m]: what counts as 1; None: the resultant

    def __post_init__(self) -> None:
        if not isinstance(self.of, str) or self.of not in ("force", "torque"):
            raise InvalidInput(f"of must be 'force' or 'torque', got {self.of!r}; choose one")
        if self.scale is not None:
            positive(self.scale, "scale", unit="N" if self.of == "force" else "N·m")
        if self.wanted is not None:
            wanted = stated_array(self.wanted, "wanted").tolist()
            object.__setattr__(self, "wanted", tuple(wanted) if np.ndim(wanted) else wanted)

    def check(self, num_agents: int) -> None:
        """Raise `InvalidInput` unless there is one wanted share, or one an agent."""
        wanted = 0.0 if self.wanted is None else self.wanted
        if np.ndim(wanted) and np.shape(wanted) != (num_agents,):
            raise InvalidInput(
                f"wanted must be one number or one for each of {num_agents} agents, got "
                f"{self.wanted!r}; add or drop entries"
            )

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        self.check(transition.team.num_agents)
        share = getattr(transition.load_share, self.of)
        wanted = 1 / transition.team.num_agents if self.wanted is None else np.asarray(self.wanted)
        if self.scale is None:
            return np.nan_to_num(-self.weight * np.abs(share - wanted), nan=0.0)
        parts = self._parts(transition)  # (world, agent, 2) [N] or (world, agent, 1) [N·m]
        total = parts.sum(axis=1, keepdims=True)
        size = np.linalg.norm(total, axis=-1)  # (world, 1)
        along = (parts * total).sum(axis=-1) / np.where(size > 0.0, size, 1.0)
        deviation = np.abs(along - wanted * size)
        undefined = np.isnan(share)
        if undefined.any():
            deviation = np.where(undefined, np.linalg.norm(parts, axis=-1), deviation)
        return -self.weight / self.scale * deviation

    def _parts(self, transition: Transition) -> FloatArray:
        """Of each agent, the force or the torque at the centre of mass."""
        applied = transition.applied
        if self.of == "force":
            return applied[..., :2]
        return moment(transition.team.grips, applied) + applied[..., 2:]


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionRate:
    """Penalise jerky actions: r_i = −weight · ‖a_i − a_i,before‖².

    Those that agents command, whatever `coopenv.Actuators` make of them.
    """

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


def decomposed(
    transition: Transition, term: InternalForce | InternalTorque | RelativeCost | WastedCost
) -> Decomposition:
    """The environment's decomposition, or another one that the term asks for."""
    settings = term.settings
    return transition.decomposition if settings is None else transition.decompose(settings)


def _check_settings(settings: Any) -> None:
    if settings is not None and not isinstance(settings, Settings):
        raise InvalidInput(
            f"settings must be a coopenv.wrench.Settings or None, got {settings!r}; None is the "
            "environment's own decomposition"
        )


@compiled
def _outcome(success, terminated, weight, num_agents):
    """``weight`` where a task is done, minus that where it failed, ``(world, agent)``."""
    paid = np.zeros((len(success), num_agents))
    for world in range(len(success)):
        if success[world]:
            paid[world, :] = weight
        elif terminated[world]:
            paid[world, :] = -weight
    return paid
