"""Progress of a grid of trainings: a bar on a terminal, lines in a log."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from time import monotonic
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


@contextmanager
def bar_over(console: "Console") -> Iterator[Callable[..., None]]:
    """A bar over the control steps of all cells, with the time that is left."""
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns: tuple[Any, ...] = (
        TextColumn("{task.fields[cells]} of {task.fields[of]} cells"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=console, speed_estimate_period=600.0)
    with bar:
        task = bar.add_task("", total=None, cells=0, of="?")
        plan: list[float] = []

        def show(*, done: float, total: float, cells: int, of: int) -> None:
            if plan != [total]:
                plan[:] = [total]
                bar.reset(task, total=total)
            bar.update(task, completed=done, total=total, cells=cells, of=of)

        yield show


@contextmanager
def lines_over(console: "Console") -> Iterator[Callable[..., None]]:
    """A line whenever a cell has finished, with the time that is left: for a file of a log."""
    begun, told = monotonic(), [-1]

    def show(*, done: float, total: float, cells: int, of: int) -> None:
        if told == [cells]:
            return
        told[:] = [cells]
        passed = monotonic() - begun
        left = f", {_duration(passed * (total - done) / done)} left" if 0 < done < total else ""
        console.print(f"{cells} of {of} cells{left}", highlight=False)

    yield show


def _duration(seconds: float) -> str:
    """As hours, minutes and seconds."""
    return str(timedelta(seconds=round(seconds)))
