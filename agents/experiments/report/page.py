"""Page of a report: Markdown tables of settings, comparisons and the Pareto front."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray

from .measures import DISAGREEMENT, MEASURES, SUCCESS, TIME, Measure
from .results import Results, Run, Setting
from .statistics import (
    Scores,
    bootstrap_interval,
    interquartile_mean,
    optimality_gap,
    pareto_front,
    probability_of_improvement,
)

COMPARED = (SUCCESS, TIME, DISAGREEMENT)  # with the first setting
UNDEFINED = "–"

Estimates = Mapping[str, "Estimate | None"]
"""Measure -> estimate; None where it is undefined in all runs."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A statistic with its 95 % interval."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, statistic: Callable[..., FloatArray], *groups: Scores) -> "Estimate":
        """That of groups of scores, by a stratified bootstrap."""
        low, high = bootstrap_interval(statistic, *groups)
        return cls(float(statistic(*groups)), float(low), float(high))

    def __str__(self) -> str:
        return f"{self.value:.3g} [{self.low:.3g}, {self.high:.3g}]"


def estimates_of(results: Results) -> dict[Setting, Estimates]:
    """Interquartile means of all measures, by setting."""
    return {
        setting: {name: _estimate(results, runs, name) for name in MEASURES}
        for setting, runs in results.by_setting().items()
    }


def front_of(estimates: Mapping[Setting, Estimates]) -> list[Setting]:
    """Settings that no other beats in both time and disagreement, by time."""
    points = {
        setting: (time.value, waste.value)
        for setting, found in estimates.items()
        if (time := found[TIME]) is not None and (waste := found[DISAGREEMENT]) is not None
    }
    if not points:
        return []
    settings = [*points]
    rows = pareto_front(np.array([*points.values()]))
    return sorted((settings[row] for row in rows), key=lambda setting: points[setting])


def page_of(
    results: Results,
    estimates: Mapping[Setting, Estimates],
    *,
    table: str,
    drawn: Sequence[str],
    why: str | None,
) -> str:
    """The page in Markdown.

    Parameters
    ----------
    results
        Of the experiment.
    estimates
        Of `estimates_of`.
    table
        Name of the file with all runs.
    drawn
        Names of the pictures.
    why
        There are none, if so.
    """
    groups = results.by_setting()
    titles = {setting: results.title(setting) for setting in groups}
    lines = [
        *_head(results, table, why),
        *_settings(results, groups, titles, estimates),
        *_compared(results, groups, titles),
        *_front_part(titles, estimates, front_of(estimates)),
        *_pictures(drawn),
        *_method(),
    ]
    return "\n".join(lines) + "\n"


def summary(results: Results) -> tuple[list[str], list[list[str]]]:
    """Head and rows of a table for a terminal: a few measures of each setting."""
    head = ["setting", "runs", *(MEASURES[name].title for name in COMPARED)]
    rows = [
        [
            results.title(setting),
            str(len(runs)),
            *(_cell(_estimate(results, runs, name), results, runs, name) for name in COMPARED),
        ]
        for setting, runs in results.by_setting().items()
    ]
    return head, rows


def _estimate(results: Results, runs: Sequence[Run], measure: str) -> Estimate | None:
    scores = results.scores(runs, measure)
    return None if scores is None else Estimate.of(interquartile_mean, scores)


def _head(results: Results, table: str, why: str | None) -> list[str]:
    finished, cells = len(results.runs), len(results.runs) + len(results.waiting)
    lines = [f"# {results.name}", "", f"{finished} of {cells} cells are finished."]
    for folder, reason in results.failed.items():
        lines += [f"- failed: `{folder}`: {reason}"]
    left = len(results.waiting) - len(results.failed)
    if left:
        lines += [f"- {left} have not run to their end"]
    for name, found in results.settings_found.items():
        said = ", ".join(f"{key} = {value}" for key, value in found.items())
        lines += [f"- settings of {name}, found by the search: {said}"]
    for what, found in _made_with(results.runs):
        note = "" if len(found) == 1 else ", **not the same in all cells**"
        lines += [f"- {what}: {'; '.join(found)}{note}"]
    lines += [f"- all runs, with all that was measured: `{table}`"]
    return [*lines, *([f"- no pictures: {why}"] if why else []), ""]


