"""Writing of a report: its page, its pictures and a table of all runs, in one folder."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import MissingExtra
from coopenv.files import written

from . import pictures
from .measures import SUCCESS
from .page import Estimates, estimates_of, front_of, page_of
from .results import Results, Setting

FOLDER, PAGE, TABLE = "report", "report.md", "runs"


def write_report(results: Results, out: Path) -> list[str]:
    """Write the report of what is finished into ``out/report``; the names of its files.

    Without pyarrow the table of runs is CSV, and without matplotlib there are no pictures; the
    page says so. It holds no time of day, so that equal results give equal reports.
    """
    folder = report_folder(out)
    estimates = estimates_of(results)
    table = _save_runs(results, folder)
    drawn, why = _draw(results, estimates, folder)
    page = page_of(results, estimates, table=table, drawn=drawn, why=why)
    with written(folder / PAGE) as part:
        part.write_text(page, encoding="utf-8")
    return [f"{FOLDER}/{name}" for name in (PAGE, *drawn, table)]


def report_folder(out: Path) -> Path:
    """Where the report of an experiment lies."""
    return out / FOLDER


def _draw(
    results: Results, estimates: Mapping[Setting, Estimates], folder: Path
) -> tuple[list[str], str | None]:
    """Draw the pictures; their names, and why there are none."""
    groups, front = results.by_setting(), front_of(estimates)
    titles = {setting: results.title(setting) for setting in groups}
    success = {
        titles[setting]: scores
        for setting, runs in groups.items()
        if (scores := results.scores(runs, SUCCESS)) is not None
    }
    curves = {
        titles[setting]: [
            [run.curves for run in each] for each in results.by_problem(runs).values()
        ]
        for setting, runs in groups.items()
        if any(len(row) > 1 for run in runs for row in run.curves)  # an episode ended
    }
    named = {titles[setting]: found for setting, found in estimates.items()}
    draws: dict[str, Callable[[Path], None]] = {
        "intervals.png": partial(pictures.draw_intervals, named),
        "profiles.png": partial(pictures.draw_profiles, success),
    }
    if curves:
        draws["curves.png"] = partial(pictures.draw_curves, curves)
    if front:
        ends = [titles[setting] for setting in front]
        draws["pareto.png"] = partial(pictures.draw_pareto, named, ends)
    try:
        for name, draw in draws.items():
            draw(folder / name)
    except MissingExtra as error:
        return [], str(error)
    return [*draws], None


def _save_runs(results: Results, folder: Path) -> str:
    """Write all runs as Parquet, or as CSV where pyarrow is missing; the name of the file."""
    names = [*dict.fromkeys(name for run in results.runs for name in run.numbers)]
    names = [name for name in names if name != "seed"]  # of the evaluation
    columns: dict[str, list[Any]] = {
        **{axis: [run.levels[axis] for run in results.runs] for axis in results.axes},
        "seed": [run.seed for run in results.runs],
        **{name: [run.numbers.get(name, np.nan) for run in results.runs] for name in names},
    }
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        with written(folder / f"{TABLE}.csv") as part:
            rows = [columns.keys(), *zip(*columns.values(), strict=True)]
            part.write_text("".join(f"{','.join(map(str, row))}\n" for row in rows))
        return f"{TABLE}.csv"
    with written(folder / f"{TABLE}.parquet") as part:
        parquet.write_table(pa.table(columns), part)
    return f"{TABLE}.parquet"
