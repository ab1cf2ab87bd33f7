"""Named observation blocks, put together into one array per agent."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, UnknownName
from coopenv.frames import VIEW_PARTS, view_slices
from coopenv.privileged import privileged, privileged_size
from coopenv.transition import Transition


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """One named part of an observation.

    Raises
    ------
    InvalidInput
        If ``name`` is empty or ``size`` is not at least 1.
    """

    name: str
    size: int | Callable[[int], int]  # features, or how many for a number of agents
    describe: str  # contents, unit and frame
    read: Callable[[Transition], FloatArray] | None = (
        None  # -> (world, agent, size); None: built in
    )
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        if not self.name or (isinstance(self.size, int) and self.size < 1):
            raise InvalidInput(
                f"a block must have a name and at least one feature, got {self.name!r} of size "
                f"{self.size!r}; name it and give its size"
            )

    def width(self, num_agents: int) -> int:
        """Number of features in a team of ``num_agents``."""
        return self.size if isinstance(self.size, int) else self.size(num_agents)


def _time_left(transition: Transition) -> FloatArray:
    left = 1 - transition.next_state.time / (transition.horizon * transition.dt)
    return transition.per_agent(left)[..., None]


def _known(transition: Transition) -> FloatArray:
    return transition.conditions.told.astype(np.float64)


def _others(num_agents: int) -> int:
    return 3 * (num_agents - 1)


BLOCKS: dict[str, Block] = {
    block.name: block
    for block in (
        Block(
            name="goal",
            size=4,
            describe="way from the object to its goal: Δx, Δy [m], cos Δθ, sin Δθ; agent frame",
        ),
        Block(
            name="twist",
            size=3,
            describe="velocity of the object [m/s] and spin [rad/s]; agent frame",
        ),
        Block(
            name="own_wrench",
            size=3,
            describe="force [N] and torque [N·m] this agent applied; agent frame",
        ),
        Block(
            name="partner_wrench",
            size=_others,
            describe="force [N] and torque [N·m] each other agent applied; this agent's frame",
        ),
        Block(
            name="own_internal",
            size=3,
            describe="internal part of this agent's wrench [N, N·m]; agent frame",
        ),
        Block(
            name="partner_internal",
            size=_others,
            describe="internal part of each other agent's wrench [N, N·m]; this agent's frame",
        ),
        Block(
            name="load_share",
            size=2,
            describe="this agent's share of the force and of the torque; 1/n where undefined",
            low=0.0,
            high=1.0,
        ),
        Block(
            name="relative_cost",
            size=1,
            describe="γ, the fraction of the applied wrench's cost that was compensated",
        ),
        Block(
            name="known",
            size=2,
            describe="whether this agent is told the goal's place, and its angle; else they read 0",
            read=_known,
            low=0.0,
            high=1.0,
        ),
        Block(
            name="body",
            size=privileged_size,
            describe="mass [kg], inertia [kg·m²], linear drag [N·s/m], angular drag [N·m·s], "
            "friction, length [m]; then of each agent, its own first, x and y of the grip from the "
            "centre of mass [m] (its own: x), force limit [N], torque limit [N·m]; agent frame",
            read=privileged,
        ),
        Block(
            name="time",
            size=1,
            describe="what is left of the episode, from 1 down to 0",
            read=_time_left,
            low=0.0,
            high=1.0,
        ),
    )
}

DEFAULT_BLOCKS = VIEW_PARTS


class Observation:
    """The chosen blocks, side by side.

    Parameters
    ----------
    blocks
        Names from `BLOCKS`, or `Block` objects of your own.
    num_agents
        Effectors in a world.

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
        If there is no block, or one twice.
    """

    def __init__(self, blocks: Sequence[str | Block], num_agents: int):
        chosen = [find_block(block) for block in blocks]
        sizes = [block.width(num_agents) for block in chosen]
        ends = np.cumsum(sizes).tolist()
        self.size: int = ends[-1]
        self.blocks = {
            block.name: slice(end - size, end)
            for block, size, end in zip(chosen, sizes, ends, strict=True)
        }
        self.low = np.repeat([block.low for block in chosen], sizes).astype(np.float32)
        self.high = np.repeat([block.high for block in chosen], sizes).astype(np.float32)
        self._chosen = chosen
        self._view = view_slices(num_agents)
        self._is_whole_view = chosen == [BLOCKS[name] for name in VIEW_PARTS]

    def __call__(self, transition: Transition) -> npt.NDArray[np.float32]:
        """What every agent sees after ``transition``: ``(world, agent, size)``, a fresh array."""
        view = transition.agent_view()
        if self._is_whole_view:
            return view
        seen = np.empty((*view.shape[:2], self.size), dtype=np.float32)
        for block, where in zip(self._chosen, self.blocks.values(), strict=True):
            if block.read is None:
                seen[..., where] = view[..., self._view[block.name]]
            else:
                seen[..., where] = _checked(block.read(transition), seen[..., where].shape, block)
        return seen


def _checked(value: FloatArray, shape: tuple[int, ...], block: Block) -> FloatArray:
    if np.shape(value) != shape:
        raise InvalidInput(
            f"block {block.name!r} must read an array of shape {shape}, got {np.shape(value)}; "
            "one row an agent of every world"
        )
    return value


def find_block(block: str | Block) -> Block:
    """The block of that name; a `Block` is returned as it is."""
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


def check_blocks(blocks: Sequence[str | Block]) -> None:
    """Raise unless ``blocks`` is a sequence of known, different blocks."""
    if isinstance(blocks, str) or not isinstance(blocks, Sequence) or not blocks:
        raise InvalidInput(
            f"observe must be a sequence of block names, got {blocks!r}; "
            f"pass for example observe={DEFAULT_BLOCKS[:2]}"
        )
    names = [find_block(block).name for block in blocks]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InvalidInput(f"observe must name each block once, got {doubled} twice; drop one")
