"""Command line of ``coopenv inspect``: what is in recorded files, and a layout to begin with."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.options import POSITIONAL, Common


@dataclass(frozen=True, kw_only=True)
class Inspect:
    """Say what is in recorded files, and which documented column each of theirs could be.

    Columns, shapes of arrays, rates, gaps, and units that names or numbers tell. All is said, and
    nothing is assumed of it; --write makes a layout for coopenv decompose of it, to be corrected.
    """

    files: Annotated[tuple[Path, ...], POSITIONAL]
    """Of one trial, the recording first, then those of other devices."""
    write: Path | None = None
    """A layout to begin with, .toml."""
    layout: Path | None = None
    """How texts are written (skip_lines, encoding and so on), .toml or .json."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv inspect trial.csv",
        "coopenv inspect robot.csv sensor.h5 --write trial.toml",
        "coopenv inspect trial.mcap --json",
    )

    def run(self) -> dict[str, Any]:
        """Print it."""
        try:
            from rich.console import Console
        except ImportError as error:
            raise MissingExtra("the command line", "analysis") from error

        from coopenv.files import require_writable, written
        from coopenv.logs.inspected.beginning import first_layout
        from coopenv.logs.inspected.contents import inspect_file
        from coopenv.logs.layout import Layout

        if not self.files:
            raise InvalidInput("files must be named, got none; for example: inspect trial.csv")
        if self.write is not None:
            if self.write.suffix.lower() != ".toml" or self.write.exists():
                raise InvalidInput(
                    f"write must be a new .toml file, got {str(self.write)!r}; choose another name"
                )
            require_writable(self.write)
        said = Layout.load(self.layout)
        contents = [
            each for path in self.files for each in inspect_file(path, said.dialect, said.limits)
        ]
        console = Console()
        for line in described(contents):
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        if self.write is not None:
            with written(self.write) as part:
                part.write_text(first_layout(contents), encoding="utf-8")
            console.print(f"wrote {self.write}", markup=False, highlight=False, soft_wrap=True)
        return {"files": [*documents(contents)], "written": self.write}


def described(contents: Sequence) -> Iterator[str]:
    """Lines on files: a head, the clock, and one a column."""
    from coopenv.logs.inspected.guesses import guesses
    from coopenv.logs.limits import legible, shown

    for each, found in zip(contents, guesses(contents), strict=True):
        part = f", {shown(each.part)}" if each.part else ""
        yield f"{legible(each.path)}{part}: {each.rows:,} rows, {len(each.columns):,} columns"
        yield f"  {_ticking(each.clock)}"
        for name, shape in each.shapes.items():
            yield f"  array {shown(name)} of shape {shape}"
        if each.left_out:
            yield f"  no columns: {', '.join(map(shown, each.left_out))}"
        width = min(max((len(shown(seen.name)) for seen in each.columns), default=0), 40)
        for seen in each.columns:
            is_time = each.clock is not None and seen.name == each.clock.column
            could = "time" if is_time else _could(found.get(seen.name))
            yield f"  {shown(seen.name):{width}}  {_ranged(seen)}{f'  {could}' if could else ''}"


def documents(contents: Sequence) -> Iterator[dict[str, Any]]:
    """The same for programs: of each file its contents, and what each column could be."""
    from coopenv.logs.inspected.guesses import guesses

    for each, found in zip(contents, guesses(contents), strict=True):
        columns = [{**asdict(seen), "could_be": found.get(seen.name)} for seen in each.columns]
        yield {**asdict(each), "columns": columns}


def _ticking(clock) -> str:
    if clock is None:
        return "no column looks like time"
    by = "" if clock.said else ", by the size of its numbers"
    text = (
        f"time {clock.column!r} in {clock.unit}{by}: {clock.begin:.6g} s to {clock.end:.6g} s, "
        f"{clock.rate:.6g} rows a second"
    )
    if clock.gaps:
        text += f", gaps: {clock.gaps:,}, of up to {clock.longest:.4g} s"
    if clock.equal:
        text += f", rows with the time of the row before: {clock.equal:,}"
    return text + (f", rows with an earlier one: {clock.falls:,}" if clock.falls else "")


def _ranged(seen) -> str:
    from coopenv.logs.limits import shown

    unit = f" {shown(seen.unit)}" if seen.unit else ""
    if not seen.is_number:
        return f"text such as {shown(seen.first)!r}"
    missing = f", {seen.missing:,} missing" if seen.missing else ""
    return f"{seen.low:.6g} to {seen.high:.6g}{unit}{missing}"


def _could(guess) -> str:
    if guess is None:
        return ""
    if not guess.unit:
        return f"could be {guess.name}"
    return f"could be {guess.name} in {guess.unit}" + ("" if guess.said else ", by its size")
