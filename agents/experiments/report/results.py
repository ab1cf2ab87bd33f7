"""Results of an experiment: its finished cells, and their scores by setting and problem."""

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Self

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.files import reading, written

from ...curves import Row
from ..cell import CELL, FAILURE, FORMAT, RESULT, Cell, digest_of, read_json
from ..grid import Experiment
from .statistics import Scores, scores_of

EXPERIMENT = "experiment.json"  # in the folder of an experiment
CURVES = "curves.csv"
IDENTITY = tuple(entry.name for entry in fields(Cell) if entry.name != "wandb")

Setting = tuple[str, ...]
"""Labels on the axes that are no problems."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A finished cell."""

    levels: Mapping[str, str]
    seed: int
    numbers: Mapping[str, float]
    """What its evaluation has, by name; NaN where undefined."""
    curves: Sequence[Row]
    versions: Mapping[str, str]
    revision: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """What an experiment's folder holds."""

    name: str
    axes: Mapping[str, Sequence[str]]
    """Axis -> labels of its levels."""
    problems: Sequence[str]
    """Axes over which results are taken together."""
    runs: Sequence[Run]
    waiting: Sequence[str]
    """Folders of cells that have no result."""
    failed: Mapping[str, str]
    """Of these, those that failed, and why."""
    settings_found: Mapping[str, Any]
    """Of a search, by algorithm."""

    @classmethod
    def load(cls, out: Path) -> Self:
        """What the folder of an experiment holds, finished or not.

        Raises
        ------
        InvalidInput
            If it is no such folder, or a file in it is damaged.
        """
        if not is_experiment(out):
            raise InvalidInput(
                f"folder must be that of an experiment, got {str(out)!r}, which has no "
                f"{EXPERIMENT}; coopenv experiment and coopenv sweep make one"
            )
        given = read_json(out / EXPERIMENT)
        with reading(out / EXPERIMENT):
            axes = {str(axis): [*map(str, labels)] for axis, labels in given["axes"].items()}
            cells = [
                (str(each["folder"]), {axis: each["levels"][axis] for axis in axes}, each["seed"])
                for each in given["cells"]
            ]
            kept = {"name": str(given["name"]), "axes": axes, "problems": [*given["problems"]]}
            kept["settings_found"] = {who: dict(v) for who, v in given["search"].items()}
        runs, waiting, failed = [], [], {}
        for folder, levels, seed in cells:
            run = _run(out / folder, levels, seed)
            if run is not None:
                runs.append(run)
                continue
            waiting.append(folder)
            if (out / folder / FAILURE).is_file():
                with reading(out / folder / FAILURE):
                    said = (out / folder / FAILURE).read_text(encoding="utf-8").strip()
                failed[folder] = said.splitlines()[-1] if said else "unknown"
        return cls(**kept, runs=runs, waiting=waiting, failed=failed)

    def setting_of(self, levels: Mapping[str, str]) -> Setting:
        """Labels on the axes that are no problems."""
        return tuple(levels[axis] for axis in self.axes if axis not in self.problems)

    def title(self, setting: Setting) -> str:
        """What to call a setting: its labels where there is a choice."""
        axes = [axis for axis in self.axes if axis not in self.problems]
        several = [
            label for axis, label in zip(axes, setting, strict=True) if len(self.axes[axis]) > 1
        ]
        return ", ".join(several) or ", ".join(setting) or "all"

    def by_setting(self) -> dict[Setting, list[Run]]:
        """The runs of each setting that has any, in the order of the grid."""
        found: dict[Setting, list[Run]] = {}
        for run in self.runs:
            found.setdefault(self.setting_of(run.levels), []).append(run)
        return found

    def by_problem(self, runs: Sequence[Run]) -> dict[Setting, list[Run]]:
        """Runs by their labels on the axes that are problems."""
        found: dict[Setting, list[Run]] = {}
        for run in runs:
            problem = tuple(run.levels[axis] for axis in self.axes if axis in self.problems)
            found.setdefault(problem, []).append(run)
        return found

    def values(self, runs: Sequence[Run], measure: str) -> dict[Setting, FloatArray]:
        """``(run,)`` of a measure for each problem, of the runs in which it is defined."""
        found = {
            problem: np.array([run.numbers.get(measure, nan) for run in group])
            for problem, group in self.by_problem(runs).items()
        }
        kept = {problem: values[np.isfinite(values)] for problem, values in found.items()}
        return {problem: values for problem, values in kept.items() if len(values)}

    def scores(self, runs: Sequence[Run], measure: str) -> Scores | None:
        """Scores of runs; ``None`` where the measure is undefined in all of them."""
        values = self.values(runs, measure)
        return scores_of([*values.values()]) if values else None


def is_experiment(out: Path) -> bool:
    """Whether a folder is that of an experiment, begun at least."""
    return (out / EXPERIMENT).is_file()


def save(experiment: Experiment, cells: Sequence[Cell], found: Mapping[str, Any]) -> None:
    """Write what an experiment is into its folder.

    Raises
    ------
    InvalidInput
        If the folder is that of an experiment with cells that this one has not.
    """
    path = experiment.out / EXPERIMENT
    folders = [cell.folder for cell in cells]
    if path.exists():
        given = read_json(path)
        with reading(path):
            others = {each["folder"] for each in given["cells"]} - set(folders)
        if others:
            raise InvalidInput(
                f"out must hold no other experiment, got {experiment.out}, which has "
                f"{len(others)} cells that are not in this grid, {min(others)} for example; choose "
                "another out (--out), or move it away"
            )
    content = {
        "format": FORMAT,
        "name": experiment.name,
        "axes": {axis: [each.label for each in v] for axis, v in experiment.levels().items()},
        "problems": list(experiment.problems),
        "search": dict(found),
        "cells": [
            {"folder": cell.folder, "levels": dict(cell.levels), "seed": cell.seed}
            for cell in cells
        ],
    }
    with written(path) as part:
        part.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def _run(folder: Path, levels: Mapping[str, str], seed: int) -> Run | None:
    """The result in a folder, if it is that of the cell there."""
    if not (folder / RESULT).is_file() or not (folder / CELL).is_file():
        return None
    given, cell = read_json(folder / RESULT), read_json(folder / CELL)
    identity = {name: cell[name] for name in IDENTITY if name in cell}
    if given.get("cell") != digest_of(identity):
        return None
    with reading(folder / RESULT):
        numbers = dict(_numbers(given["evaluation"]))
        versions = {name: str(version) for name, version in given["versions"].items()}
        revision = None if given["revision"] is None else str(given["revision"])
    return Run(
        levels=levels,
        seed=seed,
        numbers=numbers,
        curves=_curves(folder / CURVES),
        versions=versions,
        revision=revision,
    )


def _numbers(evaluation: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """Numbers of an evaluation; those of a list, one an agent for example, as ``name_0``, …."""
    for name, value in evaluation.items():
        if isinstance(value, list):
            yield from _numbers({f"{name}_{i}": each for i, each in enumerate(value)})
        elif value is None or isinstance(value, int | float):
            yield name, nan if value is None else float(value)


def _curves(path: Path) -> list[Row]:
    if not path.is_file():
        return []
    with reading(path), path.open(newline="", encoding="utf-8") as file:
        rows = [
            {name: float(text) for name, text in row.items() if text}
            for row in csv.DictReader(file)
        ]
    return [{name: x for name, x in row.items() if isfinite(x)} for row in rows]
