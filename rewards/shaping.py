"""Potential-based reward shaping (Ng, Harada & Russell 1999), and progress towards the goal."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from coopenv.arrays import FloatArray, positive
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.transition import State, Transition

Potential: TypeAlias = Callable[[State], FloatArray]  # -> (world,)


def closeness(state: State) -> FloatArray:
    """Minus the task's distance to the goal, ``(world,)`` [m]."""
    return -state.distance


@dataclass(frozen=True, slots=True, kw_only=True)
class PotentialShaping:
    """Reward for climbing a potential: r = weight · (discount · Φ(s') − Φ(s)).

    Φ(s') counts as 0 where the task is done, so that with the trainer's own discount no policy that
    does it changes its rank. Truncation does not end the task: there Φ(s') counts in full. So it
    does where a task failed: it would else pay for the way that is left.

    With ``discount`` < 1 and a negative potential, standing still earns (1 − discount) · |Φ| a
    step; with 1 it earns nothing.
    """

    potential: Potential
    discount: float  # the trainer's
    weight: float = 1.0  # [reward / unit of the potential]

    def __post_init__(self) -> None:
        if not callable(self.potential):
            raise InvalidInput(
                f"potential must be a function of a state, got {self.potential!r}; return "
                "one number a world"
            )
        if not 0 < positive(self.discount, "discount") <= 1:
            raise InvalidInput(
                f"discount must be in (0, 1], got {self.discount!r}; give the trainer's own"
            )

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``, the same for every agent."""
        before, after = self.potential(transition.state), self.potential(transition.next_state)
        gain = np.empty((len(before), transition.team.num_agents))
        _write_gain(before, after, transition.success, self.discount, self.weight, gain)
        return gain


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress(PotentialShaping):
    """Reward for every metre nearer to the goal, in the task's distance.

    The default discount of 1 pays plain differences of distance: hovering earns nothing.
    """

    potential: Potential = closeness
    discount: float = 1.0


@compiled
def _write_gain(before, after, success, discount, weight, gain):
    for world in range(len(before)):
        later = 0.0 if success[world] else discount * after[world]
        gain[world, :] = weight * (later - before[world])
