"""Keyed random numbers: SplitMix64 hashes instead of a generator's state, in kernels and outside.

A generator would have to be asked world by world. Instead each episode draws one key from its
world's generator (`draw_keys`), and whatever is drawn later is a hash of that key and of numbers
that say what it is for. So a kernel draws for all worlds in one pass, a world's numbers do not
depend on how many run beside it, and a generator gives the same to everything else whether or not
keyed numbers are drawn.

Keys form a tree: ``mixed(key, number)`` is branch ``number`` of a key. A sensor's error has the
key of its episode, then block, agent, step, feature; a partner's tremor that of its episode, then
step, what it is for, which component; a trait that of its episode, then its name. `fraction`
turns a key into a uniform number, `normal` and `polar_normal` turn it into a normal one. Both
normals are kept, though one would do: to replace either would change the episodes of every seed.

Sources: Salmon et al. 2011 for counter-based generators; Steele, Lea & Flood 2014 for SplitMix64.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.compiled import compiled

Keys = npt.NDArray[np.uint64]

_WEYL = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S12, _S11 = (np.uint64(bits) for bits in (30, 27, 31, 12, 11))


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
        return Chance(branches(self.keys, np.uint64(number)))


@compiled
def mixed(key, number):
    """The key of branch ``number`` under ``key``, both uint64: looks independent of all others."""
    z = key + _WEYL * (np.uint64(number) + np.uint64(1))
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@compiled
def fraction(key):
    """The uniform number of a key, in [0, 1)."""
    return np.float64(key >> _S11) * 2.0**-53


@compiled
def normal(key):
    """The standard normal number of a key: the quantile of its uniform one, to 1e-7.

    Source: Wichura 1988, Algorithm AS 241, PPND7.
    """
    uniform = (np.float64(key >> _S12) + 0.5) * 2.0**-52  # exact, never 0 or 1
    q = uniform - 0.5
    if abs(q) <= 0.425:
        r = 0.180625 - q * q
        top = ((59.10937472 * r + 159.29113202) * r + 50.434271938) * r + 3.3871327179
        return q * top / (((67.18756360 * r + 78.757757664) * r + 17.895169469) * r + 1.0)
    r = np.sqrt(-np.log(min(uniform, 1.0 - uniform)))
    if r <= 5.0:
        r -= 1.6
        top = ((0.17023821103 * r + 1.3067284816) * r + 2.7568153900) * r + 1.4234372777
        size = top / ((0.12021132975 * r + 0.73700164250) * r + 1.0)
    else:
        r -= 5.0
        top = ((0.017337203997 * r + 0.42868294337) * r + 3.0812263860) * r + 6.6579051150
        size = top / ((0.012258202635 * r + 0.24197894225) * r + 1.0)
    return np.copysign(size, q)


@compiled
def polar_normal(key):
    """The standard normal number that a key and its branch 1 make together.

    Source: Box & Muller 1958.
    """
    radius = np.sqrt(-2 * np.log(1 - fraction(key)))
    return radius * np.cos(2 * np.pi * fraction(mixed(key, np.uint64(1))))


@compiled
def branches(keys, number):
    """Branch ``number`` of every key, ``(key,)``."""
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
