"""Curves of a cell on Weights & Biases, where its experiment names a project."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from coopenv.errors import MissingPackage

from .cell import Cell

Track = Callable[[dict[str, float]], None]
"""Called with numbers by name; ``steps`` is where they stand."""


@contextmanager
def tracked(cell: Cell, folder: Path) -> Iterator[Track]:
    """What to call with the rows of a cell's curves; it does nothing without a project.

    A run of a setting is called by it and its seed, and grouped by it.

    Raises
    ------
    MissingPackage
        If there is a project and the package is not installed.
    """
    if cell.wandb is None:
        yield lambda row: None
        return
    wandb: Any = found()
    run = wandb.init(
        project=cell.wandb,
        group=cell.setting,
        name=f"{cell.setting}, seed {cell.seed}",
        config=cell.identity(),
        dir=str(folder),
    )
    try:
        yield run.log
    finally:
        run.finish()


def found() -> Any:
    """The package.

    Raises
    ------
    MissingPackage
        If it is not installed.
    """
    try:
        import wandb  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingPackage("tracking on Weights & Biases", "wandb", ["wandb"]) from error
    return wandb
