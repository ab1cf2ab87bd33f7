"""Badges that say what pyproject.toml says: docs/badges/.

python -m benchmarks.site.badges            # says which are old
python -m benchmarks.site.badges --write    # and draws them
"""

import re
import sys
from pathlib import Path

from benchmarks.pages import DOCS
from coopenv.files import toml, written

FOLDER = DOCS / "badges"
_LETTER = 6.6  # [px] width of a letter, on the mean
_SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="20" role="img" \
aria-label="{name}: {value}">
<title>{name}: {value}</title>
<rect width="{width}" height="20" rx="3" fill="#555"/>
<rect x="{left}" width="{right}" height="20" rx="3" fill="#0b6fb3"/>
<g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11" text-anchor="middle">
<text x="{middle_left}" y="14">{name}</text>
<text x="{middle_right}" y="14">{value}</text>
</g>
</svg>
"""


def values() -> dict[str, str]:
    """What each badge says."""
    project = toml.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needs = {re.split(r"[<>=]", line)[0]: line for line in project["dependencies"]}
    said = {"python": project["requires-python"], "license": project["license"]}
    said |= {name: needs[name].removeprefix(name) for name in ("gymnasium", "pettingzoo")}
    shown = {">=": "≥ ", "<": "< ", ",": ", "}
    return {
        name: re.sub(r">=|<|,", lambda sign: shown[sign[0]], text) for name, text in said.items()
    }


def badge(name: str, value: str) -> str:
    """One badge as SVG."""
    left, right = (round(_LETTER * len(text)) + 12 for text in (name, value))
    return _SVG.format(
        name=name,
        value=value.replace("<", "&lt;"),
        width=left + right,
        left=left,
        right=right,
        middle_left=left / 2,
        middle_right=left + right / 2,
    )


def stale() -> dict[Path, str]:
    """Badges that do not say what the project says, and how they should be."""
    wanted = {FOLDER / f"{name}.svg": badge(name, value) for name, value in values().items()}
    return {
        path: text
        for path, text in wanted.items()
        if not path.exists() or path.read_text(encoding="utf-8") != text
    }


def main() -> None:
    """Say which badges are old; with ``--write`` draw them."""
    for path, text in stale().items():
        print(path.relative_to(DOCS.parent))
        if "--write" in sys.argv[1:]:
            with written(path) as part:
                part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
