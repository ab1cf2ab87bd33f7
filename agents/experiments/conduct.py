"""An experiment from beginning to end: its search, its cells, its report."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from coopenv.arrays import whole
from coopenv.errors import InvalidInput
from coopenv.files import locked, require_folder

from ..algorithms.recipes import require_installed
from .cell import Cell
from .grid import Experiment
from .nodes import AT_A_TIME, Nodes, Spread
from .report import Results, is_experiment, report_folder, save, write_report
from .run import Launch, Show, run_cells
from .search import Search


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of an experiment."""

    cells: int
    failures: Mapping[str, str]
    """Folder of a cell -> why it failed."""
    results: Results
    files: list[str]
    """Of the report."""


def conduct(
    experiment: Experiment,
    *,
    search: Search | None = None,
    tune: int = 0,
    workers: int | None = None,
    show: Show | None = None,
    launch: Launch | None = None,
    nodes: Nodes | None = None,
) -> Outcome:
    """Run what is not yet finished of an experiment, and write its report.

    The same call after an interruption, or a kill, goes on: cells that are finished are kept, and
    those that failed are tried again. More levels and more seeds may be added to the grid.

    Parameters
    ----------
    experiment
        All of it is checked before the first cell runs.
    search
        Over settings of the algorithms that learn, before the grid.
    tune
        Trials of the search for each; 0: none.
    workers
        Cells at a time; ``None``: one a core, or as many as nodes take.
    show
        Told of the progress, of each trial of a search and then of the grid.
    launch
        How a cell is worked on; by default in a process of its own.
    nodes
        Machines that work on the cells in place of this one; `coopenv.agents.experiments.joined`
        joins those of a Ray cluster.

    Returns
    -------
    What came of it; cells that failed did not stop the others.

    Raises
    ------
    InvalidInput, UnknownName
        If the experiment breaks a rule, or its folder holds something else.
    """
    check(experiment, search=search, tune=tune, workers=workers)
    require_folder(experiment.out)
    with locked(experiment.out):
        _require_no_other_report(experiment.out)

        def run(cells: list[Cell], out: Path) -> Mapping[str, str]:
            if nodes is None:
                return run_cells(cells, out, workers=workers, launch=launch, show=show)
            most = AT_A_TIME if workers is None else workers
            return run_cells(cells, out, workers=most, launch=Spread(nodes), show=show)

        found = {}
        if tune and search is not None:
            experiment, found = search.run(experiment, tune, run)
        cells = experiment.cells()
        for cell in cells:
            cell.check(experiment.out / cell.folder)
        save(experiment, cells, found)
        failures = run(cells, experiment.out)
        results = Results.load(experiment.out)
        files = write_report(results, experiment.out) if results.runs else []
    return Outcome(cells=len(cells), failures=failures, results=results, files=files)


def check(
    experiment: Experiment,
    *,
    search: Search | None = None,
    tune: int = 0,
    workers: int | None = None,
) -> list[Cell]:
    """Raise what `conduct` would of its arguments, before anything is written; return the cells."""
    cells = experiment.cells()
    if workers is not None:
        whole(workers, "workers", at_least=1)
    if whole(tune, "tune", at_least=0) and (search is None or not search.algorithms(experiment)):
        raise InvalidInput(
            f"tune must come with a space of settings of an algorithm of the grid, got {tune} "
            "without one; write [search.space] into the file, or [search.space.sac] for SAC's"
        )
    for algorithm in dict.fromkeys(cell.algorithm for cell in cells):
        require_installed(algorithm)
    return cells


def _require_no_other_report(out: Path) -> None:
    """Raise `InvalidInput` if the report would be written among files that no experiment wrote."""
    folder = report_folder(out)
    if not is_experiment(out) and folder.exists():
        raise InvalidInput(
            f"out must hold no other report, got {out}, where {folder.name} is there and no "
            "experiment is; choose another out (--out), or move it away"
        )
