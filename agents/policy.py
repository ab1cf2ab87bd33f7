"""Policies: observations and the last transition in, actions of many worlds out; a random one."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.config import ACTIONS, TransportConfig
from coopenv.observation import Entry
from coopenv.observation.bounds import Bounds
from coopenv.transition import Transition
from coopenv.transport import Transport

from .noise import Keyed, uniforms


class Policy(Protocol):
    """Anything callable so can be evaluated, drawn and compared; see `coopenv.agents.evaluate`."""

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)`` in [−1, 1], agent frame.

        Where actions are discrete, numbers of pushes ``(world, learner)``.

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


@runtime_checkable
class Seedable(Protocol):
    """A policy that draws random numbers has this, to act alike beside any number of episodes."""

    def seed_episodes(self, seeds: IntArray, worlds: IntArray | None = None) -> None:
        """Seeds ``(world,)`` of the episodes that begin now, in every world or in ``worlds``.

        Evaluations give no ``worlds``; a policy that acts as a partner is always given them.
        """
        ...


@runtime_checkable
class Stateful(Protocol):
    """A policy whose memory of episodes can be kept and put back has this.

    As a partner, one that is `Resettable` or `Seedable` needs it where the state of an environment
    is kept, copied or pickled.
    """

    def get_state(self, worlds: IntArray, num_worlds: int) -> dict[str, Any]:
        """What it remembers of ``worlds`` out of ``num_worlds``, one row each; copies, by name."""
        ...

    def set_state(self, state: dict[str, Any], worlds: IntArray, num_worlds: int) -> None:
        """Go on in ``worlds`` from what `get_state` returned, perhaps of another such policy."""
        ...


@runtime_checkable
class Choosy(Protocol):
    """A policy that can act in some environments only has this."""

    def check_environment(self, core: Transport) -> None:
        """Raise `coopenv.errors.InvalidInput` unless it can act in ``core``."""
        ...


@runtime_checkable
class Samplable(Protocol):
    """A policy that can act by its mean or by a sample has this."""

    def sampled(self) -> "Policy | None":
        """The same policy with sampled actions; ``None`` if it has one way of acting after all."""
        ...


class Seat(NamedTuple):
    """A policy that acts as a partner, and what it is given."""

    policy: Policy
    observe: tuple[Entry, ...]  # blocks that it sees
    agents: tuple[int, ...]  # those whose sight it gets and whose actions it gives
    table: FloatArray | None = None  # (push, 3): what its numbers stand for, if it gives such
    bounds: Bounds | None = None  # to which what it sees is clipped


@runtime_checkable
class Freezable(Protocol):
    """A policy that learns, or that cannot be copied deep, has this to be a partner."""

    def frozen(self) -> "Policy":
        """A copy that acts as it does now, with a memory of its own."""
        ...


@runtime_checkable
class Seatable(Protocol):
    """A policy that knows what it has to see when it acts as a partner has this."""

    def as_partner(
        self, config: TransportConfig, agents: tuple[int, ...], *, trust: bool = False
    ) -> Seat:
        """Where it sits when it drives ``agents``; raises `InvalidInput` where it cannot."""
        ...


def check_environment(policy: Policy, core: Transport) -> None:
    """Raise `coopenv.errors.InvalidInput` if a policy says that it cannot act in ``core``."""
    if isinstance(policy, Choosy):
        policy.check_environment(core)


def forget(policy: Policy, mask: BoolArray, seeds: Sequence[int] | None = None) -> None:
    """Tell a policy that new episodes begin in the marked worlds, if it wants to know.

    Parameters
    ----------
    mask
        ``(world,)``.
    seeds
        Of the worlds, where episodes begin in all of them.
    """
    if isinstance(policy, Resettable):
        policy.reset(mask)
    if seeds is not None and isinstance(policy, Seedable):
        policy.seed_episodes(np.asarray(seeds, dtype=np.int64))


class RandomPolicy(Keyed):
    """Uniform actions, independent in every step.

    They are keyed by seed, episode and step: an episode of an evaluation gets the same actions
    whatever runs beside it.

    Parameters
    ----------
    config
        Of the environment it acts in.
    seed
        Of its own numbers, not negative.
    """

    def __init__(self, config: TransportConfig, seed: int = 0):
        super().__init__(seed)
        self._width, self._table = ACTIONS[config.action], config.table

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, agent, action_size)``, or numbers of pushes ``(world, agent)``."""
        num_worlds, num_agents, _ = obs.shape
        self._keys.follow(transition)
        if self._table is not None:
            drawn = uniforms(self._keys.of_step(transition), num_agents)
            return (drawn * len(self._table)).astype(np.int64)
        drawn = uniforms(self._keys.of_step(transition), num_agents * self._width)
        return 2 * drawn.reshape(num_worlds, num_agents, self._width) - 1
