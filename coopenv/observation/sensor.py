"""Imperfect sensors: noise, a bias and a delay on what a block of the observation reads.

Errors are keyed random numbers (`coopenv.chance`): a function of the key that the world's generator
draws at every reset, and of block, agent, step and feature. So no state is kept for them, and
the errors in a world do not depend on how many worlds run beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from coopenv.arrays import LARGEST, IntArray, stated_array, whole
from coopenv.chance import Keys, mixed, normal
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.observation.block import Block
from coopenv.transition import Transition

LONGEST_DELAY = 10**4  # [control steps]; every reading under way is kept
_LARGEST = float(np.finfo(np.float32).max)
_NOISE, _BIAS, _LOW, _HIGH = range(4)  # what holds for a feature
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
        delay = whole(self.delay, "sensor.delay", at_least=0, at_most=LONGEST_DELAY)
        object.__setattr__(self, "delay", delay)

    @property
    def is_random(self) -> bool:
        """Whether anything is drawn for it."""
        return bool(np.any(self.noise) or np.any(self.bias))


def _deviation(value: Any, name: str) -> float | tuple[float, ...]:
    deviation = stated_array(value, name)
    out = (deviation < 0) | (deviation > LARGEST)
    if deviation.ndim > 1 or not deviation.size or out.any():
        raise InvalidInput(
            f"{name} must be from 0 to {LARGEST:g}, one number or one a feature, got {value!r}; "
            "it is a standard deviation in the block's units"
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
        noise = block.spread(sensor.noise, num_agents, "sensor.noise")
        bias = block.spread(sensor.bias, num_agents, "sensor.bias")
        low, high = (block.spread(getattr(block, end), num_agents, end) for end in ("low", "high"))
        bounds = np.clip([low, high], -_LARGEST, _LARGEST)
        self._features = np.stack([noise, bias, *bounds], axis=-1)
        needed = block.spread(block.needs_told or -1, num_agents, "needs_told")
        self._needed = needed.astype(np.int64)
        self._is_random, width = sensor.is_random, block.width(num_agents)
        self._offset = np.zeros((num_worlds, num_agents, width))
        self._kept = _room((sensor.delay + 1, num_worlds, num_agents, width))

    def get_state(self, worlds: IntArray) -> dict[str, npt.NDArray[Any]]:
        """Biases and readings under way of ``worlds``, one row each."""
        return {"offset": self._offset[worlds], "kept": self._kept[:, worlds].swapaxes(0, 1)}

    def set_state(self, state: dict[str, npt.NDArray[Any]], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._offset[worlds] = state["offset"]
        self._kept[:, worlds] = state["kept"].swapaxes(0, 1)

    def __call__(
        self,
        seen: npt.NDArray[np.float32],
        transition: Transition,
        worlds: IntArray,
        keys: Keys | None = None,
    ) -> npt.NDArray[np.float32]:
        """What is read instead of the truth ``seen`` ``(row, agent, feature)``, in its place.

        Row k of it and of ``transition`` is of world ``worlds[k]``. Errors are those of ``keys``
        ``(row,)``; ``None``: of the episodes' own.
        """
        conditions = transition.conditions
        steps = np.rint(transition.next_state.time / transition.dt).astype(np.int64)
        if self._is_random and self._features.size:
            key, stream = conditions.key if keys is None else keys, self._stream
            _err(seen, steps, worlds, key, stream, self._features, self._offset)
            _hide(seen, conditions.told, self._needed)
        if len(self._kept) > 1:
            _delay(seen, steps, worlds, self._kept)
        return seen


@compiled
def _err(seen, steps, worlds, key, stream, features, offset):
    """Add noise and bias, and clip to the bounds; in place. Starts draw the bias ``offset``."""
    num_rows, num_agents, num_features = seen.shape
    for k in range(num_rows):
        of_block, mine = mixed(key[k], stream), offset[worlds[k]]
        for i in range(num_agents):
            of_agent = mixed(of_block, i)
            if steps[k] == 0:
                of_episode = mixed(of_agent, _EPISODE)
                for j in range(num_features):
                    bias = features[j, _BIAS]
                    mine[i, j] = bias * normal(mixed(of_episode, j)) if bias > 0.0 else 0.0
            of_step = mixed(of_agent, steps[k])
            for j in range(num_features):
                value, noise = seen[k, i, j] + mine[i, j], features[j, _NOISE]
                if noise > 0.0:
                    value += noise * normal(mixed(of_step, j))
                seen[k, i, j] = min(max(value, features[j, _LOW]), features[j, _HIGH])


@compiled
def _hide(seen, told, needed):
    """Set what an agent is not told to 0; in place."""
    for k in range(seen.shape[0]):
        for i in range(seen.shape[1]):
            for j in range(seen.shape[2]):
                if needed[j] >= 0 and not told[k, i, needed[j]]:
                    seen[k, i, j] = 0.0


def _room(shape: tuple[int, int, int, int]) -> npt.NDArray[np.float32]:
    """Memory for every reading that is under way: (delay, world, agent, feature)."""
    try:
        return np.zeros(shape, np.float32)
    except MemoryError as error:
        raise InvalidInput(
            f"sensor.delay must let its readings fit into memory, got {shape[0] - 1} steps of "
            f"{shape[1]} worlds, {4 * prod(shape) / 1e9:.2g} GB; lower it, or use fewer worlds"
        ) from error


@compiled
def _delay(seen, steps, worlds, kept):
    """Keep the readings of now, and hand out those of ``len(kept) − 1`` steps ago; in place."""
    slots = len(kept)
    for k in range(len(seen)):
        kept[steps[k] % slots, worlds[k]] = seen[k]
        seen[k] = kept[max(steps[k] - (slots - 1), 0) % slots, worlds[k]]
