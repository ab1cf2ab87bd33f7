"""What the process of one cell does: train, evaluate, write the result. See `run`.

python -m coopenv.agents.experiments.work FOLDER    # which holds a cell.json
"""

import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, replace
from math import isfinite
from pathlib import Path
from threading import Thread
from typing import Any

from coopenv.errors import CoopenvError, FileTrouble, InvalidInput
from coopenv.files import locked, written

from ..evaluate import Evaluation, evaluate
from ..policy import Policy, RandomPolicy
from ..provenance import versions
from .cell import FORMAT, RESULT, Cell
from .revision import revision
from .tracking import tracked

PATIENCE = 60.0  # [s] for the process of a killed experiment to leave the folder
PAUSE = 0.2  # [s] between two looks
LAST = 30.0  # [s] after an interruption in which a process may end by itself

Report = Callable[[dict[str, Any]], None]
"""Called with ``{"steps": control steps done}``."""


def work(folder: Path, report: Report = lambda said: None) -> Evaluation:
    """Do what a cell's folder says, and leave ``evaluation.json`` there.

    A cell that learns is a run of `coopenv.agents.train.train` in the same folder, or of
    `coopenv.agents.algorithms.train.train_by`, which begins anew whatever ``continues`` says.

    Raises
    ------
    CoopenvError
        If the run is refused, diverges or cannot be written.
    """
    cell = Cell.load(folder)
    with _alone(folder), tracked(cell, folder) as track:
        policy = _policy(cell, folder, report, track)
        seen = evaluate(
            policy,
            cell.environment,
            episodes=cell.episodes,
            seed=cell.evaluation,
            name=cell.algorithm,
        )
        track(_numbers(seen))
        _save(seen, cell, folder)
    return seen


def main() -> None:
    """Work in the folder that the command names, telling progress on standard output.

    It ends when standard input does, that is when the experiment's process ends, however it ends.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    Thread(target=_end_with_parent, daemon=True).start()
    try:
        work(Path(sys.argv[1]), tell)
    except CoopenvError as error:
        tell({"failed": str(error)})
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
    tell({"done": True})


def _policy(
    cell: Cell, folder: Path, report: Report, track: Callable[[dict[str, float]], None]
) -> Policy:
    """The policy of a cell, trained if it learns."""
    if cell.algorithm == "random":
        return RandomPolicy(cell.environment, seed=cell.seed)
    if cell.algorithm == "scripted":
        from ..controllers import find_controller

        return find_controller(cell.environment)

    def told(row: dict[str, float]) -> None:
        report({"steps": row["steps"]})
        track(row)

    if cell.recipe is not None:
        from ..algorithms.train import train_by

        placed = replace(cell.training, out=folder)
        return train_by(cell.recipe, placed, environment=cell.environment, report=told)
    from ..train import train
    from ..training.checkpoint import POLICY

    anew = not cell.continues and not (folder / POLICY).exists()
    return train(
        replace(cell.training, fresh=anew, out=folder),
        environment=cell.environment,
        report=told,
        tell=lambda sentence: print(sentence, file=sys.stderr),
    )


def _save(seen: Evaluation, cell: Cell, folder: Path) -> None:
    content = {
        "format": FORMAT,
        "cell": cell.digest(),
        "versions": versions(),
        "revision": revision(),
        "evaluation": _without_nan(asdict(seen)),
    }
    with written(folder / RESULT) as part:
        part.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Have the folder alone; the process of an experiment that was killed may still be leaving."""
    end = time.monotonic() + PATIENCE
    with ExitStack() as stack:
        while True:
            try:
                stack.enter_context(locked(folder))
                break
            except FileTrouble:
                raise
            except InvalidInput:
                if time.monotonic() > end:
                    raise
                time.sleep(PAUSE)
        yield


def _end_with_parent() -> None:
    """Wait for the end of standard input; then interrupt the main thread, and at last exit.

    It is read past Python's buffer, whose lock this thread would still have at the end.
    """
    while os.read(sys.stdin.fileno(), 1):
        pass
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(LAST)
    os._exit(130)


def tell(said: dict[str, Any]) -> None:
    """Print a line of JSON, at once."""
    print(json.dumps(said), flush=True)


def _numbers(seen: Evaluation) -> dict[str, float]:
    """The single numbers of an evaluation, as they are tracked."""
    return {
        f"evaluation/{name}": float(value)
        for name, value in asdict(seen).items()
        if isinstance(value, int | float) and isfinite(value)
    }


def _without_nan(value: Any) -> Any:
    """NaN is no JSON: null instead."""
    if isinstance(value, dict):
        return {name: _without_nan(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(entry) for entry in value]
    return None if value != value else value


if __name__ == "__main__":
    main()
