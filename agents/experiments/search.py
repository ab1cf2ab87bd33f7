"""Search over an algorithm's settings, of a given number of trials, with Optuna.

A trial is a grid of its own: the settings drawn, with every problem and way of the experiment, on
seeds and episodes that the experiment itself does not use.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.arrays import whole
from coopenv.errors import InvalidInput, MissingExtra, UnknownName
from coopenv.files import written

from .cell import FORMAT, RESULT, Cell, digest_of, read_json
from .grid import MOST_SEED, Experiment
from .levels import LEARNER, LEARNERS, algorithm_named
from .report.measures import MEASURES, SUCCESS
from .space import check_space, distributions_of, settings_of, space_of

FIRST_SEED = MOST_SEED + 1  # of the trainings of a search
EVALUATION = 1  # number of its evaluations; those of the experiment have 0
FOLDER, TRIAL = "search", "trial.json"
OPTIONS = ("seeds", "objective", "only", "space")

Run = Callable[[list[Cell], Path], Mapping[str, str]]
"""Runs cells in a folder; why some failed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """What is searched, and by what it is judged.

    Parameters
    ----------
    space
        Name of a setting of PPO -> ``{low, high}``, with ``log = true`` over orders of magnitude,
        or ``{choices = [...]}``; name of another algorithm that learns -> such a table of its
        settings. An algorithm without any is not searched.
    seeds
        Trainings of every setting in a trial.
    objective
        The measure of `MEASURES` whose mean over a trial's cells is to be best.
    only
        Axis -> labels of the levels that trials have; of other axes, and without it, all.
    """

    space: Mapping[str, Any] = field(default_factory=dict)
    seeds: int = 2
    objective: str = SUCCESS
    only: Mapping[str, Sequence[str]] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Mapping[str, Any], experiment: Experiment) -> "Search":
        """What stands under ``[search]``, checked; errors say the line.

        Raises
        ------
        InvalidInput, UnknownName
            If something of it breaks its rule.
        """
        at = experiment.source.at
        for name in given:
            with at(("search", name)):
                if name not in OPTIONS:
                    raise UnknownName("option of search", name, OPTIONS)
        with at(("search", "seeds")):
            whole(given.get("seeds", 2), "seeds", at_least=1, at_most=1000)
        with at(("search", "objective")):
            if given.get("objective", SUCCESS) not in tuple(MEASURES):
                raise UnknownName("objective", given["objective"], MEASURES)
        _check_only(given.get("only", {}), experiment)
        space = given.get("space", {})
        check_space(space, set(_named(experiment).values()), experiment.source)
        return cls(**given)

    def run(
        self, experiment: Experiment, trials: int, run: Run
    ) -> tuple[Experiment, dict[str, dict[str, Any]]]:
        """The experiment with the best settings found for each algorithm that learns, and these.

        A trial that is finished is not repeated; what is drawn next depends on those before it
        alone, so that a search that was killed comes to the same end.

        Parameters
        ----------
        experiment
            Whose folder the trials go into.
        trials
            For each algorithm.
        run
            Runs the cells of a trial in its folder.

        Raises
        ------
        InvalidInput
            If no trial of an algorithm came to an end.
        MissingExtra
            If Optuna is not installed.
        """
        require_optuna()
        whole(trials, "tune", at_least=1)
        tuned, found = experiment, {}
        for label, algorithm in self.algorithms(experiment).items():
            name = label or LEARNER
            place = experiment.out / FOLDER / name
            best = self._best(experiment, label, algorithm, place, trials, run)
            tuned, found[name] = tuned.over(label, best), best
        return tuned, found

    def algorithms(self, experiment: Experiment) -> dict[str | None, str]:
        """Label -> algorithm of those that are searched; ``None`` in a grid without that axis."""
        return {
            label: algorithm
            for label, algorithm in _named(experiment).items()
            if algorithm in LEARNERS and space_of(self.space, algorithm)
        }

    def cells(
        self, experiment: Experiment, label: str | None, settings: Mapping[str, Any]
    ) -> list[Cell]:
        """The cells of a trial: those of one algorithm, on seeds and episodes of the search."""
        own = replace(experiment.over(label, settings), seeds=(0,), wandb=None)
        return [
            replace(
                cell,
                seed=FIRST_SEED + number,
                training=replace(cell.training, seed=FIRST_SEED + number),
                evaluation=EVALUATION,
            )
            for cell in own.cells()
            if label is None or cell.levels["algorithm"] == label
            if all(cell.levels[axis] in labels for axis, labels in self.only.items())
            for number in range(self.seeds)
        ]

    def _best(
        self,
        experiment: Experiment,
        label: str | None,
        algorithm: str,
        folder: Path,
        trials: int,
        run: Run,
    ) -> dict[str, Any]:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        higher, space = MEASURES[self.objective].higher, space_of(self.space, algorithm)
        study = optuna.create_study(direction="maximize" if higher else "minimize")
        for trial_number in range(trials):
            place = folder / f"trial_{trial_number:03d}"
            study.sampler = optuna.samplers.TPESampler(seed=trial_number)
            trial = study.ask(distributions_of(space, algorithm))
            settings = settings_of(space, trial.params)
            value = self._value(experiment, label, settings, place, run)
            state = optuna.trial.TrialState
            study.tell(trial, value, None if value is not None else state.FAIL)
        if not any(trial.value is not None for trial in study.trials):
            raise InvalidInput(
                f"search must have a trial that comes to an end, got none of {trials}; look at "
                f"failure.txt below {folder}, and narrow the space"
            )
        return settings_of(space, study.best_trial.params)

    def _value(
        self,
        experiment: Experiment,
        label: str | None,
        settings: Mapping[str, Any],
        place: Path,
        run: Run,
    ) -> float | None:
        """Mean objective of a trial; ``None`` if one of its cells failed or has none."""
        path, cells, why = place / TRIAL, [], ""
        try:
            cells = self.cells(experiment, label, settings)
        except InvalidInput as error:  # settings that do not go together
            why = str(error)
        told = {"objective": self.objective, "cells": [cell.digest() for cell in cells]}
        mark = digest_of({"settings": dict(settings), **told})
        if path.exists():
            found = read_json(path)
            if found.get("trial") == mark:
                return found.get("value")
            raise InvalidInput(
                f"out must hold no other search, got {path}, which is of other settings or of "
                "another experiment; choose another out (--out), or move the folder away"
            )
        value = None
        if cells:
            failures = run(cells, place)
            seen = (
                [] if failures else [_seen(place / cell.folder, self.objective) for cell in cells]
            )
            value = float(np.mean(seen)) if seen and all(map(isfinite, seen)) else None
            why = "; ".join(failures.values())
        content = {
            "format": FORMAT,
            "trial": mark,
            "settings": settings,
            "value": value,
            "failed": why,
        }
        with written(path) as part:
            part.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        return value


