"""``coopenv warmup``: compile everything ahead of time."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Warmup:
    """Compile everything for this processor, so that no later process has to.

    It takes minutes, once: for the image of a container, for example. NUMBA_CACHE_DIR names the
    folder.
    """

    def run(self) -> None:
        """Compile, showing what, and say where it is kept."""
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        from coopenv.warming import warmup

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
        with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
            bar = progress.add_task("")

            def show(number: int, total: int, name: str) -> None:
                progress.update(bar, completed=number, total=total, description=name)

            kernels, seconds, cache = warmup(show)
        place = "kept nowhere, since no folder can be written" if cache is None else f"in {cache}"
        print(f"{kernels} functions compiled in {seconds:.0f} s of processor time; {place}")
