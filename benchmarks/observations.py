"""Every observation block in a table: docs/observations.md.

python -m benchmarks.observations            # prints the table
python -m benchmarks.observations --write    # and writes docs/observations.md
"""

import numpy as np

from benchmarks.pages import DOCS, filled, markdown, show
from coopenv.observation import BLOCKS, DEFAULT_BLOCKS, FELT, SENSING
from coopenv.observation.block import Block, EachOther
from coopenv.tasks import TASKS

PAGE = DOCS / "observations.md"
SETS = {"default": DEFAULT_BLOCKS, **SENSING}
OWN = [kind() for kind in TASKS]
COLUMNS = ("block", "features", "unit", "frame", "range", "what it is", "part of")


def rows() -> list[list[str]]:
    """One row a block, those that tasks bring last."""
    own = {block.name: task for task in OWN for block in task.blocks}
    blocks = {**BLOCKS, **{block.name: block for task in OWN for block in task.blocks}}
    return [
        [
            f"`{name}`",
            features(block),
            block.unit,
            block.frame or "—",
            bounds(block),
            block.describe,
            f"`{type(own[name]).__name__}`" if name in own else part_of(name),
        ]
        for name, block in blocks.items()
    ]


def part_of(name: str) -> str:
    """The sets that hold a block; those of senses hold some only where there are hands."""
    if name in FELT:
        return f"{', '.join(SENSING)}: with hands"
    return ", ".join(word for word, names in SETS.items() if name in names) or "—"


def features(block: Block) -> str:
    """How many an agent of a team of n sees."""
    size = block.size
    if not isinstance(size, EachOther):
        return f"{size}"
    return f"{size.own} + " * bool(size.own) + f"{size.features} (n − 1)"


def bounds(block: Block) -> str:
    """The bounds of the features, repeated ones once."""
    low, high = np.broadcast_arrays(block.low, block.high)
    pairs = zip(np.atleast_1d(low).tolist(), np.atleast_1d(high).tolist(), strict=True)
    return ", ".join(dict.fromkeys(interval(*pair) for pair in pairs))


def interval(low: float, high: float) -> str:
    """One feature's bounds; open where there is none."""
    if np.isinf([low, high]).all():
        return "any"
    return f"[{low:g}, {high:g}]"


def as_markdown() -> str:
    """The page's table."""
    return markdown(COLUMNS, rows())


def page() -> str:
    """The page as it should be."""
    return filled(PAGE, {"table": as_markdown()})


def main() -> None:
    """Print the table; with ``--write`` also put it on the page."""
    show(PAGE, {"table": as_markdown()})


if __name__ == "__main__":
    main()
