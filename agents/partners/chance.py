"""Random numbers that depend on a world's episode and a count alone, drawn for all worlds at once.

A generator a world would have to be asked world by world. Instead each episode draws one key from
its world's generator, and number ``n`` of the episode is a hash of key and n (splitmix64, Steele,
Lea & Flood 2014). So a step draws in one pass, whatever other worlds do, and every partner takes
the same from a generator: tasks go on with the same starts and goals whoever the partner is.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.compiled import compiled

Keys = npt.NDArray[np.uint64]


def draw_keys(generators: Sequence[np.random.Generator | None], worlds: IntArray) -> Keys:
    """One key for the next episode of each of ``worlds``."""
    keys = np.empty(len(worlds), dtype=np.uint64)
    for j, k in enumerate(worlds.tolist()):
        generator = generators[k]
        assert generator is not None
        keys[j] = generator.integers(2**64, dtype=np.uint64)
    return keys


class Chance:
    """What some episodes draw: uniform numbers by name, one an episode.

    Parameters
    ----------
    keys
        ``(episode,)``.
    """

    def __init__(self, keys: Keys):
        self.keys = keys

    def __len__(self) -> int:
        return len(self.keys)

    def uniform(self, name: str) -> FloatArray:
        """Number of that name of each episode, ``(episode,)`` in [0, 1)."""
        return _uniforms(self.branch(name).keys)

    def branch(self, name: str) -> "Chance":
        """Numbers independent of those drawn here."""
        number = int.from_bytes(name.encode()[:8].ljust(8, b"\0"), "little")
        return Chance(_mixed(self.keys, np.uint64(number)))


@compiled
def mixed(key, number):
    """A key that looks independent of ``key``, one for every ``number``; all uint64."""
    z = key + (number + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@compiled
def fraction(key):
    """A key as a number in [0, 1)."""
    return np.float64(key >> np.uint64(11)) * 2.0**-53


@compiled
def normal(key):
    """A standard normal number (Box & Muller 1958)."""
    radius = np.sqrt(-2 * np.log(1 - fraction(key)))
    return radius * np.cos(2 * np.pi * fraction(mixed(key, np.uint64(1))))


@compiled
def _mixed(keys, number):
    out = np.empty_like(keys)
    for j in range(len(keys)):
        out[j] = mixed(keys[j], number)
    return out


@compiled
def _uniforms(keys):
    out = np.empty(len(keys))
    for j in range(len(keys)):
        out[j] = fraction(mixed(keys[j], np.uint64(0)))
    return out
