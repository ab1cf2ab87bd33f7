"""The tables of docs/recordings.md, made from the names that the code knows.

python -m benchmarks.recordings            # prints them
python -m benchmarks.recordings --write    # and puts them on the page
python -m benchmarks.recordings --draw     # draws the picture at the end of the guide anew
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.pages import DOCS, filled, markdown, show
from coopenv.logs import Layout, decompose_file
from coopenv.logs.analysis import RESULTS
from coopenv.logs.calibration.meaning import MEANING as CALIBRATION
from coopenv.logs.columns import INPUT
from coopenv.logs.layout import UNITS
from coopenv.logs.limits import MEANING
from examples import record_laboratory
from tests.docs.snippets import snippets
from tests.logs.kinds import table_rows

PAGE = DOCS / "recordings.md"
FIGURE = DOCS / "recordings.png"
COLOURS = 48  # of the picture, which has few


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


def draw() -> None:
    """Decompose the laboratory's files as the guide does, and keep the picture, made smaller."""
    from PIL import Image

    layout = next(each for each in snippets(PAGE) if each.file == "laboratory.toml")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record_laboratory.main(folder, np.random.default_rng(0))
        (folder / layout.file).write_text(layout.code, encoding="utf-8")
        said = Layout.load(folder / layout.file)
        made = decompose_file(folder / "mocap.csv", layout=said)
        with Image.open(str(made.picture)) as picture:
            size = (2 * picture.width // 3, 2 * picture.height // 3)
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(COLOURS, dither=Image.Dither.NONE).save(FIGURE, optimize=True)


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page; with ``--draw`` draw."""
    show(PAGE, tables())
    if "--draw" in sys.argv[1:]:
        draw()


if __name__ == "__main__":
    main()
