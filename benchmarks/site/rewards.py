"""Tables of reward terms and presets: docs/rewards.md.

python -m benchmarks.site.rewards            # prints the tables
python -m benchmarks.site.rewards --write    # and writes docs/rewards.md
"""

import inspect
from dataclasses import fields

from benchmarks.pages import DOCS, filled, markdown, show
from benchmarks.site.docstrings import prose, unit_of
from coopenv import rewards

PAGE = DOCS / "rewards.md"


def terms() -> dict[str, type]:
    """The classes of terms, by name."""
    found = {name: getattr(rewards, name) for name in rewards.__all__}
    return {
        name: kind
        for name, kind in found.items()
        if inspect.isclass(kind) and "weight" in getattr(kind, "__dataclass_fields__", {})
    }


def tables() -> dict[str, str]:
    """The page's tables by name."""
    rows = [
        (
            f"`{name}`",
            prose((inspect.getdoc(kind) or "").partition("\n")[0]).replace("|", "\\|"),
            " ".join(f"`{entry.name}={_default(entry.default)}`" for entry in fields(kind)
                     if _default(entry.default)),
            unit_of(kind, "weight"),
        )
        for name, kind in terms().items()
    ]  # fmt: skip
    presets = [
        (f'`"{name}"`', ", ".join(f"`{part}`: {_shown(term)}" for part, term in chosen.items()))
        for name, chosen in rewards.PRESETS.items()
    ]
    return {
        "terms": markdown(
            ("term", "what it pays or takes", "defaults", "unit of the weight"), rows
        ),
        "presets": markdown(("preset", "terms"), presets),
    }


def _default(value: object) -> str:
    return repr(value) if isinstance(value, (int, float, tuple)) else ""


def _shown(term: object) -> str:
    return f"`{type(term).__name__}(weight={getattr(term, 'weight', 1):g})`"


def page() -> str:
    """The page as it should be."""
    return filled(PAGE, tables())


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    show(PAGE, tables())


if __name__ == "__main__":
    main()
