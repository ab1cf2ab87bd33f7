"""The tables of docs/recordings.md, made from the names that the code knows.

python -m benchmarks.recordings            # prints them
python -m benchmarks.recordings --write    # and puts them on the page
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from coopenv.logs.analysis import RESULTS
from coopenv.logs.columns import INPUT
from coopenv.logs.layout import UNITS

PAGE = Path(__file__).parents[1] / "docs" / "recordings.md"


def tables() -> dict[str, str]:
    """Markdown of each table by the name of its mark."""
    units = [(f"`{name}`", ", ".join(known)) for name, known in UNITS.items()]
    return {
        "columns": _markdown(("in the plane", "in space", "unit", "what"), INPUT),
        "units": _markdown(("field, option", "known, the first is the default"), units),
        "results": _markdown(("column", "unit", "what"), RESULTS),
    }


def page() -> str:
    """The page with its tables as they should be."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables().items():
        mark = f"<!-- {name} -->\n"
        head, _, tail = text.split(mark)
        text = f"{head}{mark}{table}\n{mark}{tail}"
    return text


def _markdown(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    print("\n\n".join(tables().values()))
    if "--write" in sys.argv[1:]:
        PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
