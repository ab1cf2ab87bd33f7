"""Reward terms of energy: what agents pass to each other, and what the springs of hands hold."""

from dataclasses import dataclass
from typing import ClassVar

from coopenv.arrays import FloatArray, positive
from coopenv.errors import InvalidInput
from coopenv.transition import Transition


@dataclass(frozen=True, slots=True, kw_only=True)
class InternalPower:
    """Penalise power that agents pass to each other: r = −weight · Ė_I / scale.

    Ė_I = ½(Σ|Ė_i| − |ΣĖ_i|) is what some drive and others brake at the same time, of the step's
    mean wrench at its mean twist. Unique, continuous and in watts, and the same for everyone: it
    does not tell who brakes, nor of squeezing, which does no work where nothing moves along it.
    """

    weight: float = 0.1  # [reward / step] at a power of ``scale``
    scale: float = 1.0  # [W] what counts as 1

    def __post_init__(self) -> None:
        positive(self.scale, "scale", unit="W")

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        return transition.per_agent(transition.power.internal, -self.weight / self.scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredEnergy:
    """Penalise stretched hands: r_i = −weight · E_i / scale, each agent its own.

    E_i = (K s² + κ φ²) / 2 is what the springs of hand i hold at the end of the step: how far its
    own plan is from where the object is. Pulling together costs as much as pulling apart, and a
    stiffer hand stores less under the same force.
    """

    needs_hands: ClassVar[bool] = True

    weight: float = 0.1  # [reward / step] at an energy of ``scale``
    scale: float = 0.5  # [J] what counts as 1

    def __post_init__(self) -> None:
        positive(self.scale, "scale", unit="J")

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        stored = transition.stored_energy
        if stored is None:
            raise InvalidInput(
                "StoredEnergy must price steps of hands, got one without them; choose "
                "action='motion' or 'impedance', or leave it out"
            )
        return -self.weight / self.scale * stored