def _made_with(runs: Sequence[Run]) -> list[tuple[str, list[str]]]:
    """Versions and revisions, each once."""
    versions = [", ".join(f"{name} {v}" for name, v in run.versions.items()) for run in runs]
    revisions = [run.revision or "not known" for run in runs]
    return [("versions", [*dict.fromkeys(versions)]), ("revision", [*dict.fromkeys(revisions)])]


def _settings(
    results: Results,
    groups: Mapping[Setting, Sequence[Run]],
    titles: Mapping[Setting, str],
    estimates: Mapping[Setting, Estimates],
) -> list[str]:
    head = ["setting", "runs", "problems", *(measure.title for measure in MEASURES.values())]
    rows = []
    for setting, runs in groups.items():
        scores = results.scores(runs, SUCCESS)
        gap = UNDEFINED if scores is None else f"{optimality_gap(scores):.3g}"
        counts = [str(len(runs)), str(len(results.by_problem(runs)))]
        cells = [_cell(estimates[setting][name], results, runs, name) for name in MEASURES]
        rows.append([titles[setting], *counts, *cells, gap])
    return [
        "## Settings",
        "",
        "Interquartile mean over all runs of a setting, and its 95 % interval.",
        "",
        *_markdown([*head, "optimality gap of success"], rows),
        "",
    ]


def _cell(found: Estimate | None, results: Results, runs: Sequence[Run], measure: str) -> str:
    """An estimate, with the number of runs where it is not that of all."""
    if found is None:
        return UNDEFINED
    defined = sum(map(len, results.values(runs, measure).values()))
    return f"{found}" + (f" ({defined} runs)" if defined < len(runs) else "")


def _compared(
    results: Results, groups: Mapping[Setting, Sequence[Run]], titles: Mapping[Setting, str]
) -> list[str]:
    first, *others = groups
    if not others:
        return []
    measures = [MEASURES[name] for name in COMPARED]
    head = [
        "setting",
        *(f"{'more' if each.higher else 'less'} {each.label}" for each in measures),
    ]
    rows = [
        [
            titles[setting],
            *(_improvement(results, groups[setting], groups[first], each) for each in measures),
        ]
        for setting in others
    ]
    return [
        f"## Probability of improvement on {titles[first]}",
        "",
        "That a run of the setting has more success, or less time or waste, than one of the first "
        "setting, on the same problem; 0.5 is no difference.",
        "",
        *_markdown(head, rows),
        "",
    ]


def _improvement(
    results: Results, runs: Sequence[Run], others: Sequence[Run], measure: Measure
) -> str:
    mine, theirs = (results.values(each, measure.name) for each in (runs, others))
    common = [problem for problem in mine if problem in theirs]
    if not common:
        return UNDEFINED
    sides = [[side[problem] for problem in common] for side in (mine, theirs)]
    if not measure.higher:
        sides.reverse()
    return str(Estimate.of(probability_of_improvement, *sides))


def _front_part(
    titles: Mapping[Setting, str],
    estimates: Mapping[Setting, Estimates],
    front: Sequence[Setting],
) -> list[str]:
    if not front:
        return []
    names = (TIME, DISAGREEMENT, SUCCESS)
    rows = [
        [titles[setting], *(str(estimates[setting][name]) for name in names)] for setting in front
    ]
    return [
        "## Pareto front of time against disagreement",
        "",
        "Settings that no other beats in both. Time is that of successful episodes alone: read it "
        "beside the success.",
        "",
        *_markdown(["setting", *(MEASURES[name].title for name in names)], rows),
        "",
    ]


def _pictures(drawn: Sequence[str]) -> list[str]:
    said = {
        "intervals.png": "Interquartile means with their 95 % intervals",
        "profiles.png": "Performance profiles: part of the runs above each success",
        "curves.png": "Learning curves: interquartile means over runs, exploration noise included",
        "pareto.png": "Time against disagreement, and what no other setting beats",
    }
    return [line for name in drawn for line in (f"![{said[name]}]({name})", "")]


def _method() -> list[str]:
    return [
        "Interquartile mean, stratified bootstrap intervals (runs drawn within each problem), "
        "probability of improvement and performance profiles are those of Agarwal et al. 2021, "
        '"Deep reinforcement learning at the edge of the statistical precipice".',
    ]


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]
