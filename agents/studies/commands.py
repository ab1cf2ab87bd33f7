"""``coopenv study <name>``: runs a study, prints its table, writes figures, tables and data."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.options import POSITIONAL, Common
from coopenv.physics.scene import Box

from .beam.simulation import BeamConfig
from .claims import Claim, claim_table, plain_table
from .dyads.config import DyadsConfig
from .snapshots.report import SnapshotsConfig
from .tables import Table
from .walker import simulations

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True, kw_only=True)
class Beam:
    """A beam carried without disagreement, and what each method calls internal (Figs. 12, 13)."""

    simulation: BeamConfig = field(default_factory=BeamConfig)
    out: Path = Path("runs/study_beam")
    """Folder for figures, tables and data."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study beam --out runs/beam",
        "coopenv study beam --duration 4 --json",
    )

    def run(self) -> dict[str, Any]:
        """Simulate, decompose, check, write."""
        console = _console()
        from .beam.report import write
        from .beam.simulation import simulate

        with console.status("carrying the beam"):
            run = simulate(self.simulation)
        with console.status("decomposing and drawing"):
            found, files = write(run, self.out)
        _print_claims(console, found, "beam: the claims of section V-C")
        _print_files(console, self.out, files)
        return _document("beam", found, self.out, files)


@dataclass(frozen=True, kw_only=True)
class WalkerTurn:
    """A walker, pushed by a human and turned by its drive (Figs. 9, 10)."""

    simulation: simulations.WalkerTurn = field(default_factory=simulations.WalkerTurn)
    out: Path = Path("runs/study_walker_turn")
    """Folder for figures, tables and data."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study walker-turn --out runs/turn",
        "coopenv study walker-turn --stiffness 60 --json",
    )

    def run(self) -> dict[str, Any]:
        """Simulate, decompose, check, write."""
        console = _console()
        from .walker.turn import write

        with console.status("turning the walker"):
            recording = self.simulation.run()
        with console.status("decomposing and drawing"):
            found, files = write(self.simulation, recording, self.out)
        _print_claims(console, found, "walker-turn: the claims of section V-A")
        _print_files(console, self.out, files)
        return _document("walker-turn", found, self.out, files)


@dataclass(frozen=True, kw_only=True)
class WalkerAvoid:
    """A walker whose drive holds it off an obstacle, against the human's plan (Fig. 11)."""

    simulation: simulations.WalkerAvoid = field(default_factory=simulations.WalkerAvoid)
    out: Path = Path("runs/study_walker_avoid")
    """Folder for figures, tables and data."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study walker-avoid --out runs/avoid",
        "coopenv study walker-avoid --obstacle 1.5 --json",
    )

    def run(self) -> dict[str, Any]:
        """Simulate, decompose, check, write."""
        console = _console()
        from .walker.avoid import write

        with console.status("walking towards the obstacle"):
            recording = self.simulation.run()
        with console.status("decomposing and drawing"):
            found, files = write(self.simulation, recording, self.out)
        _print_claims(console, found, "walker-avoid: the claims of section V-A")
        _print_files(console, self.out, files)
        return _document("walker-avoid", found, self.out, files)


@dataclass(frozen=True, kw_only=True)
class Snapshots:
    """Single wrenches, drawn and split by several methods (Figs. 2 to 8 and 17)."""

    wrenches: SnapshotsConfig = field(default_factory=SnapshotsConfig)
    out: Path = Path("runs/study_snapshots")
    """Folder for figures and tables."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study snapshots --out runs/snapshots",
        "coopenv study snapshots --samples 1000 --json",
    )

    def run(self) -> dict[str, Any]:
        """Decompose, check, draw, write."""
        console = _console()
        from .snapshots.report import write

        with console.status("decomposing and drawing"):
            found, files = write(self.wrenches, self.out)
        _print_claims(console, found, "snapshots: the claims of Figs. 2 to 8 and 17")
        _print_files(console, self.out, files)
        return _document("snapshots", found, self.out, files)


