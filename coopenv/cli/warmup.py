"""``coopenv warmup``: compile everything ahead of time."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from coopenv.options import Common


@dataclass(frozen=True, kw_only=True)
class Warmup:
    """Compile everything for this processor, so that no later process has to.

    It takes minutes, once: for the image of a container, for example. NUMBA_CACHE_DIR names the
    folder.
    """

    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv warmup",
        "NUMBA_CACHE_DIR=/opt/kernels coopenv warmup --json",
    )

    def run(self) -> dict[str, Any]:
        """Compile, showing what, and say where it is kept."""
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        from coopenv.warming import warmup

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
        with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
            bar = progress.add_task("")

            def show(number: int, total: int, name: str) -> None:
                progress.update(bar, completed=number, total=total, description=name)

            warmed = warmup(show)
        kernels, seconds, cache = warmed
        place = "kept nowhere, since no folder can be written" if cache is None else f"in {cache}"
        print(f"{kernels} functions compiled in {seconds:.0f} s of processor time; {place}")
        return warmed._asdict()
