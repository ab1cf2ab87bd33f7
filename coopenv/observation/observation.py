"""Named observation blocks, put together into one array per agent."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput, UnknownName
from coopenv.geometry.frames import VIEW_PARTS, view_slices
from coopenv.observation.block import Block, EachOther
from coopenv.observation.privileged import privileged
from coopenv.observation.ranges import RangeReading, ranges
from coopenv.observation.sensor import Instruments, Sensor
from coopenv.transition import Transition

Entry: TypeAlias = str | Block | Sensor


def _time_left(transition: Transition) -> FloatArray:
    left = 1 - transition.next_state.time / (transition.horizon * transition.dt)
    return transition.per_agent(left)[..., None]


def _known(transition: Transition) -> FloatArray:
    return transition.conditions.told.astype(np.float64)


BLOCKS: dict[str, Block] = {
    block.name: block
    for block in (
        Block(
            name="goal",
            size=4,
            describe="way from the object to its goal: Δx, Δy, cos Δθ, sin Δθ; 0 where not told",
            unit="m, m, 1, 1",
            frame="agent",
            told=(0, 0, 1, 1),
        ),
        Block(
            name="twist",
            size=3,
            describe="velocity of the object's centre of mass, and its spin",
            unit="m/s, m/s, rad/s",
            frame="agent",
        ),
        Block(
            name="own_wrench",
            size=3,
            describe="force and torque this agent applied",
            unit="N, N, N·m",
            frame="agent",
        ),
        Block(
            name="partner_wrench",
            size=EachOther(3),
            describe="force and torque each other agent applied",
            unit="N, N, N·m",
            frame="agent",
        ),
        Block(
            name="own_internal",
            size=3,
            describe="internal part of this agent's wrench",
            unit="N, N, N·m",
            frame="agent",
        ),
        Block(
            name="partner_internal",
            size=EachOther(3),
            describe="internal part of each other agent's wrench",
            unit="N, N, N·m",
            frame="agent",
        ),
        Block(
            name="load_share",
            size=2,
            describe="this agent's share of the force and of the torque; 1/n where undefined",
            low=0.0,
            high=1.0,
            unit="1",
        ),
        Block(
            name="relative_cost",
            size=1,
            describe="γ, the fraction of the applied wrench's cost that was compensated",
            unit="1",
        ),
        Block(
            name="known",
            size=2,
            describe="whether this agent is told the goal's place, and its angle; else they read 0",
            read=_known,
            low=0.0,
            high=1.0,
            unit="1",
        ),
        Block(
            name="body",
            size=EachOther(4, own=9),
            describe="mass, inertia, linear drag, angular drag, friction, length; then of each "
            "agent, its own first, x and y of the grip from the centre of mass (its own: x), force "
            "limit, torque limit",
            read=privileged,
            unit="kg, kg·m², N·s/m, N·m·s, 1, m, m, N, N·m, then m, m, N, N·m",
            frame="agent",
        ),
        Block(
            name="time",
            size=1,
            describe="what is left of the episode, from 1 down to 0",
            read=_time_left,
            low=0.0,
            high=1.0,
            unit="1",
        ),
        ranges(),
        ranges(whose="partners"),
    )
}

DEFAULT_BLOCKS = VIEW_PARTS
_OWN = ("goal", "known", "twist", "own_wrench", "obstacles")
SENSING: dict[str, tuple[str, ...]] = {  # the words for it that `TransportConfig` takes
    "own": _OWN,  # what an agent feels and sees by itself
    "shared": (  # what its partners feel and see too, and what takes all wrenches to know
        *_OWN,
        "partner_wrench",
        "partner_obstacles",
        "own_internal",
        "partner_internal",
        "load_share",
        "relative_cost",
    ),
}


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
        If numbers of a block or a sensor are not as many as its features.
    """

    def __init__(self, blocks: Sequence[Entry], num_agents: int, num_worlds: int = 1):
        chosen = [find_block(block) for block in blocks]
        sizes = [block.width(num_agents) for block in chosen]
        ends = np.cumsum(sizes).tolist()
        self.size: int = ends[-1]
        self.blocks = {
            block.name: slice(end - size, end)
            for block, size, end in zip(chosen, sizes, ends, strict=True)
        }
        low = [block.spread(block.low, num_agents, "low") for block in chosen]
        high = [block.spread(block.high, num_agents, "high") for block in chosen]
        self.low = np.concatenate(low).astype(np.float32)
        self.high = np.concatenate(high).astype(np.float32)
        self._chosen = chosen
        self._copies = _copies(chosen, self.blocks, view_slices(num_agents))
        self._all_worlds = np.arange(num_worlds)
        self._instruments = {
            block.name: Instruments(entry, block, num_agents, num_worlds)
            for block, entry in zip(chosen, blocks, strict=True)
            if isinstance(entry, Sensor)
        }
        whole_view = chosen == [BLOCKS[name] for name in VIEW_PARTS]
        self._is_whole_view = whole_view and not self._instruments

    def __call__(
        self, transition: Transition, worlds: IntArray | None = None
    ) -> npt.NDArray[np.float32]:
        """What every agent sees after ``transition``: ``(world, agent, size)``, a fresh array.

        ``worlds`` says which ones the rows of ``transition`` are of, if it is not all of them.
        Delayed readings are right where every step of an episode has been read once, in order.
        """
        view = transition.agent_view()
        if self._is_whole_view:
            return view
        seen = np.empty((*view.shape[:2], self.size), dtype=np.float32)
        for where, source in self._copies:
            seen[..., where] = view[..., source]
        for block, where in zip(self._chosen, self.blocks.values(), strict=True):
            if block.read is not None:
                seen[..., where] = _checked(block.read(transition), seen[..., where].shape, block)
        for name, instruments in self._instruments.items():
            where = self.blocks[name]
            truth = np.ascontiguousarray(seen[..., where])
            rows = self._all_worlds if worlds is None else worlds
            seen[..., where] = instruments(truth, transition, rows)
        return seen


def _copies(
    chosen: Sequence[Block], blocks: Mapping[str, slice], view: Mapping[str, slice]
) -> list[tuple[slice, slice]]:
    """What goes where from the agents' view; what lies side by side in both goes in one piece."""
    copies: list[tuple[slice, slice]] = []
    for block in chosen:
        if block.read is None:
            where, source = blocks[block.name], view[block.name]
            if copies and (copies[-1][0].stop, copies[-1][1].stop) == (where.start, source.start):
                last, before = copies.pop()
                where, source = slice(last.start, where.stop), slice(before.start, source.stop)
            copies.append((where, source))
    return copies


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
    """The sensor, or the block of ranges or of this module, that a dict describes."""
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
