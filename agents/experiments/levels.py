"""Levels of a grid: what each axis may change, and the options of a run that a level stands for."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, get_args, get_type_hints

from coopenv.errors import InvalidInput, UnknownName
from coopenv.physics.body import Body

from ..algorithms import RECIPES, Recipe, recipe_of
from ..algorithms.recipes import settings_in
from ..environment import GROUPS, EnvironmentChoice
from ..settings import TrainConfig
from .lines import Place, Source

LEARNER = "ppo"
LEARNERS = (LEARNER, *RECIPES)
ALGORITHMS = (*LEARNERS, "scripted", "random")  # the last two learn nothing and cost little
OF_CELLS = ("environment", "control", "seed", "out", "fresh", "threads")  # said by the grid itself
WHOLE = ("teams",)  # evaluated in environments of its own, of which a cell has one
ENVIRONMENT = tuple(entry.name for entry in fields(EnvironmentChoice))
TRAINING = tuple(
    entry.name for entry in fields(TrainConfig) if entry.name not in (*OF_CELLS, *WHOLE)
)
SETTINGS: Mapping[str, tuple[str, ...]] = {
    LEARNER: TRAINING,
    **{name: settings_in(name) for name in RECIPES},
}
"""Algorithm that learns -> settings of it that a level may say."""
CONTROLS = get_args(get_type_hints(TrainConfig)["control"])
LABEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,59}")  # of a level: part of a folder's name

# Axis -> what its levels may say; what a level that is no table stands for comes first.
AXES: Mapping[str, tuple[str, ...]] = {
    "task": ("env", "task", "scene", "horizon", "randomise", "partner", "cost", "bounded"),
    "body": tuple(entry.name for entry in fields(Body)),
    "reward": ("preset", "weights", "terms", "cost"),
    "observation": ("sensing", "observe", "bounded"),
    "action": ("action", "pushes", "hands", "actuators"),
    "control": ("control", "partner"),
    "algorithm": ("name", *dict.fromkeys(name for each in SETTINGS.values() for name in each)),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options of a run; what is not said is left to whoever comes before."""

    environment: Mapping[str, Any] = field(default_factory=dict)
    training: Mapping[str, Any] = field(default_factory=dict)
    terms: Mapping[str, Any] = field(default_factory=dict)
    algorithm: str = ""
    own: Mapping[str, Any] = field(default_factory=dict)
    """Settings of an algorithm of `RECIPES`, which are in ``training`` of no meaning."""

    def over(self, other: "Options") -> "Options":
        """These over others: tables of both are taken together, anything else is replaced."""
        environment = {**other.environment, **self.environment}
        for name in GROUPS:
            if name in other.environment and name in self.environment:
                environment[name] = {**other.environment[name], **self.environment[name]}
        for name, rival in (("observe", "sensing"), ("sensing", "observe")):
            if name in self.environment and rival not in self.environment:
                environment.pop(rival, None)
        return Options(
            environment=environment,
            training={**other.training, **self.training},
            terms={**other.terms, **self.terms},
            algorithm=self.algorithm or other.algorithm,
            own=self.own or other.own,
        )

    def recipe(self) -> Recipe | None:
        """Settings of an algorithm of `RECIPES`: its own, over what it shares with PPO.

        Raises
        ------
        InvalidInput
            If one of them breaks its rule.
        """
        if self.algorithm not in RECIPES:
            return None
        shared = RECIPES[self.algorithm].SHARED
        common = {name: self.training[name] for name in shared if name in self.training}
        return recipe_of(self.algorithm, {**common, **self.own})

    def choice(self) -> EnvironmentChoice:
        """The environment, but for terms of the reward."""
        values: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in self.environment.items()
        }
        return EnvironmentChoice(**values)


def taker(algorithms: Sequence[str]) -> str:
    """PPO if it is among the algorithms of a grid or none learns, else the first that does."""
    if LEARNER in algorithms:
        return LEARNER
    return next((name for name in algorithms if name in RECIPES), LEARNER)


def untaken(training: Mapping[str, Any], algorithms: Sequence[str]) -> list[str]:
    """Names of ``[training]`` that no algorithm takes, if there is one that learns."""
    if taker(algorithms) == LEARNER:
        return []
    shared = {name for each in algorithms if each in RECIPES for name in RECIPES[each].SHARED}
    return [name for name in training if name in TRAINING and name not in shared]


