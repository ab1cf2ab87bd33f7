"""Named observation blocks, put together into one array per agent."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from coopenv import frames
from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, UnknownName
from coopenv.transition import Transition


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """One named part of an observation.

    ``read`` returns ``(world, agent, size(num_agents))`` from the transition that led here.
    """

    name: str
    read: Callable[[Transition], FloatArray]
    size: Callable[[int], int]  # of the number of agents
    describe: str  # contents, unit and frame
    low: float = -np.inf
    high: float = np.inf


def _goal(transition: Transition) -> FloatArray:
    state = transition.next_state
    return frames.goals_to_agents(state.goal, state.pose, transition.team.frame)


def _twist(transition: Transition) -> FloatArray:
    state = transition.next_state
    return frames.rates_to_agents(state.twist, state.pose, transition.team.frame)


def _own_wrench(transition: Transition) -> FloatArray:
    return frames.to_agents(transition.applied, transition.team.frame)


def _partner_wrench(transition: Transition) -> FloatArray:
    return frames.others_to_agents(transition.applied, transition.team.frame)


def _own_internal(transition: Transition) -> FloatArray:
    return frames.to_agents(transition.decomposition.internal, transition.team.frame)


def _partner_internal(transition: Transition) -> FloatArray:
    return frames.others_to_agents(transition.decomposition.internal, transition.team.frame)


def _load_share(transition: Transition) -> FloatArray:
    share = transition.decomposition.load_share
    both = np.empty((*share.force.shape, 2))
    both[..., 0], both[..., 1] = share.force, share.torque
    both[np.isnan(both)] = 1 / transition.team.num_agents
    return both


def _relative_cost(transition: Transition) -> FloatArray:
    return transition.per_agent(transition.decomposition.relative_cost)[..., None]


def _time(transition: Transition) -> FloatArray:
    left = 1 - transition.next_state.time / (transition.horizon * transition.dt)
    return transition.per_agent(left)[..., None]


def _wrench_size(num_agents: int) -> int:
    return 3


def _others_size(num_agents: int) -> int:
    return 3 * (num_agents - 1)


BLOCKS: dict[str, Block] = {
    block.name: block
    for block in (
        Block(
            name="goal",
            read=_goal,
            size=lambda num_agents: 4,
            describe="way from the object to its goal: Δx, Δy [m], cos Δθ, sin Δθ; agent frame",
        ),
        Block(
            name="twist",
            read=_twist,
            size=lambda num_agents: 3,
            describe="velocity of the object [m/s] and spin [rad/s]; agent frame",
        ),
        Block(
            name="own_wrench",
            read=_own_wrench,
            size=_wrench_size,
            describe="force [N] and torque [N·m] this agent applied; agent frame",
        ),
        Block(
            name="partner_wrench",
            read=_partner_wrench,
            size=_others_size,
            describe="force [N] and torque [N·m] each other agent applied; this agent's frame",
        ),
        Block(
            name="own_internal",
            read=_own_internal,
            size=_wrench_size,
            describe="internal part of this agent's wrench [N, N·m]; agent frame",
        ),
        Block(
            name="partner_internal",
            read=_partner_internal,
            size=_others_size,
            describe="internal part of each other agent's wrench [N, N·m]; this agent's frame",
        ),
        Block(
            name="load_share",
            read=_load_share,
            size=lambda num_agents: 2,
            describe="this agent's share of the force and of the torque; 1/n where undefined",
            low=0.0,
            high=1.0,
        ),
        Block(
            name="relative_cost",
            read=_relative_cost,
            size=lambda num_agents: 1,
            describe="γ, the fraction of the applied wrench's cost that was compensated",
        ),
        Block(
            name="time",
            read=_time,
            size=lambda num_agents: 1,
            describe="what is left of the episode, from 1 down to 0",
            low=0.0,
            high=1.0,
        ),
    )
}

DEFAULT_BLOCKS = (
    "goal",
    "twist",
    "own_wrench",
    "partner_wrench",
    "own_internal",
    "partner_internal",
    "load_share",
    "relative_cost",
)


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
        sizes = [block.size(num_agents) for block in chosen]
        ends = np.cumsum(sizes).tolist()
        self.size: int = ends[-1]
        self.blocks = {
            block.name: slice(end - size, end)
            for block, size, end in zip(chosen, sizes, ends, strict=True)
        }
        self.low = np.repeat([block.low for block in chosen], sizes).astype(np.float32)
        self.high = np.repeat([block.high for block in chosen], sizes).astype(np.float32)
        self._parts = [(block.read, self.blocks[block.name]) for block in chosen]

    def __call__(self, transition: Transition) -> npt.NDArray[np.float32]:
        """What every agent sees after ``transition``: ``(world, agent, size)``, a fresh array."""
        seen = np.empty((*transition.applied.shape[:2], self.size), dtype=np.float32)
        for read, where in self._parts:
            seen[..., where] = read(transition)
        return seen


def find_block(block: str | Block) -> Block:
    """The block of that name; a `Block` is returned as it is."""
    if isinstance(block, Block):
        return block
    if block not in BLOCKS:
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
