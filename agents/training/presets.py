"""Settings of PPO for each environment: what ``coopenv train`` takes where nothing is said."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from coopenv.config.hands import BY_HANDS

from ..environment import EnvironmentChoice
from ..environment.teams import seen_in_any_team
from ..settings import TrainConfig

_THOROUGH = {"num_worlds": 64, "rollout": 128, "epochs": 10}  # twice the gradient steps

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "coopenv/BeamDoorway-v0": {**_THOROUGH, "steps": 1_800_000},
    "coopenv/BeamLift-v0": {**_THOROUGH, "steps": 1_200_000},
    "coopenv/BeamTracking-v0": {**_THOROUGH, "steps": 600_000},
    "coopenv/WalkerAvoid-v0": {**_THOROUGH, "steps": 600_000},
    "coopenv/WalkerTurn-v0": {**_THOROUGH, "steps": 600_000},
}
"""Gymnasium id to what is not as in `coopenv.agents.settings.TrainConfig`."""

ALSO_OBSERVED: Mapping[str, tuple[str, ...]] = {
    "coopenv/BeamDoorway-v0": ("near_goal",),
    "coopenv/BeamLift-v0": ("near_goal",),
    "coopenv/WalkerAvoid-v0": ("near_goal", "course"),
}
"""Gymnasium id to blocks without which mean actions come to rest beside the goal, or are caught."""

HANDS_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "coopenv/WalkerAvoid-v0": {**_THOROUGH, "steps": 1_800_000},
}
HANDS_OBSERVED: Mapping[str, tuple[str, ...]] = {
    "coopenv/WalkerAvoid-v0": ("near_goal", "course", "stretch"),
    "coopenv/WalkerTurn-v0": ("near_goal", "stretch"),
}
"""Both where agents move hands: those who turn a body on wheels see how far their hands are off."""

SHARED_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "coopenv/WalkerAvoid-v0": {**_THOROUGH, "steps": 1_800_000},
}
"""The same where every agent runs one policy, of whom one is not told the goal."""


def preset(env: str, action: str | None = None, control: str | None = None) -> dict[str, Any]:
    """Settings of a training in the environment of a Gymnasium id; none for one of your own.

    Parameters
    ----------
    env
        The id, with the module that registers it before a colon or without.
    action
        What agents give, if not what the environment has.
    control
        Who learns, if not one policy for the team.
    """
    name = _id(env)
    found = HANDS_PRESETS.get(name) if action in BY_HANDS else None
    if found is None and control == "shared":
        found = SHARED_PRESETS.get(name)
    return dict(PRESETS.get(name, {}) if found is None else found)


def observing(config: TrainConfig) -> TrainConfig:
    """A run with the blocks that a training of its id needs, unless it says what is observed.

    One of teams of several sizes has none whose size grows with the team, and those of
    `coopenv.agents.environment.teams.OF_ANY_TEAM`.

    Parameters
    ----------
    config
        Of the run; it says so by ``also_observe``, ``observe`` or ``sensing`` of its environment.
    """
    chosen = config.environment
    said = chosen.observe is not None or chosen.sensing is not None
    also = chosen.also_observe
    if also is None:
        also = () if said else _needed(chosen)
    if config.teams and not said:
        observe = seen_in_any_team(chosen.config(), also)
        also = also if observe is None else ()
        return replace(config, environment=replace(chosen, observe=observe, also_observe=also))
    return replace(config, environment=replace(chosen, also_observe=also))


def _needed(chosen: EnvironmentChoice) -> tuple[str, ...]:
    """Blocks of `ALSO_OBSERVED`, or with hands of `HANDS_OBSERVED`."""
    name = _id(chosen.env)
    found = HANDS_OBSERVED.get(name) if chosen.action in BY_HANDS else None
    return ALSO_OBSERVED.get(name, ()) if found is None else found


def _id(env: str) -> str:
    """Without the module that registers it."""
    return env.rpartition(":")[2]


def train_config(environment: EnvironmentChoice | str, **settings: Any) -> TrainConfig:
    """Settings of a run: those that are given, the others as the environment's `preset` has them.

    Parameters
    ----------
    environment
        Of the run, or its id; `observing` says what is observed where it does not.
    **settings
        Fields of `coopenv.agents.settings.TrainConfig`.

    Raises
    ------
    InvalidInput, UnknownName
        If a setting breaks its rule, or the environment does not exist.

    Examples
    --------
    >>> train_config("coopenv/BeamDoorway-v0", seed=3).steps > TrainConfig().steps
    True
    """
    if isinstance(environment, str):
        environment = EnvironmentChoice(env=environment)
    control = settings.get("control")
    given = {**preset(environment.env, environment.action, control), **settings}
    return observing(TrainConfig(environment=environment, **given))
