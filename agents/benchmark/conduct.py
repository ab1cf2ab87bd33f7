"""A benchmark from beginning to end: what is to be run, checked before; its episodes; summaries."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from coopenv.errors import InvalidInput, UnknownName
from coopenv.files import locked, require_folder

from ..evaluate import run_episodes
from ..experiments.revision import revision
from ..provenance import versions
from ..training.threads import torch_threads
from . import measures, scenario
from .entries import TASK, Entry
from .meter import Meter
from .rehearsal import rehearse, wrong
from .scenario import Scenario, Suite
from .summary import Result, Summary, read_summary
from .trained import Trained


class Show(Protocol):
    """Told of the progress, in episodes and in cells: scenarios times entries."""

    def __call__(self, *, done: float, total: float, cells: int, of: int) -> None:
        """So much is done of it."""
        ...


@dataclass(frozen=True, kw_only=True)
class Cell:
    """An entry in a scenario of a suite."""

    entry: Entry
    suite: Suite
    scenario: Scenario
    trained: Trained | None = None
    """What is told of the training behind the entry."""

    def file(self, out: Path) -> Path:
        """Of the summary it belongs to."""
        return out / self.suite.label / f"{self.entry.name}.json"


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is to be run, all of it tried; and what cannot be."""

    cells: tuple[Cell, ...]
    left_out: Mapping[str, str]
    """Entry and scenario -> why the one cannot act in the other."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What came of a benchmark."""

    summaries: Mapping[Path, Summary]
    left_out: Mapping[str, str] = field(default_factory=dict)


def plan(entries: Sequence[Entry], suites: Sequence[Suite], only: Sequence[str] = ()) -> Plan:
    """Try every entry in every scenario for a step; nothing is written.

    Parameters
    ----------
    entries
        What is entered.
    suites
        In which.
    only
        Names of scenarios; all of the suites without one.

    Raises
    ------
    InvalidInput, UnknownName
        If there is no such scenario, an entry acts wrongly in one, or says that it cannot act in
        one that is named, or in any at all; or if what is told of its training cannot be.
    """
    names = [entry.name for entry in entries]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(
                f"entries must have names of their own, got {name!r} twice; enter them one by one, "
                "with --name"
            )
    cells, left_out = [], {}
    chosen = [*_chosen(suites, only)]
    for entry in entries:
        whys = []
        for suite, one in chosen:
            why = rehearse(entry, one)
            if why is None:
                trained = entry.trained(one)
                cells.append(Cell(entry=entry, suite=suite, scenario=one, trained=trained))
                continue
            whys.append(why)
            left_out[f"{entry.name} in {suite.name}: {one.name}"] = str(why)
        if len(whys) == len(chosen) or (only and whys):
            raise whys[0]
    return Plan(cells=tuple(cells), left_out=left_out)


def conduct(planned: Plan, out: Path, show: Show | None = None) -> Outcome:
    """Run what is not yet finished of a plan, and keep each result in a summary as it comes.

    The same call after an interruption, or a kill, goes on: what is finished is kept. What is told
    of a training now stands in place of what was told before.

    Parameters
    ----------
    planned
        What `plan` made.
    out
        Folder; summaries lie in it by suite and entry.
    show
        Told of the progress.

    Raises
    ------
    InvalidInput
        If the folder holds results of something else under the name of an entry.
    """
    require_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    cells = planned.cells
    total = sum(cell.suite.episodes for cell in cells)
    with locked(out), torch_threads(1):
        kept = {cell.file(out): _kept(cell, out) for cell in cells}
        for cell in cells:
            _require_same(cell, kept[cell.file(out)], out)
        for number, cell in enumerate(cells):
            done = sum(each.suite.episodes for each in cells[:number])
            _tell(show, done, total, number, len(cells))
            path = cell.file(out)
            found = _finished(cell, kept[path])
            if found != kept[path].results.get(cell.scenario.name):
                kept[path] = kept[path].with_result(cell.scenario.name, found)
                kept[path].save(path)
        _tell(show, total, total, len(cells), len(cells))
    return Outcome(summaries=kept, left_out=planned.left_out)


def _finished(cell: Cell, summary: Summary) -> Result:
    """The result that is there, with what is told of the training now; or a new one."""
    kept = summary.results.get(cell.scenario.name)
    if kept is None or kept.digest != cell.suite.digest_of(cell.scenario):
        return _tried(cell)
    return replace(kept, trained=kept.trained if cell.trained is None else cell.trained)


def _tried(cell: Cell) -> Result:
    """`run` a cell; what breaks off in it says whose it is."""
    try:
        return run(cell)
    except Exception as error:
        raise wrong(cell.entry, cell.scenario, error) from error


def run(cell: Cell) -> Result:
    """The episodes of a cell: at the tolerances of its environment, at half and at double."""
    entry, suite, one = cell.entry, cell.suite, cell.scenario
    episodes: dict[str, Any] = {"episodes": suite.episodes, "seed": suite.evaluation}
    meter = Meter(one.config)
    seen = run_episodes(entry.policy(one), one.config, **episodes, recorder=meter)
    others = {
        name: measures.rates(run_episodes(entry.policy(one), one.within(factor), **episodes))
        for name, factor in (
            (measures.HALVED, scenario.HALVED),
            (measures.DOUBLED, scenario.DOUBLED),
        )
    }
    means = measures.means(seen, meter.means(), dt=one.config.dt, learner=one.config.learners[0])
    found = {measures.SUCCESS: measures.rates(seen), **others, **means}
    return Result(
        digest=suite.digest_of(one),
        sha256=entry.digest(one),
        measures={name: found[name] for name in measures.MEASURES},
        trained=cell.trained,
    )


def _chosen(suites: Sequence[Suite], only: Sequence[str]) -> Iterator[tuple[Suite, Scenario]]:
    every = [(suite, one) for suite in suites for one in suite.scenarios]
    known = [one.name for _, one in every]
    for name in only:
        if name not in known:
            raise UnknownName("scenario", name, known)
    return ((suite, one) for suite, one in every if not only or one.name in only)


def _kept(cell: Cell, out: Path) -> Summary:
    """The summary that is there, or an empty one."""
    path = cell.file(out)
    if path.is_file():
        return read_summary(path)
    return Summary(
        suite=cell.suite.name,
        version=cell.suite.version,
        entry=cell.entry.name,
        given=cell.entry.given,
        sees=cell.entry.sees,
        versions=versions(),
        revision=revision(),
    )


def _require_same(cell: Cell, summary: Summary, out: Path) -> None:
    """Raise `InvalidInput` unless what is there is of the same entry."""
    mine = cell.entry.digest(cell.scenario)
    theirs = {
        summary.results[one.name].sha256
        for one in cell.suite.scenarios
        if one.name in summary.results
        and (TASK not in cell.entry.given or one.env == cell.scenario.env)
    }
    if cell.entry.given != summary.given or not theirs <= {mine}:
        raise InvalidInput(
            f"out must hold nothing else under the name {cell.entry.name!r}, got "
            f"{cell.file(out)}, which is of {summary.given!r} as it was then; give another --name "
            "or --out, or remove it"
        )


def _tell(show: Show | None, done: float, total: float, cells: int, of: int) -> None:
    if show is not None:
        show(done=done, total=total, cells=cells, of=of)
