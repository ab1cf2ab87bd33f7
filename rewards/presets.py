"""Preset rewards and costs by name, and parsing of the keywords ``reward=`` and ``cost=``."""

from collections.abc import Mapping
from typing import Any

from coopenv.errors import InvalidInput, UnknownName

from .energy import InternalPower, StoredEnergy
from .shaping import Progress
from .sums import RewardSum
from .terms import (
    ActionRate,
    Contact,
    Effort,
    InternalForce,
    InternalTorque,
    RelativeCost,
    Success,
    TimeCost,
    TrackingError,
    WastedCost,
)

_TASK = {"progress": Progress(weight=5.0), "success": Success(), "time": TimeCost()}

PRESETS: dict[str, RewardSum] = {
    # only the bonus and the clock: for exploration studies
    "sparse": RewardSum({"success": Success(), "time": TimeCost()}),
    # get it there
    "task": RewardSum(_TASK),
    # get it there without fighting the partner
    "harmony": RewardSum({**_TASK, "relative_cost": RelativeCost(weight=0.3)}),
    # get it there gently: no squeezing, no waste, no jerks, no knocks
    "balanced": RewardSum(
        {
            **_TASK,
            "internal_force": InternalForce(),
            "internal_torque": InternalTorque(),
            "effort": Effort(),
            "action_rate": ActionRate(),
            "contact": Contact(),
        }
    ),
    # follow a reference without fighting the partner, and come to rest at its end
    "tracking": RewardSum(
        {
            "tracking": TrackingError(),
            "success": Success(),
            "relative_cost": RelativeCost(weight=0.02),
        }
    ),
}


# What safe learning bounds, in its own unit: each is all that an agent is not to do, and no task.
COSTS: dict[str, RewardSum] = {
    # knocks at walls and obstacles [N·s]
    "contact": RewardSum({"contact": Contact(weight=1.0)}),
    # squeezing, each agent its part [N]
    "squeeze": RewardSum({"internal_force": InternalForce(weight=1.0)}),
    # what the team spends against itself [N]
    "waste": RewardSum({"wasted_cost": WastedCost(weight=1.0, scale=1.0)}),
    # what agents pass to each other through what they hold [W]
    "internal_power": RewardSum({"internal_power": InternalPower(weight=1.0, scale=1.0)}),
    # what the springs of each agent's hand hold [J]
    "stored_energy": RewardSum({"stored_energy": StoredEnergy(weight=1.0, scale=1.0)}),
}


def find_cost(cost: Any) -> RewardSum:
    """A cost as a `RewardSum`: a name of `COSTS`, or whatever `find_reward` takes.

    Raises
    ------
    UnknownName, InvalidInput
        As `find_reward`.
    """
    if isinstance(cost, str):
        known = {**PRESETS, **COSTS}
        if cost not in known:
            raise UnknownName("cost", cost, known)
        return known[cost]
    return find_reward(cost, what="cost", also=tuple(COSTS))


def find_reward(reward: Any, *, what: str = "reward", also: tuple[str, ...] = ()) -> RewardSum:
    """A preset by name, a mapping of named terms, or a single term, as a `RewardSum`.

    ``what`` it is, and which names it has ``also``, are for errors.

    Raises
    ------
    UnknownName
        For a preset that does not exist.
    InvalidInput
        For anything else that is not a reward.
    """
    if isinstance(reward, RewardSum):
        return reward
    if isinstance(reward, str):
        if reward not in PRESETS:
            raise UnknownName(what, reward, PRESETS)
        return PRESETS[reward]
    if isinstance(reward, Mapping):
        return RewardSum(reward)
    if callable(reward) and not isinstance(reward, type):
        term: Any = reward
        return RewardSum({getattr(term, "__name__", type(term).__name__): term})
    raise InvalidInput(
        f"{what} must be a preset name, a RewardSum or a term, got {reward!r}; "
        f"presets: {', '.join((*also, *PRESETS))}"
    )
