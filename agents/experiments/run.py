"""Running of cells: several processes at a time, each of one cell; what is finished is kept."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field
from inspect import getfile
from pathlib import Path
from tempfile import TemporaryFile
from threading import Lock
from typing import Any, Protocol, runtime_checkable

from coopenv.arrays import whole
from coopenv.compiled.parallel import cores
from coopenv.errors import CoopenvError
from coopenv.files import locked, sweep, written

from .cell import FAILURE, Cell

WORK = "coopenv.agents.experiments.work"  # module that a process runs
ONE = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
LOOK = 0.2  # [s] between two looks at what the processes did, so that signals are heard
INTERRUPTED = "interrupted"  # why a cell is not done that did not fail
GRACE = 40.0  # [s] for interrupted processes to end
EPISODE = 50  # control steps that an episode of an evaluation counts for in the progress


class Show(Protocol):
    """What is told of the progress."""

    def __call__(self, *, done: float, total: float, cells: int, of: int) -> None:
        """``done`` and ``total`` in control steps over all cells; ``cells`` finished ``of`` all."""
        ...


class Launch(Protocol):
    """How a cell is worked on."""

    def __call__(self, folder: Path, report: Callable[[dict[str, Any]], None]) -> str | None:
        """Work there until it is done; why it failed, or None."""
        ...


@runtime_checkable
class Stoppable(Protocol):
    """A `Launch` whose work goes on by itself has this as well."""

    def stop(self) -> None:
        """End all that it has begun, and begin no more."""
        ...


@dataclass(slots=True)
class Processes:
    """Starts a process for every cell, and can end them all."""

    _running: set[subprocess.Popen] = field(default_factory=set)
    _lock: Lock = field(default_factory=Lock)
    _stopped: bool = False

    def __call__(self, folder: Path, report: Callable[[dict[str, Any]], None]) -> str | None:
        """Have a process work in the folder, reporting what it tells; why it failed, or None."""
        with TemporaryFile() as errors:
            with self._lock:
                if self._stopped:
                    return INTERRUPTED
                process = _begin(folder, errors)
                self._running.add(process)
            failed = None
            try:
                assert process.stdout is not None
                for line in process.stdout:
                    said = _read(line)
                    failed = said.get("failed", failed)
                    report(said)
                code = process.wait()
            finally:
                with self._lock:
                    self._running.discard(process)
                    _close(process)
            if code == 0:
                return None
            if self._stopped:
                return INTERRUPTED
            errors.seek(0)
            return failed or _why(code, errors.read().decode(errors="replace"))

    def stop(self) -> None:
        """Interrupt all, as the end of this process would; kill those that do not end."""
        with self._lock:
            self._stopped = True
            running = [*self._running]
            for process in running:
                _close(process)
        end = time.monotonic() + GRACE
        for process in running:
            try:
                process.wait(max(0.0, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()


def run_cells(
    cells: Sequence[Cell],
    out: Path,
    *,
    workers: int | None = None,
    launch: Launch | None = None,
    show: Show | None = None,
) -> dict[str, str]:
    """Run all cells that are not finished, each in its folder below ``out``.

    Whatever is in the way is found before the first of them runs.

    Parameters
    ----------
    cells
        Of the experiment.
    out
        Its folder, locked meanwhile.
    workers
        Cells at a time; ``None``: one a core.
    launch
        How a cell is worked on; by default in a process of its own.
    show
        Called now and then.

    Returns
    -------
    Folder of a cell -> why it failed, for those that did; ``failure.txt`` in it says so too.

    Raises
    ------
    InvalidInput
        If a folder holds something else, or another process is at work in ``out``.
    """
    workers = cores() if workers is None else whole(workers, "workers", at_least=1)
    with locked(out):
        for cell in cells:
            cell.check(out / cell.folder)
        waiting = [cell for cell in cells if not cell.is_finished(out / cell.folder)]
        tally = _Tally(cells, waiting, show)
        worker = Processes() if launch is None else launch
        pool = ThreadPoolExecutor(workers)
        try:
            return _all_done(pool, waiting, out, worker, tally)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            if isinstance(worker, Stoppable):
                worker.stop()
            pool.shutdown()


def _all_done(
    pool: ThreadPoolExecutor, waiting: Sequence[Cell], out: Path, launch: Launch, tally: "_Tally"
) -> dict[str, str]:
    futures: dict[Future, Cell] = {}
    for cell in waiting:
        futures[pool.submit(_one, cell, out, launch, tally)] = cell
    failures: dict[str, str] = {}
    pending = set(futures)
    while pending:
        done, pending = wait(pending, LOOK, FIRST_COMPLETED)
        for future in done:
            why = future.result()
            if why is not None:
                failures[futures[future].folder] = why
        tally.tell()
    return {cell.folder: failures[cell.folder] for cell in waiting if cell.folder in failures}


def _one(cell: Cell, out: Path, launch: Launch, tally: "_Tally") -> str | None:
    """Run one cell; why it failed."""
    folder = out / cell.folder
    placed = cell.at(folder)
    folder.mkdir(parents=True, exist_ok=True)
    sweep(folder)
    placed.save(folder)
    why = launch(folder, lambda said: tally.add(cell, said.get("steps")))
    if why is None:
        (folder / FAILURE).unlink(missing_ok=True)
        tally.finish(cell)
    elif why != INTERRUPTED:
        with written(folder / FAILURE) as part:
            part.write_text(f"{why.strip()}\n", encoding="utf-8")
        tally.give_up(cell)
    return why and why.strip().splitlines()[-1]


@dataclass(slots=True)
class _Tally:
    """How far each cell has come, in control steps."""

    cells: Sequence[Cell]
    waiting: Sequence[Cell]
    show: Show | None
    _done: dict[str, float] = field(init=False)
    _finished: int = field(init=False)

    def __post_init__(self) -> None:
        self._done = {cell.folder: 0.0 for cell in self.waiting}
        self._finished = len(self.cells) - len(self.waiting)

    def add(self, cell: Cell, steps: float | None) -> None:
        if steps is not None:
            self._done[cell.folder] = min(float(steps), cell.steps)

    def finish(self, cell: Cell) -> None:
        self._done[cell.folder] = _size(cell)
        self._finished += 1

    def give_up(self, cell: Cell) -> None:
        """Nothing is left to be done for it now."""
        self._done[cell.folder] = _size(cell)

    def tell(self) -> None:
        if self.show is not None:
            self.show(
                done=sum(self._done.values()),
                total=sum(map(_size, self.waiting)),
                cells=self._finished,
                of=len(self.cells),
            )


def _size(cell: Cell) -> float:
    return cell.steps + EPISODE * cell.episodes


def _begin(folder: Path, errors: Any) -> subprocess.Popen:
    home = str(Path(getfile(CoopenvError)).resolve().parents[1])  # of the package
    path = os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen(
        [sys.executable, "-m", WORK, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        env={**os.environ, **ONE, "PYTHONPATH": path},
        start_new_session=True,  # Ctrl-C comes to the experiment alone, which ends the others
    )


def _close(process: subprocess.Popen) -> None:
    """End its standard input, at which it ends."""
    with suppress(OSError):
        if process.stdin is not None:
            process.stdin.close()


def _read(line: bytes) -> dict[str, Any]:
    """What a process tells in a line; nothing where a library printed something."""
    try:
        said = json.loads(line)
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


def _why(code: int, errors: str) -> str:
    """Why a process failed that did not say so."""
    ended = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
    return f"{errors.strip()}\n{ended}" if not errors.strip() or code < 0 else errors.strip()
