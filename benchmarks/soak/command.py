"""Command line of the soak test.

Failures are told as they come, each with the command that meets it again. The exit code is 1 if
there were any, and 2 for options that make no sense.
"""

import signal
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import tyro
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.pages import DOCS, fill
from benchmarks.soak.campaigns import chosen
from benchmarks.soak.frame.campaign import Campaign
from benchmarks.soak.frame.ledger import Ledger, Trial
from benchmarks.soak.frame.report import machine, reproduction, table
from benchmarks.soak.frame.runner import Runner
from benchmarks.soak.frame.worker import attempt
from coopenv.arrays import positive, whole
from coopenv.errors import CoopenvError, InvalidInput

PAGE = DOCS / "reliability.md"


@dataclass(frozen=True, slots=True, kw_only=True)
class Soak:
    """Random trials that look for what breaks."""

    minutes: float = 60.0  # by the clock, all runs in one folder together
    only: str | None = None  # name of one campaign
    seed: int | None = None  # one trial of it, here and now
    workers: int = 2
    out: Path | None = None  # folder that the run goes on in; runs/soak, or runs/soak-NAME
    first_seed: int = 0  # of every campaign
    trials: int | None = None  # of each campaign, at most
    also: tuple[str, ...] = ()  # modules of further campaigns
    again: bool = False  # begin with the trials that failed, once what they found is mended
    fresh: bool = False  # forget the run in the folder
    write: bool = False  # the table into docs/reliability.md

    def __post_init__(self) -> None:
        positive(self.minutes, "minutes")
        whole(self.workers, "workers", at_least=1, at_most=1000)
        whole(self.first_seed, "first_seed", at_least=0)
        if self.trials is not None:
            whole(self.trials, "trials", at_least=1)
        if self.seed is not None and self.only is None:
            raise InvalidInput(
                f"seed must come with the campaign it is of, got {self.seed} alone; name it: --only"
            )
        if self.write and self.only is not None:
            raise InvalidInput(
                f"write must be for all campaigns, got only {self.only!r}; leave one of them out"
            )

    @property
    def folder(self) -> Path:
        """Where its results are, whatever the folder that is worked in."""
        usual = "soak" if self.only is None else f"soak-{self.only}"
        return (self.out or Path("runs") / usual).absolute()  # commands run in folders of their own


def run(soak: Soak, console: Console) -> int:
    """Run it to its end; the exit code."""
    campaigns = chosen(soak.only, soak.also)
    if soak.seed is not None:
        return run_one(campaigns[0], soak.seed, console)
    with closing(Ledger(soak.folder, machine(), fresh=soak.fresh)) as ledger:
        run_all(soak, ledger, campaigns, console)
        made = table(ledger, campaigns)
        console.print(made, markup=False, highlight=False, soft_wrap=True)
        console.print(f"in {soak.folder}", markup=False, highlight=False, soft_wrap=True)
        if soak.write:
            fill(PAGE, {"soak": made})
        return int(bool(ledger.failures))


def run_one(campaign: Campaign, seed: int, console: Console) -> int:
    """One trial in this process, with its traceback."""
    with TemporaryDirectory() as folder:
        outcome = attempt(campaign, seed, Path(folder) / "trial")
    if outcome.failure is not None:
        console.print(outcome.trace, markup=False, highlight=False, soft_wrap=True)
        return 1
    console.print(f"{campaign.NAME}, seed {seed}: {outcome.counts}", markup=False)
    return 0


def run_all(soak: Soak, ledger: Ledger, campaigns: Sequence[Campaign], console: Console) -> None:
    """Go on with what the ledger holds until the time is up, with a bar."""
    columns = (TextColumn("soak"), BarColumn(), TextColumn("{task.fields[told]}"))
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=60 * soak.minutes, told="")

        def tell(trial: Trial) -> None:
            said = reproduction(trial, soak.also)
            bar.console.print(said, markup=False, highlight=False, soft_wrap=True)

        runner = Runner(
            ledger,
            campaigns,
            seconds=60 * soak.minutes,
            folder=soak.folder,
            workers=soak.workers,
            first_seed=soak.first_seed,
            trials=soak.trials,
            again=soak.again,
            tell=tell,
        )
        for trial in ledger.failures:
            tell(trial)

        def beat() -> None:
            told = f"{len(ledger.trials):,} trials, {len(ledger.failures)} failed"
            bar.update(task, completed=runner.clock, told=told)

        runner.run(beat)


def main() -> None:
    """Run the soak test that the command line describes."""
    console = Console()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = run(tyro.cli(Soak), console)
    except CoopenvError as error:
        console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        code = 2
    except KeyboardInterrupt:
        console.print("stopped; the same command goes on")
        code = 130
    sys.exit(code)
