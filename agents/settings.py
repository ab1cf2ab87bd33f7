"""Configuration of a training run, read from the command line and kept as JSON."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

from typing_extensions import Self

from coopenv.arrays import number, positive, whole
from coopenv.envs import registry
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.files import reading, written

from . import partners
from .environment import EnvironmentChoice
from .environment.overrides import values_of
from .environment.teams import read_teams
from .seeds import BLOCK, training_seeds

MOST = {  # beyond, numbers overflow, worlds share seeds, or no training comes to its end
    "steps": 10**12,
    "num_worlds": BLOCK // 2,
    "threads": 1024,
    "epochs": 10**6,
    "batch_size": 10**12,
    "learning_rate": 1.0,
    "clip_range": 1e6,
    "initial_std": 1e3,
    "entropy_weight": 1e6,
}

MOST_UNITS = 10**5  # of a layer, whose weights are then still in reach of a machine
NOTED = ("provenance",)  # entries of config.json that others write beside the settings
UNSAVED = ("fresh",)  # said for one call, and never taken from a file: it removes a run


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainConfig:
    """PPO of Stable-Baselines3; the defaults learn BeamTransport."""

    environment: EnvironmentChoice = field(default_factory=EnvironmentChoice)
    control: Literal["joint", "shared", "partner"] = "joint"
    """One policy for the whole team, the same policy for every agent, or a policy for the one agent
    that is left beside a partner (environment.partner; if none is named, impedance, and in a walker
    walking)."""
    teams: tuple[int, ...] = ()
    """Sizes of teams that train side by side, each as environment.team has it: 2 4. One policy for
    all of them, with control shared; the worlds are shared out evenly."""
    seed: int = 0
    """Number of the run; no two runs share an episode (coopenv.agents.seeds)."""
    steps: int = 900_000
    """Control steps, counted over all worlds, in whole rollouts; more of them go on with a run that
    is finished."""
    until: float | None = None
    """Success rate at which the training ends before its steps, checked between updates on held-out
    episodes of its own: the lower end of the 95 % interval has to reach it. Below 1."""
    num_worlds: int = 256
    """Worlds stepped together."""
    rollout: int = 32
    """Control steps of each world between two updates."""
    batch_size: int = 2048
    """Samples in a gradient step."""
    epochs: int = 5
    """Times each sample is used."""
    learning_rate: float = 1e-3
    """At the start; it falls linearly to zero at steps. A run that goes on with more steps has the
    rate of a run of so many from there on, which is higher than the one it ended with."""
    discount: float = 0.99
    """Per control step."""
    gae_lambda: float = 0.95
    """Per control step."""
    clip_range: float = 0.2
    """PPO's bound on the change of the action's probability ratio."""
    entropy_weight: float = 0.0
    """Reward for randomness [reward / nat]."""
    initial_std: float = 0.6
    """Spread of the first actions, in units of the limits."""
    hidden: tuple[int, ...] = (64, 64)
    """Layers of the policy's and of the value's network."""
    threads: int = 1
    """Of torch; more than one is slower at these sizes."""
    checkpoint_every: int = 10
    """Updates between two checkpoints."""
    fresh: bool = False
    """Start over, and remove the run that the folder holds. Not kept with the other settings."""
    out: Path = Path("runs/beam_transport")
    """Folder for the policy, logs and pictures."""

    def __post_init__(self) -> None:
        counts = ("steps", "num_worlds", "rollout", "epochs", "checkpoint_every", "threads")
        least = {
            **dict.fromkeys(counts, 1),
            "batch_size": 2,
            "seed": 0,
        }  # advantages are normalised
        for name, at_least in least.items():  # 3e5 of a file is 300,000
            object.__setattr__(self, name, whole(getattr(self, name), name, at_least=at_least))
        if not isinstance(self.fresh, bool):  # anything else is true or false by accident
            raise InvalidInput(f"fresh must be True or False, got {self.fresh!r}; give one of them")
        _check_numbers(self)
        for name in ("learning_rate", "clip_range", "initial_std"):
            positive(getattr(self, name), name)
        if isinstance(self.environment, dict):  # as JSON brings it back
            _set = object.__setattr__
            _set(self, "environment", EnvironmentChoice(**_tuples(self.environment)))
            _set(self, "hidden", tuple(self.hidden))
            _set(self, "out", Path(self.out))
        self._set_teams()
        if self.control == "partner" and self.environment.partner is None:
            name = partners.default_partner(self.environment.config())
            partnered = replace(self.environment, partner=name)
            object.__setattr__(self, "environment", partnered)

    def _set_teams(self) -> None:
        """Read ``teams``; the environment is that of the first."""
        teams = read_teams(self.teams, control=self.control, num_worlds=self.num_worlds)
        object.__setattr__(self, "teams", teams)
        if not teams:
            return
        if self.environment.team not in (None, teams[0]):
            raise InvalidInput(
                f"team must be left out beside teams, got {self.environment.team!r} and {teams}; "
                "teams says all sizes"
            )
        if "grips" in values_of(self.environment.body, "body"):
            raise InvalidInput(
                "body must leave grips to teams, got grips of one size; every team holds the body "
                "evenly round its rim"
            )
        object.__setattr__(self, "environment", replace(self.environment, team=teams[0]))

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, strings and lists; without ``fresh``, which is said for one call.

        ``teams`` are said where there are some, so that a run of before reads as it did; then the
        environment's team, which is the first of them, is not.
        """
        left_out = UNSAVED if self.teams else (*UNSAVED, "teams")
        values = {name: value for name, value in asdict(self).items() if name not in left_out}
        if self.teams:
            values["environment"]["team"] = None
        return json.loads(json.dumps(values, default=str))

    def identity(self) -> dict[str, Any]:
        """What two runs must have in common for one to go on from the other's checkpoint.

        Beside it, all of the environment (`coopenv.agents.provenance`), whatever it was named by.
        """
        free = ("environment", "out", "threads", "checkpoint_every", "steps", "until")
        return {name: value for name, value in self.to_dict().items() if name not in free}

    def save(self, path: str | os.PathLike, *, notes: Mapping[str, Any] | None = None) -> None:
        """Write the configuration as JSON, and ``notes`` of others beside it."""
        with written(path) as part:
            part.write_text(json.dumps({**self.to_dict(), **(notes or {})}, indent=2) + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike) -> Self:
        """Read what `save` wrote, without the notes.

        Raises
        ------
        InvalidInput, UnknownName
            If the file cannot be read, or is none of a training run.
        """
        with reading(path):
            given = json.loads(Path(path).read_text())
        if isinstance(given, dict):
            given = {name: given[name] for name in given if name not in NOTED}
        return cls.from_dict(given, os.fspath(path))

    @classmethod
    def from_dict(cls, given: Mapping[str, Any], source: str = "a training run") -> Self:
        """The configuration that `to_dict` made plain, from ``source``; ``fresh`` is not taken.

        Raises
        ------
        InvalidInput, UnknownName
            If a value breaks its rule or a name is not known; or if a module would be imported to
            learn who the partner is, which a run writes.
        """
        _check_names(given, f"entry of {source}", cls)
        given = {name: value for name, value in given.items() if name not in UNSAVED}
        environment = given.get("environment", {})
        _check_names(environment, f"environment's entry of {source}", EnvironmentChoice)
        if given.get("control") == "partner" and environment.get("partner") is None:
            registry.require_trusted(str(environment.get("env", "")), False, source)
        try:
            return cls(**given)
        except CoopenvError:
            raise
        except Exception as error:  # values of another kind can raise anything
            raise InvalidInput(
                f"{source} must hold settings as a run writes them, got another kind of value "
                f"({error}); copy it again"
            ) from error


