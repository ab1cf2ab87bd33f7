"""``coopenv bench``: how fast it is on this machine, in about a minute."""

import platform
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from coopenv.agents.differences import described
from coopenv.agents.environment import EnvironmentChoice, find_config
from coopenv.arrays import positive, whole
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.options import Common

if TYPE_CHECKING:
    from rich.table import Table

    from coopenv.bench import SplitRate, StepRate
    from coopenv.config import TransportConfig

CALLS = 10_000  # of a control loop
LONGEST = 60.0  # [s] for a figure
STEP_COLUMNS = ("worlds", "threads", "steps/s", "a world and step [µs]", "processors [µs]")
SPLIT_COLUMNS = ("effectors", "at once", "samples/s", "a sample [µs]", "processors [µs]")
CALL_COLUMNS = ("loop", "median [µs]", "99.9 % [µs]", "worst [µs]", "processors [µs]")


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure on this machine: steps of an environment, decompositions, calls of a control loop.

    It takes about a minute, once everything is compiled. Figures are medians; where other programs
    run beside it, those of processors tell more than those of the clock.
    """

    environment: EnvironmentChoice = field(default_factory=EnvironmentChoice)
    num_worlds: tuple[int, ...] = (1, 16, 256, 1024)
    """Sizes of batches that are stepped."""
    threads: tuple[int, ...] = ()
    """With how many threads each; one, and as many as are taken by default, if left out."""
    seconds: float = 3.0
    """For each figure."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv bench",
        "coopenv bench --env coopenv/BeamLift-v0 --num-worlds 64 --threads 1 2 4",
        "coopenv bench --seconds 0.5 --json",
    )

    def run(self) -> dict[str, Any]:
        """Measure and print the tables."""
        try:
            from rich.console import Console
        except ImportError as error:
            raise MissingExtra("coopenv bench", "train") from error

        from coopenv.compiled.parallel.crew import cores

        config, seconds = self.environment.config(), self._checked()
        console, errors = Console(), Console(stderr=True)
        title, machine = self._title(config), {"processor": platform.machine(), "cores": cores()}
        said = f"{machine['processor']}, {machine['cores']} cores for this process"
        console.print(said, markup=False, highlight=False)
        with errors.status("measuring; what is not compiled yet is compiled first"):
            steps = list(self._steps(config, seconds))
            console.print(_table(title, STEP_COLUMNS, steps))
            splits = list(_splits(seconds))
            console.print(_table("Decompositions", SPLIT_COLUMNS, splits))
            calls = list(_calls())
            console.print(_table(f"A call among {CALLS:,}", CALL_COLUMNS, calls))
        return {
            "environment": title,
            "machine": machine,
            "steps": [rate._asdict() for rate in steps],
            "decompositions": [rate._asdict() for rate in splits],
            "calls": [dict(zip(CALL_KEYS, row, strict=True)) for row in calls],
        }

    def _checked(self) -> float:
        """The seconds, if all numbers can be."""
        from coopenv.stepping.worlds import MOST_THREADS, MOST_WORLDS

        if not self.num_worlds:
            raise InvalidInput("num_worlds must be at least one number, got none; for example 256")
        for value in self.num_worlds:
            whole(value, "num_worlds", at_least=1, at_most=MOST_WORLDS)
        for value in self.threads:
            whole(value, "threads", at_least=1, at_most=MOST_THREADS)
        seconds = positive(self.seconds, "seconds")
        if seconds > LONGEST:
            raise InvalidInput(
                f"seconds must be at most {LONGEST:g}, got {seconds:g}; they are those of one "
                "figure among many"
            )
        return seconds

    def _title(self, config: "TransportConfig") -> str:
        others = described(config, find_config(self.environment.env, {}))
        return f"{self.environment.env}{' with ' if others else ''}{', '.join(others)}"

    def _steps(self, config: "TransportConfig", seconds: float) -> "Iterator[StepRate]":
        from coopenv.bench import step_rate
        from coopenv.transport import Transport

        for worlds in dict.fromkeys(self.num_worlds):
            default = Transport(num_worlds=worlds, config=config)
            for threads in dict.fromkeys(self.threads or (1, default.threads)):
                core = Transport(num_worlds=worlds, config=config, threads=threads)
                yield step_rate(core, seconds)


def _splits(seconds: float) -> "Iterator[SplitRate]":
    from coopenv.bench import SPLITS, split_rate

    for effectors, batch in SPLITS:
        yield split_rate(effectors, batch, seconds)


CALL_KEYS = ("effectors", "median", "rare", "worst", "processor_median")  # [µs] but the first


def _calls() -> Iterator[tuple[str, float, float, float, float]]:
    """How long one call of a control loop takes: half of them, all but 0.1 %, all [µs]."""
    from coopenv.bench import times_of_calls
    from coopenv.bench.splits import GRIPS, drawn
    from coopenv.wrench import Decomposer

    for effectors, grips in GRIPS.items():
        times = times_of_calls(Decomposer(grips).compile(), drawn(grips, CALLS))
        middle, rare, worst = np.quantile(times.wall, (0.5, 0.999, 1.0)).tolist()
        yield effectors, middle, rare, worst, float(np.median(times.processor))


def _table(title: str, columns: tuple[str, ...], rows: Any) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    look: dict[str, Any] = {"box": SIMPLE_HEAD, "show_edge": False, "collapse_padding": True}
    made = Table(title=Text(f"\n{title}", "table.title"), title_justify="left", **look)
    for name in columns:
        made.add_column(name, justify="right", overflow="fold")
    for row in rows:
        made.add_row(*(_cell(value) for value in row))
    return made


def _cell(value: Any) -> str:
    """A word, a count, or a number with three digits at least."""
    if isinstance(value, str):
        return value
    return f"{value:,.0f}" if isinstance(value, int) or value >= 1000 else f"{value:#.3g}"
