"""An experiment: a grid of task, body, reward, observation, action, control, algorithm, seeds."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

from coopenv.arrays import whole
from coopenv.errors import CoopenvError, InvalidInput, UnknownName

from ..provenance import Provenance
from ..seeds import evaluation_seeds
from .built import built
from .cell import Cell, setting_name
from .culprit import culprit
from .levels import (
    AXES,
    Options,
    named_levels,
    read_environment,
    read_level,
    read_training,
    taker,
    untaken,
)
from .lines import Place, Source

MOST_SEED = 999  # of a grid: those above are the search's
MOST_CELLS = 100_000
LONGEST = 240  # letters of the folder of a setting; most file systems have names of up to 255
PROBLEMS = ("task", "body")  # axes that are problems to be solved, not ways of solving them


@dataclass(frozen=True, slots=True)
class Level:
    """A level of an axis, as it was given and where."""

    axis: str
    label: str
    value: Any
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """A grid of runs, each level of each axis with each of the others, for every seed.

    Parameters
    ----------
    name
        Of the report.
    grid
        Axis -> its levels: a table of levels by label, or an array of levels that name themselves.
        `coopenv.agents.experiments.levels.AXES` says what each axis may change.
    environment, training
        Options that all cells have, of `coopenv.agents.settings`; levels go over them.
    seeds
        Numbers of the trainings of every setting, at most `MOST_SEED`.
    episodes
        Held-out episodes of each evaluation, the same ones for every cell.
    exclude
        Tables of axis and label: settings that have all of these are left out.
    problems
        Axes whose levels are problems: results are taken together over them.
    continues
        Whether a cell that was killed goes on from the trainer's checkpoint. Its numbers are then
        not those of one that was not killed; without it the cell begins anew, and they are.
    wandb
        Project of Weights & Biases that curves go to, where it is installed.
    out
        Folder of the experiment.
    source
        The file that it is from, for errors.

    Raises
    ------
    InvalidInput, UnknownName
        If something of it breaks its rule; with the line, if it is from a file.
    """

    name: str = "experiment"
    grid: Mapping[str, Any] = field(default_factory=dict)
    environment: Mapping[str, Any] = field(default_factory=dict)
    training: Mapping[str, Any] = field(default_factory=dict)
    seeds: Sequence[int] = (0, 1, 2, 3, 4)
    episodes: int = 200
    exclude: Sequence[Mapping[str, str]] = ()
    problems: Sequence[str] = PROBLEMS
    continues: bool = False
    wandb: str | None = None
    out: Path = Path("runs/experiment")
    source: Source = field(default_factory=Source, repr=False, compare=False)

    def __post_init__(self) -> None:
        at = self.source.at
        with at(("experiment", "episodes")):
            evaluation_seeds(0, whole(self.episodes, "episodes", at_least=1))
        with at(("experiment", "seeds")):
            object.__setattr__(self, "seeds", _seeds(self.seeds))
        with at(("experiment", "problems")):
            if not isinstance(self.problems, Sequence) or isinstance(self.problems, str):
                raise InvalidInput(f"problems must be axes, got {self.problems!r}; list them")
            for axis in self.problems:
                if axis not in tuple(AXES):  # which may be asked for a list too
                    raise UnknownName("problems", axis, AXES)
        for axis in self.grid:
            with at(("grid", axis)):
                if axis not in AXES:
                    raise UnknownName("axis of the grid", axis, AXES)

    def levels(self) -> dict[str, list[Level]]:
        """The levels of each axis of the grid."""
        return {
            axis: [Level(axis, *each) for each in named_levels(axis, self.grid[axis], self.source)]
            for axis in AXES
            if axis in self.grid
        }

    def cells(self) -> list[Cell]:
        """All cells, checked: each could begin, as far as can be known without running it.

        Raises
        ------
        InvalidInput
            If a level, or levels together, do not make a run; with the line, if from a file.
        """
        axes = self.levels()
        options = {
            (level.axis, level.label): self._checked(
                partial(read_level, level.axis), level.value, level.place
            )
            for levels in axes.values()
            for level in levels
        }
        named = [options["algorithm", each.label].algorithm for each in axes.get("algorithm", ())]
        common = self._common(named)
        self._check_excluded(axes)
        settings = [each for each in product(*axes.values()) if not self._is_excluded(each)]
        self._require_some(len(settings))
        return [cell for setting in settings for cell in self._cells_of(setting, common, options)]

    def over(self, algorithm: str | None, settings: Mapping[str, Any]) -> "Experiment":
        """The same with other settings of a level of the axis of algorithms, or of all cells."""
        if algorithm is None:
            return replace(self, training={**self.training, **settings})
        levels = {level.label: level.value for level in self.levels()["algorithm"]}
        own = levels[algorithm]
        own = {"name": own} if isinstance(own, str) else own
        levels[algorithm] = {**own, **settings}
        return replace(self, grid={**self.grid, "algorithm": levels})

    def _common(self, algorithms: Sequence[str]) -> Options:
        """What all cells have, checked by itself, for one of the algorithms that take it."""
        for name in untaken(self.training, algorithms):
            with self.source.at(("training", name)):
                raise InvalidInput(
                    f"training must be of an algorithm of the grid, got {name}, which none of "
                    f"{', '.join(algorithms)} takes from there; say it of the level that it is "
                    "for, or drop it"
                )
        found = Options(algorithm=taker(algorithms))
        for name, read in (("training", read_training), ("environment", read_environment)):
            given, rest = getattr(self, name), found

            def check(value: Any, read: Any = read, rest: Options = rest) -> Options:
                made = read(value).over(rest)
                built(made)
                return made

            found = self._checked(check, given, (name,))
        return found

    def _check_alone(self, level: Level, common: Options) -> None:
        """Raise if a level does not go with what all cells have, with the line of what does not."""

        def check(value: Any) -> Options:
            options = read_level(level.axis, value)
            built(options.over(common), complete=False)
            return options

        self._checked(check, level.value, level.place)

    def _checked(self, check: Callable[[Any], Options], value: Any, place: Place) -> Options:
        """What ``check`` makes of a value; an error says the line of the key that is its cause."""
        try:
            return check(value)
        except CoopenvError as error:
            where = culprit(check, value, error)
            with self.source.at((*place, *where)):
                raise error

    def _cells_of(
        self,
        setting: Sequence[Level],
        common: Options,
        options: Mapping[tuple[str, str], Options],
    ) -> Iterator[Cell]:
        """The cells of a setting, one a seed."""
        together = common
        for level in setting:
            together = options[level.axis, level.label].over(together)
        try:
            made = built(together)
            Provenance.of(made.training, made.environment)  # raises if it could not be written
        except CoopenvError as error:
            for level in setting:  # one that is wrong by itself is told with its own line
                self._check_alone(level, common)
            places = [level.place for level in setting]
            where = "; ".join(map(self.source.where, places))
            names = ", ".join(f"{level.axis}={level.label}" for level in setting)
            raise InvalidInput(
                f"{error} (levels that do not go together: {names}; {where}; mend them, or exclude "
                "that setting)"
            ) from error
        self._require_short(setting)
        for seed in self.seeds:
            yield Cell(
                levels={level.axis: level.label for level in setting},
                seed=seed,
                algorithm=together.algorithm,
                training=replace(made.training, seed=seed),
                environment=made.environment,
                episodes=self.episodes,
                evaluation=0,
                continues=self.continues,
                wandb=self.wandb,
                recipe=made.recipe,
            )

    def _require_short(self, setting: Sequence[Level]) -> None:
        """Raise `InvalidInput` if no folder can bear the labels of a setting, where it stands."""
        name = setting_name({level.axis: level.label for level in setting})
        if len(name) > LONGEST:
            with self.source.at(max(setting, key=lambda level: len(level.label)).place):
                raise InvalidInput(
                    f"labels of a setting must together be at most {LONGEST} letters with the "
                    f"names of their axes, got {len(name)} of {name!r}; they name a folder: "
                    "shorten them"
                )

    def _is_excluded(self, setting: Sequence[Level]) -> bool:
        labels = {level.axis: level.label for level in setting}
        return any(
            all(labels.get(axis) == label for axis, label in each.items()) for each in self.exclude
        )

    def _require_some(self, settings: int) -> None:
        """Raise `InvalidInput` if there are too many cells, or none."""
        cells = settings * len(self.seeds)
        with self.source.at(("grid",)):
            if cells > MOST_CELLS:
                raise InvalidInput(
                    f"grid must have at most {MOST_CELLS:,} cells, got {cells:,}; drop levels or "
                    "seeds"
                )
        with self.source.at(("exclude",)):
            if not cells:
                raise InvalidInput(
                    "grid must have a cell, got all of them excluded; drop an exclude"
                )

    def _check_excluded(self, axes: Mapping[str, Sequence[Level]]) -> None:
        for number, each in enumerate(self.exclude):
            with self.source.at(("exclude", number)):
                if not isinstance(each, Mapping) or not each:
                    raise InvalidInput(
                        f"exclude must be tables of axis and label, got {each!r}; write "
                        '{ action = "wrench", reward = "stored" }'
                    )
            for axis, label in each.items():
                with self.source.at(("exclude", number, axis)):
                    if axis not in axes:
                        raise UnknownName("axis of exclude", axis, axes)
                    known = [level.label for level in axes[axis]]
                    if label not in known:
                        raise UnknownName(f"level of {axis} in exclude", label, known)


def _seeds(given: Any) -> tuple[int, ...]:
    """Numbers of trainings; a single one is how many."""
    if isinstance(given, int) and not isinstance(given, bool):
        given = range(whole(given, "seeds", at_least=1, at_most=MOST_SEED + 1))
    if isinstance(given, str) or not isinstance(given, Sequence) or not len(given):
        raise InvalidInput(f"seeds must be a number of them or a list, got {given!r}; write 5")
    seeds = tuple(whole(each, "seeds", at_least=0, at_most=MOST_SEED) for each in given)
    if len(set(seeds)) < len(seeds):
        raise InvalidInput(f"seeds must each be there once, got {list(seeds)}; drop what repeats")
    return seeds