@dataclass(frozen=True, kw_only=True)
class Dyads:
    """The human study (Figs. 15, 16), with simulated people or on recorded trials of pairs.

    Without files, pairs of simulated people carry a beam through a doorway. Files are read as
    coopenv decompose reads them, and say besides pair, condition (one, both, none), trial and
    first, the agent that enters the final platform first.
    """

    files: Annotated[tuple[Path, ...], POSITIONAL] = ()
    """CSV, NPZ or Parquet files of recorded trials, taken together; none: simulated people."""
    layout: Path | None = None
    """.toml or .json file that says how the files are to be read; see docs/recordings.md."""
    platform: tuple[float, float, float, float] | None = None
    """Final platform where the files do not say who is first: its centre x y, its width height."""
    window: float = 0.6
    """Start of a trial over which T_I is averaged [s]."""
    simulation: DyadsConfig = field(default_factory=DyadsConfig)
    out: Path = Path("runs/study_dyads")
    """Folder for figures, tables and data."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study dyads --pairs 4 --trials 3",
        "coopenv study dyads pair1.csv pair2.csv --layout trials.toml",
        "coopenv study dyads pair1.csv --platform 2.5 0 1 2 --window 0.6 --json",
    )

    def run(self) -> dict[str, Any]:
        """Read or simulate, analyse, write."""
        self._check()
        console = _console()
        from .dyads import report, simulation
        from .dyads.analysis import analyse

        if self.files:
            table, source, made = self._recorded(), "recorded trials", []
        else:
            with console.status("simulating people"):
                run = simulation.simulate(self.simulation)
            made = simulation.save(run, self.out)
            table, source = run.trials, simulation.SOURCE
            _print_rows(console, simulation.course_rows(run), "the trials of simulated people")
        with console.status("analysing"):
            analysis = analyse(table, window=self.window, source=source)
            found, files = report.write(analysis, self.out)
        title = f"{source} beside the people of section VI"
        _print_rows(console, report.comparison(analysis), title)
        _print_rows(console, report.effect_rows(analysis), "repeated-measures ANOVA")
        _print_claims(console, found, f"dyads: what was found in people, in {source}")
        for note in analysis.notes:
            console.print(f"note: {note}", markup=False, highlight=False)
        _print_files(console, self.out, [*files, *made])
        document = _document("dyads", found, self.out, [*files, *made])
        return {**document, **analysis.document()}

    def _check(self) -> None:
        for name in ("layout", "platform"):
            if getattr(self, name) is not None and not self.files:
                raise InvalidInput(
                    f"{name} must come with files of recorded trials, got none; name them before it"
                )

    def _recorded(self) -> Table:
        from coopenv.logs import Layout

        from .dyads import reading, trials

        table = reading.read_trials(self.files, Layout.load(self.layout))
        if self.platform is None:
            return table
        x, y, width, height = self.platform
        box = Box(center=(x, y), size=(width, height))
        return table.assign(first=trials.first_to_enter(table, box))


def _console() -> "Console":
    try:
        import matplotlib  # noqa: F401  - everything a study needs, before it computes anything
        import pandas  # noqa: F401
        import statsmodels  # noqa: F401
        from rich.console import Console
    except ImportError as error:
        raise MissingExtra("a study", "analysis") from error
    return Console()


def _print_claims(console: "Console", found: Sequence[Claim], title: str) -> None:
    console.print()
    console.print(claim_table(found, title))
    failed = sum(not claim.holds for claim in found)
    console.print(f"{len(found) - failed} of {len(found)} hold")


def _print_rows(console: "Console", rows: Sequence[dict[str, str]], title: str) -> None:
    if rows:
        console.print()
        console.print(plain_table(rows, title))


def _print_files(console: "Console", out: Path, files: Sequence[str]) -> None:
    console.print(f"in {out}: {', '.join(files)}", markup=False, highlight=False)


def _document(name: str, found: Sequence[Claim], out: Path, files: Sequence[str]) -> dict[str, Any]:
    """What a study came to, for programs."""
    claims = [{**asdict(claim), "holds": claim.holds} for claim in found]
    return {"study": name, "claims": claims, "folder": out, "files": files}
