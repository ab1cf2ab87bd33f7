"""Tables made by the code, and the pages of docs that hold them.

A table stands between two marks of its name, ``<!-- name -->``, each on a line of its own.
"""

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from coopenv.files import written

DOCS = Path(__file__).parents[1] / "docs"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, without a line end after it."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cells(page: Path, name: str) -> list[list[str]]:
    """The table of that name on the page, a list of cells a line: first the columns, then rows."""
    table = page.read_text(encoding="utf-8").split(f"<!-- {name} -->\n")[1]
    lines = table.splitlines()
    return [line[2:-2].split(" | ") for line in (lines[0], *lines[2:])]


def filled(page: Path, tables: Mapping[str, str]) -> str:
    """The text of ``page`` with each table between the marks of its name."""
    text = page.read_text(encoding="utf-8")
    for name, table in tables.items():
        mark = f"<!-- {name} -->\n"
        head, _, tail = text.split(mark)
        text = "".join((head, mark, table.rstrip("\n"), "\n", mark, tail))
    return text


def show(page: Path, tables: Mapping[str, str]) -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    print("\n\n".join(tables.values()))
    if "--write" in sys.argv[1:]:
        fill(page, tables)


def fill(page: Path, tables: Mapping[str, str]) -> None:
    """Put the tables on the page."""
    text = filled(page, tables)
    with written(page) as part:
        part.write_text(text, encoding="utf-8")
