"""Random numbers of policies, keyed by episode and step: the same beside any number of episodes."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import IntArray, whole
from coopenv.chance import Keys, branches, fraction, mixed, normal
from coopenv.compiled import compiled
from coopenv.transition import Transition

_UNSEEDED, _SEEDED = np.uint64(0), np.uint64(1)  # branches of the policy's key
_NEXT, _STEPS = np.uint64(0), np.uint64(1)  # branches of an episode's key


class Keyed:
    """A policy that remembers nothing of an episode but the key of its random numbers.

    Parameters
    ----------
    seed
        As of `EpisodeKeys`.
    """

    def __init__(self, seed: int = 0):
        self._keys = EpisodeKeys(seed)

    def seed_episodes(self, seeds: IntArray, worlds: IntArray | None = None) -> None:
        """Seeds ``(world,)`` of the episodes that begin now, in every world or in ``worlds``."""
        self._keys.seed(seeds, worlds)

    def get_state(self, worlds: IntArray, num_worlds: int) -> dict[str, Any]:
        """Keys of ``worlds``; see `coopenv.agents.policy.Stateful`."""
        return {"keys": self._keys.get_state(worlds, num_worlds)}

    def set_state(self, state: dict[str, Any], worlds: IntArray, num_worlds: int) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._keys.set_state(state["keys"], worlds, num_worlds)


class EpisodeKeys:
    """One key for the episode of each world, and of it one a step; see `coopenv.chance`.

    An episode begins where ``transition.next_state.time`` is 0.

    Parameters
    ----------
    seed
        Of the policy, not negative: the same episode, other numbers.
    """

    def __init__(self, seed: int = 0):
        self._seed = np.uint64(whole(seed, "seed", at_least=0) % 2**64)
        self._episodes = np.zeros(0, dtype=np.uint64)

    def seed(self, seeds: npt.NDArray[np.integer], worlds: IntArray | None = None) -> None:
        """Seeds of the episodes that begin now, one a world; those that follow go on from them.

        Parameters
        ----------
        seeds
            ``(world,)``.
        worlds
            Where they begin, if not in all of them; all are told of before.
        """
        keys = _branches(self._seed, _SEEDED, seeds.astype(np.uint64))
        if worlds is None or len(self._episodes) != len(keys):
            self._episodes = keys
        else:
            self._episodes[worlds] = keys[worlds]

    def follow(self, transition: Transition) -> IntArray:
        """Worlds in which an episode begins; they get a key of their own.

        Worlds that `seed` did not tell of are told apart by their numbers.
        """
        time = transition.next_state.time
        keys = self._of_all(len(time))
        began = np.flatnonzero(time == 0)
        keys[began] = branches(keys[began], _NEXT)
        return began

    def _of_all(self, num_worlds: int) -> Keys:
        if len(self._episodes) != num_worlds:
            numbers = np.arange(num_worlds, dtype=np.uint64)
            self._episodes = _branches(self._seed, _UNSEEDED, numbers)
        return self._episodes

    def get_state(self, worlds: IntArray, num_worlds: int) -> Keys:
        """Keys of ``worlds`` out of so many, a copy."""
        return self._of_all(num_worlds)[worlds]

    def set_state(self, keys: Keys, worlds: IntArray, num_worlds: int) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._of_all(num_worlds)[worlds] = keys

    def of_episode(self) -> Keys:
        """``(world,)``, the same in every step."""
        return self._episodes

    def of_step(self, transition: Transition) -> Keys:
        """``(world,)``, another one in every step."""
        steps = np.rint(transition.next_state.time / transition.dt).astype(np.uint64)
        return _steps(self._episodes, steps)


@compiled
def uniforms(keys, count):
    """``(key, count)`` uniform numbers in [0, 1)."""
    out = np.empty((len(keys), count))
    for j in range(len(keys)):
        for i in range(count):
            out[j, i] = fraction(mixed(keys[j], np.uint64(i)))
    return out


@compiled
def normals(keys, count):
    """``(key, count)`` standard normal numbers."""
    out = np.empty((len(keys), count))
    for j in range(len(keys)):
        for i in range(count):
            out[j, i] = normal(mixed(keys[j], np.uint64(i)))
    return out


@compiled
def _branches(seed, branch, numbers):
    key = mixed(mixed(seed, np.uint64(0)), branch)
    out = np.empty_like(numbers)
    for j in range(len(numbers)):
        out[j] = mixed(key, numbers[j])
    return out


@compiled
def _steps(keys, steps):
    out = np.empty_like(keys)
    for j in range(len(keys)):
        out[j] = mixed(mixed(keys[j], _STEPS), steps[j])
    return out