def named_levels(axis: str, given: Any, source: Source) -> Iterator[tuple[str, Any, Place]]:
    """Label, value and place of each level of an axis.

    Parameters
    ----------
    axis
        A name in `AXES`.
    given
        A table of levels by label, or an array of levels that name themselves.
    source
        For errors.

    Raises
    ------
    InvalidInput
        If there is none, one has no label or a label comes twice.
    """
    place: Place = ("grid", axis)
    if isinstance(given, Mapping):
        levels = [(name, value, (*place, name)) for name, value in given.items()]
    else:
        several = given if isinstance(given, Sequence) and not isinstance(given, str) else [given]
        levels = []
        for number, value in enumerate(several):
            with source.at((*place, number)):
                levels.append((_label_of(value, axis), value, (*place, number)))
    with source.at(place):
        if not levels:
            raise InvalidInput(f"{axis} must have at least one level, got none; leave the axis out")
    labels: set[str] = set()
    for label, value, where in levels:
        with source.at(where):
            if not LABEL.fullmatch(label):
                raise InvalidInput(
                    f"label of a level of {axis} must be letters, digits, _ . + or -, at most 60, "
                    f"got {label!r}; it names a folder: rename it"
                )
            if label.lower() in labels:  # some file systems tell no capitals apart
                raise InvalidInput(
                    f"level of {axis} must be there once, whatever its capitals, got {label!r} "
                    "again; it names a folder: rename it"
                )
            labels.add(label.lower())
        yield label, value, where


def read_level(axis: str, value: Any) -> Options:
    """The options that a level stands for.

    Raises
    ------
    InvalidInput, UnknownName
        If it says what its axis does not.
    """
    names = AXES[axis]
    if axis == "observation" and isinstance(value, list):
        value = {"observe": value}
    if isinstance(value, str) and axis != "body":
        value = {names[0]: value}
    if not isinstance(value, Mapping):
        raise InvalidInput(f"level of {axis} must be a table of options, got {value!r}; write one")
    for name in value:
        if name not in names:
            raise UnknownName(f"option of {axis}", name, names)
    return _READERS.get(axis, _environment)(value)


def read_environment(given: Any) -> Options:
    """Options of the environment that all cells have."""
    for name in _table(given, "environment"):
        if name not in ENVIRONMENT:
            raise UnknownName("option of environment", name, ENVIRONMENT)
    return _environment(given)


def read_training(given: Any) -> Options:
    """Options of the training that all cells have."""
    known = (*TRAINING, "control")
    for name in _table(given, "training"):
        if name not in known:
            elsewhere = {"seed": "write seeds under [experiment]"}
            raise UnknownName("option of training", name, known, elsewhere)
    return _training(given)


def _table(given: Any, what: str) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise InvalidInput(f"{what} must be a table of options, got {given!r}; write [{what}]")
    return given


def _environment(value: Mapping[str, Any]) -> Options:
    for name in GROUPS:
        if name in value:
            _table(value[name], name)
    return Options(environment=value)


def _training(value: Mapping[str, Any]) -> Options:
    if "control" in value and value["control"] not in CONTROLS:
        raise UnknownName("control", value["control"], CONTROLS)
    found = {k: tuple(v) if isinstance(v, list) else v for k, v in value.items()}
    return Options(training=found)


def _body(value: Mapping[str, Any]) -> Options:
    return Options(environment={"body": dict(value)})


def _reward(value: Mapping[str, Any]) -> Options:
    _table(value.get("terms", {}), "terms")
    rest = {name: value[name] for name in ("weights", "cost") if name in value}
    if "preset" in value:
        rest["reward"] = value["preset"]
    return Options(environment=_environment(rest).environment, terms=value.get("terms", {}))


def _control(value: Mapping[str, Any]) -> Options:
    training = _training({k: v for k, v in value.items() if k == "control"}).training
    return Options(
        environment={k: v for k, v in value.items() if k == "partner"}, training=training
    )


def _algorithm(value: Mapping[str, Any]) -> Options:
    name = value.get("name", LEARNER)
    if name not in ALGORITHMS:
        raise UnknownName("name of algorithm", name, ALGORITHMS)
    rest = {key: entry for key, entry in value.items() if key != "name"}
    if rest and name not in LEARNERS:
        raise InvalidInput(
            f"algorithm {name!r} must come without settings of a training, got {sorted(rest)}; "
            "it learns nothing: leave them out"
        )
    for key in rest:
        if key not in SETTINGS[name]:
            raise UnknownName(f"setting of {name}", key, SETTINGS[name])
    if name in RECIPES:
        return Options(own=rest, algorithm=name)
    return Options(training=_training(rest).training, algorithm=name)


def algorithm_named(level: Any) -> str:
    """The algorithm of a level of that axis, as it says it, known or not."""
    return str(level.get("name", LEARNER) if isinstance(level, Mapping) else level)


_READERS = {
    "body": _body,
    "reward": _reward,
    "control": _control,
    "algorithm": _algorithm,
}


def _label_of(value: Any, axis: str) -> str:
    """What a level is called that is given without a name."""
    if isinstance(value, str):
        return re.split(r"[/:]", value)[-1]
    if isinstance(value, list) and value and all(isinstance(each, str) for each in value):
        return "+".join(value)
    raise InvalidInput(
        f"level of {axis} must have a name where it is no word, got {value!r}; write "
        f"[grid.{axis}.NAME]"
    )
