"""Imperfect senses: noise, a bias and a delay on what a block of the observation reads.

Errors are a function of the world's key, which its generator draws at every reset, and of the
step, the agent, the block and the feature: a counter-based generator (Salmon et al. 2011) with the
mixing function of SplitMix64 (Steele, Lea & Flood 2014). So they take no state, and a world's do
not depend on how many run beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from coopenv.arrays import IntArray, finite_array, whole
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.observation.block import Block
from coopenv.transition import Transition

_LARGEST = float(np.finfo(np.float32).max)
_WEYL = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S12 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(12)
_EPISODE = np.uint64(2**64 - 1)  # in place of a step: what holds for a whole episode


@dataclass(frozen=True, slots=True)
class Sensor:
    """A block of the observation as an imperfect instrument reads it.

    Every agent has its own instrument, with errors of its own. What an agent reads is the block
    plus bias plus noise, clipped to the block's bounds, ``delay`` steps late; before there is so
    much history, it is the first reading of the episode. What an agent is not told reads 0.

    Parameters
    ----------
    block
        Name of a block, or a `coopenv.Block`.
    noise
        Standard deviation of a normal error, new in every step.
    bias
        Standard deviation of a normal error that is drawn once an episode.
    delay
        Control steps between what is read and when it is read.

    ``noise`` and ``bias`` are in the block's units, one number or one a feature; of a block about
    each other agent, one a feature about one of them.

    Raises
    ------
    InvalidInput
        If a value breaks its rule.
    """

    block: str | Block
    noise: float | Sequence[float] = 0.0
    bias: float | Sequence[float] = 0.0
    delay: int = 0  # [control steps]

    def __post_init__(self) -> None:
        if isinstance(self.block, Sensor):
            raise InvalidInput(
                f"sensor.block must be a block or its name, got {self.block!r}; give one sensor "
                "all the errors"
            )
        for name in ("noise", "bias"):
            object.__setattr__(self, name, _deviation(getattr(self, name), f"sensor.{name}"))
        object.__setattr__(self, "delay", whole(self.delay, "sensor.delay", at_least=0))

    @property
    def is_random(self) -> bool:
        """Whether anything is drawn for it."""
        return bool(np.any(self.noise) or np.any(self.bias))


def _deviation(value: Any, name: str) -> float | tuple[float, ...]:
    deviation = finite_array(value, name)
    if deviation.ndim > 1 or not deviation.size or (deviation < 0).any():
        raise InvalidInput(
            f"{name} must be zero or positive, one number or one a feature, got {value!r}; it is a "
            "standard deviation in the block's units"
        )
    return tuple(deviation.tolist()) if deviation.ndim else deviation.item()


class Instruments:
    """One sensor of every agent in every world, with the readings that are still under way.

    A reading is kept under its episode's step, so that a world that starts anew needs no clearing.

    Parameters
    ----------
    sensor, block
        What kind, and what it reads; sensors on blocks of different names err independently.
    num_agents, num_worlds
        How many.
    """

    def __init__(self, sensor: Sensor, block: Block, num_agents: int, num_worlds: int):
        self._stream = np.uint64(crc32(block.name.encode()))
        self._noise = block.spread(sensor.noise, num_agents, "sensor.noise")
        self._bias = block.spread(sensor.bias, num_agents, "sensor.bias")
        bounds = [block.spread(getattr(block, end), num_agents, end) for end in ("low", "high")]
        self._bounds = np.clip(bounds, -_LARGEST, _LARGEST)
        needed = block.spread(block.needs_told or -1, num_agents, "needs_told")
        self._needed = needed.astype(np.int64)
        self._is_random, width = sensor.is_random, block.width(num_agents)
        self._offset = np.zeros((num_worlds, num_agents, width))
        self._kept = np.zeros((sensor.delay + 1, num_worlds, num_agents, width), np.float32)

    def __call__(
        self, seen: npt.NDArray[np.float32], transition: Transition, worlds: IntArray
    ) -> npt.NDArray[np.float32]:
        """What is read instead of the truth ``seen`` ``(row, agent, feature)``, in its place.

        Row k of it and of ``transition`` is of world ``worlds[k]``.
        """
        conditions = transition.conditions
        steps = np.rint(transition.next_state.time / transition.dt).astype(np.int64)
        if self._is_random and self._noise.size:
            _err(
                seen,
                steps,
                worlds,
                conditions.key,
                self._stream,
                self._noise,
                self._bias,
                self._bounds,
                self._offset,
            )
            _hide(seen, conditions.told, self._needed)
        if len(self._kept) > 1:
            _delay(seen, steps, worlds, self._kept)
        return seen


@compiled
def _mixed(x):
    """SplitMix64's output function."""
    x = (x ^ (x >> _S30)) * _MIX_1
    x = (x ^ (x >> _S27)) * _MIX_2
    return x ^ (x >> _S31)


@compiled
def _below(x, number):
    """The key of branch ``number`` under key ``x``."""
    return _mixed(x + _WEYL * (np.uint64(number) + np.uint64(1)))


@compiled
def normal(x):
    """The standard normal number of a key: the quantile of its uniform one, to 1e-7.

    Source: Wichura 1988, Algorithm AS 241, PPND7.
    """
    uniform = (np.float64(x >> _S12) + 0.5) * 2.0**-52  # exact, never 0 or 1
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
def _err(seen, steps, worlds, key, stream, noise, bias, bounds, offset):
    """Add noise and bias, and clip to the bounds; in place. Starts draw the bias ``offset``."""
    num_rows, num_agents, num_features = seen.shape
    for k in range(num_rows):
        of_block, mine = _below(key[k], stream), offset[worlds[k]]
        for i in range(num_agents):
            of_agent = _below(of_block, i)
            if steps[k] == 0:
                of_episode = _below(of_agent, _EPISODE)
                for j in range(num_features):
                    mine[i, j] = bias[j] * normal(_below(of_episode, j)) if bias[j] > 0.0 else 0.0
            of_step = _below(of_agent, steps[k])
            for j in range(num_features):
                value = seen[k, i, j] + mine[i, j]
                if noise[j] > 0.0:
                    value += noise[j] * normal(_below(of_step, j))
                seen[k, i, j] = min(max(value, bounds[0, j]), bounds[1, j])


@compiled
def _hide(seen, told, needed):
    """Set what an agent is not told to 0; in place."""
    for k in range(seen.shape[0]):
        for i in range(seen.shape[1]):
            for j in range(seen.shape[2]):
                if needed[j] >= 0 and not told[k, i, needed[j]]:
                    seen[k, i, j] = 0.0


@compiled
def _delay(seen, steps, worlds, kept):
    """Keep the readings of now, and hand out those of ``len(kept) − 1`` steps ago; in place."""
    slots = len(kept)
    for k in range(len(seen)):
        kept[steps[k] % slots, worlds[k]] = seen[k]
        seen[k] = kept[max(steps[k] - (slots - 1), 0) % slots, worlds[k]]
