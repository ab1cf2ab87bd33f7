"""Policies: observations and the last transition in, actions of many worlds out; a random one."""

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray
from coopenv.config import ACTIONS, TransportConfig
from coopenv.transition import Transition


class Policy(Protocol):
    """Anything callable so can be evaluated, drawn and compared; see `coopenv.agents.evaluate`."""

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)`` in [−1, 1], agent frame.

        Learners are the agents that no partner drives: without one, all.

        Parameters
        ----------
        obs
            ``(world, learner, feature)``, what each of them sees.
        transition
            The step that led here; ``transition.next_state`` is where every world is. Learned
            policies ignore it, scripted ones may read all of it.
        """
        ...


@runtime_checkable
class Resettable(Protocol):
    """A policy that remembers something of an episode has this as well."""

    def reset(self, mask: BoolArray) -> None:
        """Forget the episodes of the worlds that ``mask`` ``(world,)`` marks."""
        ...


def forget(policy: Policy, mask: BoolArray) -> None:
    """Tell a policy that new episodes begin in the marked worlds, if it wants to know."""
    if isinstance(policy, Resettable):
        policy.reset(mask)


class RandomPolicy:
    """Uniform actions, independent in every step.

    Parameters
    ----------
    config
        Of the environment it acts in.
    seed
        Of its own generator.
    """

    def __init__(self, config: TransportConfig, seed: int = 0):
        self._generator = np.random.default_rng(seed)
        self._width = ACTIONS[config.action]

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, agent, action_size)``."""
        return self._generator.uniform(-1.0, 1.0, (*obs.shape[:2], self._width))