def require_optuna() -> None:
    """Raise `MissingExtra` unless Optuna is installed."""
    try:
        import optuna  # noqa: F401
    except ImportError as error:
        raise MissingExtra("a search over settings", "search") from error


def _named(experiment: Experiment) -> dict[str | None, str]:
    """Label -> algorithm, as the level says it; ``None`` in a grid without that axis."""
    levels = experiment.levels().get("algorithm")
    if levels is None:
        return {None: LEARNER}
    return {level.label: algorithm_named(level.value) for level in levels}


def _check_only(given: Any, experiment: Experiment) -> None:
    """Raise unless it names levels of the grid, on other axes than that of algorithms."""
    with experiment.source.at(("search", "only")):
        if not isinstance(given, Mapping):
            raise InvalidInput(f"only must be a table of axes, got {given!r}; write one")
    axes = {axis: v for axis, v in experiment.levels().items() if axis != "algorithm"}
    for axis, labels in given.items():
        with experiment.source.at(("search", "only", axis)):
            if axis not in axes:
                raise UnknownName("axis of only", axis, axes)
            if not isinstance(labels, list) or not labels:
                raise InvalidInput(f"only must list labels of {axis}, got {labels!r}; list some")
            for label in labels:
                if label not in (known := [level.label for level in axes[axis]]):
                    raise UnknownName(f"level of {axis} in only", label, known)


def _seen(folder: Path, objective: str) -> float:
    value = read_json(folder / RESULT)["evaluation"][objective]
    return float("nan") if value is None else float(value)
