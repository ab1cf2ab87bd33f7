"""Memory of a recurrent policy: what it remembers of the episode in each world."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, IntArray, with_rows

Layers = tuple[npt.NDArray, ...]  # each (layer, row, unit), as Stable-Baselines3 has them


class EpisodeMemory:
    """Recurrent states of all rows, forgotten world by world; empty for other policies."""

    def __init__(self) -> None:
        self._layers: Layers | None = None
        self._fresh = np.zeros(0, dtype=np.bool_)  # (world,): whose episode begins

    def forget(self, mask: BoolArray) -> None:
        """Begin anew in the worlds that ``mask`` ``(world,)`` marks."""
        known = len(self._fresh) == len(mask)
        self._fresh = self._fresh | mask if known else np.ones(len(mask), dtype=np.bool_)

    def recall(self, rows: int) -> tuple[Layers | None, BoolArray]:
        """States of so many ``rows``, and ``(row,)`` in which of them an episode begins."""
        if self._layers is not None and self._layers[0].shape[1] != rows:
            self._layers = None
        return self._layers, np.repeat(self._fresh, rows // len(self._fresh))

    def keep(self, layers: Layers | None) -> None:
        """Remember what a step left; every episode has begun."""
        self._layers, self._fresh = layers, np.zeros_like(self._fresh)

    def get_state(self, worlds: IntArray, num_worlds: int) -> dict[str, Any]:
        """Of ``worlds`` out of so many; see `coopenv.agents.policy.Stateful`."""
        fresh = self._fresh if len(self._fresh) == num_worlds else np.ones(num_worlds, np.bool_)
        layers = () if self._layers is None else self._layers
        return {
            "fresh": fresh[worlds],
            "memory": {
                str(i): _by_world(each, num_worlds)[worlds] for i, each in enumerate(layers)
            },
        }

    def set_state(self, state: dict[str, Any], worlds: IntArray, num_worlds: int) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        if len(self._fresh) != num_worlds:
            self._fresh, self._layers = np.ones(num_worlds, dtype=np.bool_), None
        self._fresh[worlds] = state["fresh"]
        kept = [*state["memory"].values()]
        if not kept:  # taken before the first step, where all is fresh
            return
        mine = self._layers and [_by_world(each, num_worlds) for each in self._layers]
        before = mine or [np.zeros((num_worlds, *each.shape[1:]), each.dtype) for each in kept]
        changed = map(with_rows, before, [worlds] * len(kept), kept)
        self._layers = tuple(_by_row(each) for each in changed)


def _by_world(layers: npt.NDArray, num_worlds: int) -> npt.NDArray:
    """As ``(world, row, layer, unit)`` a recurrent state ``(layer, row, unit)``."""
    count, _, units = layers.shape
    return layers.reshape(count, num_worlds, -1, units).transpose(1, 2, 0, 3)


def _by_row(memory: npt.NDArray) -> npt.NDArray:
    """A recurrent state ``(layer, row, unit)`` of what `_by_world` makes of it."""
    num_worlds, rows, layers, units = memory.shape
    turned = np.ascontiguousarray(memory.transpose(2, 0, 1, 3))
    return turned.reshape(layers, num_worlds * rows, units)
