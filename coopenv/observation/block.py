"""Block: one named part of an observation, with its size, bounds, units and frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.transition import Transition


@dataclass(frozen=True, slots=True)
class EachOther:
    """Size of a block that has as many features about each other agent, after its ``own``."""

    features: int
    own: int = 0

    def __call__(self, num_agents: int) -> int:
        """Features in a team of ``num_agents``."""
        return self.own + self.features * (num_agents - 1)


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
    describe: str  # what it is
    read: Callable[[Transition], FloatArray] | None = None  # -> (world, agent, size); None: `VIEW`
    low: float | Sequence[float] = -np.inf  # one number, or one a feature
    high: float | Sequence[float] = np.inf
    unit: str = ""  # of the features, in order
    frame: str = ""  # along whose axes vectors are given
    needs_told: Sequence[int] = ()  # the column of `Conditions.told` each feature needs, if any
    needs_hands: bool = False  # whether it is only where hands carry out the actions
    is_sense: bool = True  # whether ``sensing`` brings it along with the task whose block it is

    def __post_init__(self) -> None:
        if not self.name or (isinstance(self.size, int) and self.size < 1):
            raise InvalidInput(
                f"a block must have a name and at least one feature, got {self.name!r} of size "
                f"{self.size!r}; name it and give its size"
            )

    def width(self, num_agents: int) -> int:
        """Number of features in a team of ``num_agents``."""
        return self.size if isinstance(self.size, int) else self.size(num_agents)

    def spread(self, values: object, num_agents: int, what: str) -> FloatArray:
        """One number, or one a feature, as one a feature ``(width,)``; ``what`` is for the error.

        Of a block about each other agent, the features about one of them are enough.
        """
        given, width = np.asarray(values, dtype=np.float64), self.width(num_agents)
        tiled = isinstance(self.size, EachOther) and not self.size.own
        each = self.size.features if tiled else width  # pyright: ignore[reportAttributeAccessIssue, reportFunctionMemberAccess]
        if given.ndim == 0:
            return np.full(width, given)
        if given.shape == (each,):
            return np.tile(given, width // each if each else 0)
        if given.shape != (width,):
            raise InvalidInput(
                f"{what} must be one number or one for each of the {each} features of "
                f"{self.name!r}, got {values!r}; give them in the order of its unit"
            )
        return given

    def ends(self, num_agents: int) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest of each feature, ``(width,)`` each."""
        low, high = self.low, self.high
        return self.spread(low, num_agents, "low"), self.spread(high, num_agents, "high")


def side_by_side(blocks: Sequence[Block], num_agents: int) -> dict[str, slice]:
    """The slice of each block where they follow one another, by name."""
    slices, end = {}, 0
    for block in blocks:
        begin, end = end, end + block.width(num_agents)
        slices[block.name] = slice(begin, end)
    return slices
