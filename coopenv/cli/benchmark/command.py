"""``coopenv benchmark``: enter policies in the suites of the benchmark."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.cli.benchmark.told import document_of, print_tables, show_plan
from coopenv.cli.progress import bar_over, lines_over
from coopenv.errors import InvalidInput
from coopenv.options import POSITIONAL, Common

if TYPE_CHECKING:
    from coopenv.agents.benchmark import Entry


@dataclass(frozen=True, kw_only=True)
class Benchmark:
    """Enter policies in the benchmark: the same scenarios, episodes and measures for all.

    Everything is tried for two steps before the first episode. Interrupted or killed, the same
    command goes on.
    """

    entries: Annotated[tuple[str, ...], POSITIONAL] = ()
    """nobody, random, scripted, scripted:nonsqueezing and the like; module:function of your own;
    the file of a trained policy, or pretrained:{task}/joint, where {task} stands for the task of
    each scenario. See docs/benchmark.md."""
    suites: tuple[str, ...] = ()
    """team, partners, bodies, haptics; all without one."""
    only: tuple[str, ...] = ()
    """Scenarios of these suites by name, for example BeamDoorway, or "motion, 20 kg"."""
    name: str | None = None
    """What a single entry is called in tables and files."""
    trained: int | None = None
    """Control steps that a single entry was trained for, over all worlds; a file of coopenv train
    says it by itself. More than the budget of a suite is marked, as is what is not told."""
    seeds: int | None = None
    """Trainings of other seeds out of which the best is entered, itself among them; each counts."""
    out: Path = Path("runs/benchmark")
    """Folder for the summaries."""
    trust: bool = False
    """Run what the files hold: pickles of Stable-Baselines3."""
    dry_run: bool = False
    """Try everything for two steps and say what it comes to; write nothing."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv benchmark scripted random --suites team --only BeamTransport",
        "coopenv benchmark 'pretrained:{task}/joint' --dry-run",
        "coopenv benchmark runs/carry/policy.npz --name carry --suites partners bodies",
        "coopenv benchmark my_policies:act --trained 500000 --seeds 3 --suites haptics --json",
    )

    def run(self) -> dict[str, Any]:
        """Try, run, print the tables."""
        from rich.console import Console

        from coopenv.agents.benchmark import conduct, find_suites, plan

        suites = find_suites(self.suites)
        planned = plan(self._entries(), suites, self.only)
        console, errors = Console(), Console(stderr=True)
        for what, why in planned.left_out.items():
            errors.print(f"left out: {what}: {why}", markup=False, highlight=False, soft_wrap=True)
        if self.dry_run:
            return show_plan(planned, suites, console)
        progress = bar_over if console.is_terminal else lines_over
        try:
            with progress(console) as show:
                outcome = conduct(planned, self.out, show)
        except KeyboardInterrupt as stop:
            raise KeyboardInterrupt(
                "interrupted; finished scenarios are kept, and the same command goes on"
            ) from stop
        print_tables(outcome, suites, console)
        return document_of(outcome)

    def _entries(self) -> "list[Entry]":
        from coopenv.agents.benchmark import read_entry

        if not self.entries:
            raise InvalidInput(
                "entries must name at least one, got none; for example: coopenv benchmark scripted"
            )
        single = {name: getattr(self, name) for name in ("name", "trained", "seeds")}
        for what, told in single.items():
            if told is not None and len(self.entries) > 1:
                raise InvalidInput(
                    f"{what} must be of a single entry, got {told!r} for {len(self.entries)}; "
                    "enter them one by one"
                )
        return [read_entry(given, trust=self.trust, **single) for given in self.entries]
