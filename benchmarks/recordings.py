"""The tables of docs/recordings.md, made from the names that the code knows.

python -m benchmarks.recordings            # prints them
python -m benchmarks.recordings --write    # and puts them on the page
"""

from benchmarks.pages import DOCS, filled, markdown, show
from coopenv.logs.analysis import RESULTS
from coopenv.logs.calibration.meaning import MEANING as CALIBRATION
from coopenv.logs.columns import INPUT
from coopenv.logs.layout import UNITS, Layout
from coopenv.logs.limits import MEANING
from tests.logs.kinds import table_rows

PAGE = DOCS / "recordings.md"


def tables() -> dict[str, str]:
    """Markdown of each table by the name of its mark."""
    units = [(f"`{name}`", ", ".join(known)) for name, known in UNITS.items()]
    limits = [
        (f"`--max-{name.replace('_', '-')}`", f"{getattr(Layout(), f'max_{name}'):,}", meaning)
        for name, meaning in MEANING.items()
    ]
    calibration = [(f"`{name}`", *said) for name, said in CALIBRATION.items()]
    return {
        "calibration": markdown(("key", "default", "what"), calibration),
        "columns": markdown(("in the plane", "in space", "unit", "what"), INPUT),
        "kinds": markdown(("kind of file", "said of it"), table_rows()),
        "units": markdown(("field, option", "known, the first is the default"), units),
        "limits": markdown(("option", "default", "the most"), limits),
        "results": markdown(("column", "unit", "what"), RESULTS),
    }


def page() -> str:
    """The page with its tables as they should be."""
    return filled(PAGE, tables())


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    show(PAGE, tables())


if __name__ == "__main__":
    main()
