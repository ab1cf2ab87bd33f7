"""Observation: the chosen blocks side by side in one array an agent, found by their names."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.chance import Keys
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation.block import Block, side_by_side
from coopenv.observation.blocks import BLOCKS, DEFAULT_BLOCKS
from coopenv.observation.bounds import Bounds, clip
from coopenv.observation.ranges import RangeReading, ranges
from coopenv.observation.sensor import Instruments, Sensor
from coopenv.observation.view import DECOMPOSED, VIEW_PARTS, write_view
from coopenv.transition import Transition

Entry: TypeAlias = str | Block | Sensor


class Observation:
    """The chosen blocks, side by side.

    Parameters
    ----------
    blocks
        Names from `BLOCKS`, `Block` objects of your own, or either in a `Sensor`.
    num_agents
        Effectors in a world.
    num_worlds
        Worlds that delayed readings are kept for.
    bounds
        What gives every feature a finite bound, to which readings are clipped; ``None``: features
        have the bounds of their blocks.

    Attributes
    ----------
    size
        Features an agent sees.
    blocks
        Name → slice of the feature axis.
    low, high
        ``(size,)`` bounds, float32.

    Raises
    ------
    UnknownName
        For a name that is not in `BLOCKS`.
    InvalidInput
        If numbers of a block or a sensor are not as many as its features, or there is no finite
        bound for one.
    """

    def __init__(
        self,
        blocks: Sequence[Entry],
        num_agents: int,
        num_worlds: int = 1,
        bounds: Bounds | None = None,
    ):
        chosen = [find_block(block) for block in blocks]
        self.blocks = side_by_side(chosen, num_agents)
        self.size = sum(block.width(num_agents) for block in chosen)
        ends = [
            block.ends(num_agents) if bounds is None else bounds.ends(block, num_agents)
            for block in chosen
        ]
        self.low = np.concatenate([low for low, _ in ends]).astype(np.float32)
        self.high = np.concatenate([high for _, high in ends]).astype(np.float32)
        self._is_clipped = bounds is not None
        self._read = [(block, self.blocks[block.name]) for block in chosen if block.read]
        seen = {block.name for block in chosen if not block.read}  # in the agents' view
        self._begin = np.array(
            [self.blocks[name].start if name in seen else -1 for name in VIEW_PARTS]
        )
        self._is_view_seen, self._is_decomposed = bool(seen), not seen.isdisjoint(DECOMPOSED)
        self._all_worlds = np.arange(num_worlds)
        self._instruments = {
            block.name: Instruments(entry, block, num_agents, num_worlds)
            for block, entry in zip(chosen, blocks, strict=True)
            if isinstance(entry, Sensor)
        }

    def __call__(
        self, transition: Transition, worlds: IntArray | None = None, keys: Keys | None = None
    ) -> npt.NDArray[np.float32]:
        """What every agent sees after ``transition``: ``(world, agent, size)``, a fresh array.

        ``worlds`` says which ones the rows of ``transition`` are of, if it is not all of them.
        ``keys`` ``(row,)`` are those of the sensors' errors, if not the episodes' own.
        Delayed readings are right where every step of an episode has been read once, in order.
        """
        return self.read(transition, worlds, keys)[0]

    def read(
        self, transition: Transition, worlds: IntArray | None = None, keys: Keys | None = None
    ) -> tuple[npt.NDArray[np.float32], BoolArray | None]:
        """What calling it gives, and ``(world, agent)`` whether any of it was clipped.

        ``None`` in place of the latter without ``bounds``.
        """
        seen = self._seen(transition, worlds, keys)
        return seen, clip(seen, self.low, self.high) if self._is_clipped else None

    def _seen(
        self, transition: Transition, worlds: IntArray | None, keys: Keys | None
    ) -> npt.NDArray[np.float32]:
        seen = np.empty((*transition.applied.shape[:2], self.size), dtype=np.float32)
        if self._is_view_seen:
            write_view(transition, self._begin, self._is_decomposed, seen)
        for block, where in self._read:
            assert block.read is not None
            seen[..., where] = _checked(block.read(transition), seen[..., where].shape, block)
        for name, instruments in self._instruments.items():
            where = self.blocks[name]
            truth = np.ascontiguousarray(seen[..., where])
            rows = self._all_worlds if worlds is None else worlds
            seen[..., where] = instruments(truth, transition, rows, keys)
        return seen

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What the sensors of ``worlds`` remember, one row each; by block."""
        return {name: each.get_state(worlds) for name, each in self._instruments.items()}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        for name, each in self._instruments.items():
            each.set_state(state[name], worlds)


def _checked(value: FloatArray, shape: tuple[int, ...], block: Block) -> FloatArray:
    if np.shape(value) != shape:
        raise InvalidInput(
            f"block {block.name!r} must read an array of shape {shape}, got {np.shape(value)}; "
            "one row an agent of every world"
        )
    return value


def find_block(block: Entry) -> Block:
    """The block of that name, or in that sensor; a `Block` is returned as it is."""
    if isinstance(block, Sensor):
        return find_block(block.block)
    if isinstance(block, Block):
        if block.read is None and block != BLOCKS.get(block.name):
            raise InvalidInput(
                f"read must be given for a block of your own, got None for {block.name!r}; "
                "pass a function of a transition"
            )
        return block
    if not isinstance(block, str) or block not in BLOCKS:
        raise UnknownName("observe", block, BLOCKS)
    return BLOCKS[block]


def find_blocks(blocks: Sequence[Any]) -> tuple[Entry, ...]:
    """``blocks``, each built anew where JSON brought it back as a dict.

    Raises
    ------
    InvalidInput, UnknownName
        Unless it is a sequence of known, different blocks.
    """
    if isinstance(blocks, str) or not isinstance(blocks, Sequence) or not blocks:
        raise InvalidInput(
            f"observe must be a sequence of block names, got {blocks!r}; "
            f"pass for example observe={DEFAULT_BLOCKS[:2]}"
        )
    built = tuple(_built(block) for block in blocks)
    names = [find_block(block).name for block in built]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InvalidInput(f"observe must name each block once, got {doubled} twice; drop one")
    return built


def _built(block: Any) -> Any:
    """The sensor or block that a dict describes, as JSON brings it back; others as they are."""
    if not isinstance(block, Mapping):
        return block
    if "block" in block:
        _check_names(block, Sensor)
        return Sensor(**{**block, "block": _built(block["block"])})
    name, read = block.get("name"), block.get("read")
    if isinstance(read, Mapping):
        _check_names(read, RangeReading)
        return ranges(name=name, **read)
    return BLOCKS.get(str(name), block) if read is None else block


def _check_names(given: Mapping[str, Any], kind: type) -> None:
    known = [entry.name for entry in fields(kind)]
    for name in given:
        if name not in known:
            raise UnknownName("keyword in observe", name, known)
