"""Claims of a paper checked by measured numbers, and tables of them and of other rows."""

import csv
import math
import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING

from typing_extensions import Self

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = ("claim", "source", "measured", "rule", "verdict", "why")
_RELATIONS = {"≤": operator.le, "≥": operator.ge, "<": operator.lt, ">": operator.gt}


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """One sentence of the paper beside the number that decides it.

    Whether it holds follows from ``measured`` and the rule, never from a verdict somebody wrote.

    Parameters
    ----------
    text
        What is claimed.
    source
        Where: section, figure, equation.
    measured
        The number that decides; NaN where nothing could be measured: then it does not hold.
    relation, bound
        The rule: ``measured relation bound`` with ``"≤"``, ``"≥"``, ``"<"`` or ``">"``.
    unit
        Of ``measured`` and ``bound``; empty for a plain number.
    why
        What explains a claim that does not hold, or qualifies one that does.

    Raises
    ------
    InvalidInput
        If the relation is none of the four or the bound is not a number.
    """

    text: str
    source: str
    measured: float
    relation: str
    bound: float
    unit: str = ""
    why: str = ""

    def __post_init__(self) -> None:
        if self.relation not in _RELATIONS:
            raise InvalidInput(
                f"relation must be one of {', '.join(_RELATIONS)}, got {self.relation!r}; "
                "turn the claim round"
            )
        if math.isnan(self.bound):
            raise InvalidInput("bound must be a number, got nan; give what the rule compares with")

    @classmethod
    def zero(
        cls, text: str, source: str, measured: float, *, within: float, unit: str = "", why=""
    ) -> Self:
        """A magnitude that is claimed to vanish: at most ``within``."""
        return cls(
            text=text,
            source=source,
            measured=measured,
            relation="≤",
            bound=within,
            unit=unit,
            why=why,
        )

    @property
    def holds(self) -> bool:
        """Whether the measured number keeps the rule."""
        return bool(_RELATIONS[self.relation](self.measured, self.bound))

    @property
    def verdict(self) -> str:
        """In words."""
        return "holds" if self.holds else "does not hold"

    def row(self) -> dict[str, str]:
        """The columns of the tables, as text."""
        unit = f" {self.unit}" if self.unit else ""
        measured = f"{number(self.measured)}{unit}"
        rule = f"{self.relation} {number(self.bound)}{unit}"
        values = (self.text, self.source, measured, rule, self.verdict, self.why)
        return dict(zip(COLUMNS, values, strict=True))


def number(value: float) -> str:
    """Four digits, without noise: ``0.1548``, ``3.1e-13``, ``-``."""
    if math.isnan(value):
        return "-"
    return f"{value:.4g}"


def claim_table(claims: Sequence[Claim], title: str | None = None) -> "Table":
    """The claims as a rich table, in which source and reason stand with the claim."""
    made = _empty_table(title)
    rows = [claim.row() for claim in claims]
    made.add_column("claim", ratio=1)
    for name in ("measured", "rule"):
        made.add_column(name, no_wrap=True)
    made.add_column("verdict", min_width=len("does not"))
    for claim, row in zip(claims, rows, strict=True):
        text = f"{claim.text} ({claim.source})" + (f"; {claim.why}" if claim.why else "")
        cells = (text, row["measured"], row["rule"], claim.verdict)
        made.add_row(*cells, style=None if claim.holds else "bold red")
    return made


def plain_table(rows: Sequence[dict[str, str]], title: str | None = None) -> "Table":
    """Rows with the same columns as a rich table; where it is narrow no number is parted."""
    made = _empty_table(title)
    for name in _shown(rows):
        header = name.partition(" (")[0]  # what is in brackets stands in the files
        numbers = [cell for row in rows for cell in row[name].split(" (") if _is_number(cell)]
        least = max(len(each) for each in (*header.split(), *numbers))
        widest = max(least, *(len(row[name]) for row in rows))
        made.add_column(fill(header, widest), min_width=least)
    for row in rows:
        made.add_row(*(row[name] for name in _shown(rows)))
    return made


def markdown(rows: Sequence[dict[str, str]]) -> str:
    """A Markdown table of rows with the same columns; columns without content are left out."""
    shown = _shown(rows)
    lines = [shown, ["---"] * len(shown)]
    lines += [[row[name].replace("|", "\\|") for name in shown] for row in rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def save_claims(claims: Sequence[Claim], stem: str | os.PathLike) -> list[str]:
    """Write ``stem``.md and ``stem``.csv; the names of the files."""
    return save_rows([claim.row() for claim in claims], stem)


def save_rows(rows: Sequence[dict[str, str]], stem: str | os.PathLike) -> list[str]:
    """Write rows with the same columns to ``stem``.md and ``stem``.csv; the names of the files."""
    text, data = f"{os.fspath(stem)}.md", f"{os.fspath(stem)}.csv"
    with written(text) as part:
        part.write_text(markdown(rows), encoding="utf-8")
    with written(data) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return [os.path.basename(text), os.path.basename(data)]


def _shown(rows: Sequence[dict[str, str]]) -> list[str]:
    return [name for name in rows[0] if any(row[name] for row in rows)]


def _is_number(cell: str) -> bool:
    """Whether a part of a cell is a number, or a test with its degrees of freedom."""
    return cell[:1].isdigit() or cell[:1] in "-<" or cell[:2] == "F("


def _empty_table(title: str | None) -> "Table":
    try:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
    except ImportError as error:
        raise MissingExtra("the table of claims", "analysis") from error
    return Table(
        title=title,
        title_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        collapse_padding=True,
        pad_edge=False,
    )