def _check_names(given: Any, what: str, kind: type) -> None:
    """Raise unless ``given`` is a mapping whose names are fields of ``kind``."""
    names = [entry.name for entry in fields(kind)]
    if not isinstance(given, Mapping):
        raise InvalidInput(f"{what} must be a name with a value, got {given!r}; write it again")
    for name in given:
        if name not in names:
            raise UnknownName(what, name, names)


def _check_numbers(config: "TrainConfig") -> None:
    """Raise where a number is beyond what the learner can compute with."""
    for name, most in MOST.items():
        if number(getattr(config, name), name) > most:
            raise InvalidInput(
                f"{name} must be at most {most:,}, got {getattr(config, name):,}; lower it"
            )
    for name in ("discount", "gae_lambda"):
        if not 0 < number(getattr(config, name), name) <= 1:
            raise InvalidInput(
                f"{name} must be above 0 and at most 1, got {getattr(config, name)!r}; 0.95 or "
                "0.99 are common"
            )
    if config.until is not None and not 0 < number(config.until, "until") < 1:
        raise InvalidInput(
            f"until must be above 0 and below 1, got {config.until!r}; no number of episodes shows "
            "that all succeed: 0.98 ends soon, None goes on to the end of the steps"
        )
    training_seeds(config.seed, config.num_worlds)
    if config.steps <= config.num_worlds * config.rollout:  # the last update's rate is zero
        raise InvalidInput(
            f"steps must be more than the {config.num_worlds * config.rollout:,} of one rollout "
            f"(num_worlds × rollout), got {config.steps:,}, which learns nothing; give more, or "
            "fewer worlds"
        )
    if config.rollout * config.num_worlds < 2:
        raise InvalidInput("rollout must be at least 2 with one world, got 1; raise it")
    object.__setattr__(config, "hidden", layers(config.hidden))


def layers(given: Any) -> tuple[int, ...]:
    """Sizes of the hidden layers of a network; raises `InvalidInput` unless they are some."""
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InvalidInput(f"hidden must be sizes of layers, got {given!r}; list them")
    if not given:
        raise InvalidInput("hidden must be sizes of layers, got none; give at least one: 64")
    return tuple(whole(each, "hidden", at_least=1, at_most=MOST_UNITS) for each in given)


def _tuples(value: dict[str, Any]) -> dict[str, Any]:
    return {k: tuple(v) if isinstance(v, list) else v for k, v in value.items()}
