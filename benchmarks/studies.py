"""The figures and tables of docs/studies.md, made by running every study.

python -m benchmarks.studies                    # prints them, and leaves all files in runs/studies
python -m benchmarks.studies --write            # and puts figures and tables on the page
python -m benchmarks.studies --write snapshots  # those of one study only
"""

import re
import sys
from collections.abc import Iterable
from inspect import getsource
from pathlib import Path

from benchmarks.pages import DOCS, fill, filled
from coopenv.agents.studies import commands
from coopenv.agents.studies.claims import markdown
from coopenv.agents.studies.dyads.people import People
from coopenv.files import written

PAGE = DOCS / "studies.md"
OUT = Path("runs") / "studies"
LARGE = 200_000  # [B] from which a picture is stored with 256 colours

STUDIES = {
    "walker-turn": commands.WalkerTurn,
    "walker-avoid": commands.WalkerAvoid,
    "beam": commands.Beam,
    "snapshots": commands.Snapshots,
    "dyads": commands.Dyads,
}
TABLES = {
    "walker-turn": ("claims",),
    "walker-avoid": ("claims",),
    "beam": ("claims",),
    "snapshots": ("sources", "claims"),
    "dyads": ("course", "comparison", "anova", "claims"),
}
PICTURES = {
    "walker-turn": ("way", "time"),
    "walker-avoid": ("way", "time"),
    "beam": ("motion_J1", "disagreement_J1"),
    "snapshots": tuple(f"fig{number}" for number in (2, 3, 4, 5, 6, 7, 8, 17)),
    "dyads": ("internal_torque", "load_density"),
}


def tables(out: Path, studies: Iterable[str] = tuple(STUDIES)) -> dict[str, str]:
    """Markdown of each table by the name of its mark, from the files that the studies left."""
    found = {
        f"{study} {name}": (out / study / f"{name}.md").read_text(encoding="utf-8")
        for study in studies
        for name in TABLES[study]
    }
    return {"people": people(), **found}


def people() -> str:
    """Each trait's distribution, as the comments of the dataclass say it."""
    rows = []
    for name, value, said in re.findall(r"^    (\w+): .*= (.*)  # (.*)$", getsource(People), re.M):
        low_high = value.strip("()").split(", ")
        drawn = " to ".join(low_high) if len(low_high) == 2 else f"normal, 0 ± {value}"
        rows.append({"trait": f"`{name}`", "drawn": drawn, "what": said})
    return markdown(rows)


def pictures(out: Path, studies: Iterable[str] = tuple(STUDIES)) -> dict[Path, Path]:
    """Each picture of the page and the file that it is made from."""
    folder = PAGE.with_suffix("")
    return {
        folder / f"{study}_{name}.png": out / study / f"{name}.png"
        for study in studies
        for name in PICTURES[study]
    }


def page(found: dict[str, str]) -> str:
    """The page with these tables in place of its own."""
    return filled(PAGE, found)


def write(out: Path, studies: Iterable[str] = tuple(STUDIES)) -> None:
    """Put figures and tables of studies on the page."""
    from PIL import Image

    PAGE.with_suffix("").mkdir(exist_ok=True)
    for path, source in pictures(out, studies).items():
        with Image.open(source) as image, written(path) as part:
            stored = image.convert("RGB")
            if source.stat().st_size > LARGE:
                stored = stored.quantize(256, dither=Image.Dither.NONE)
            stored.save(part, format="PNG", optimize=True)
    fill(PAGE, tables(out, studies))


def main() -> None:
    """Run the studies that are named, or all; with ``--write`` put what they found on the page."""
    chosen = [name for name in sys.argv[1:] if name != "--write"] or list(STUDIES)
    for name in chosen:
        if name not in STUDIES:
            sys.exit(
                f"study must be one of {', '.join(STUDIES)}, got {name!r}; leave it out for all"
            )
    for name in chosen:
        STUDIES[name](out=OUT / name).run()
    if "--write" in sys.argv[1:]:
        write(OUT, chosen)


if __name__ == "__main__":
    main()
