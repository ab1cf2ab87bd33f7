"""Table of what every method says to the paper's examples, written to docs/decomposition.md.

python -m benchmarks.methods            # prints the table
python -m benchmarks.methods --write    # and writes docs/decomposition.md
"""

import numpy as np

from benchmarks.pages import DOCS, filled, markdown, show
from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput

PAGE = DOCS / "decomposition.md"
BEAM = ((-1.0, 0.0), (1.0, 0.0))  # [m]
POINT = ((0.0, 0.0),) * 3
FIGURE_2 = ((2.0, 0.0), (1.0, 1.0), (3.0, -1.0))  # [N] along the beam
FIGURE_5 = ((3.0, 3.0, 0.0), (4.0, -1.0, 0.0), (-3.0, 0.0, 0.0))  # [N], reconstructed
COUPLE = ((0.0, -0.7, 0.0), (0.0, 0.7, 0.0))
DESIRED = ((8 / 3, 0.0, 0.0), (4 / 3, 0.0, 0.0))  # footnote 2 [m/s²]
COLUMNS = (
    "method",
    *(f"({first:g}, {second:g}): f_I,1" for first, second in FIGURE_2),
    "couple: f_I,1 across",
    "couple: t_I",
    "Fig. 5: Σ‖f_M‖",
    "Fig. 5: Σ‖f_I‖",
    "Fig. 5: largest ‖f_I,i‖/‖f_i‖",
)


def rows() -> list[list[str]]:
    """One row for each method: internal forces [N] and torques [N·m], a dash where undefined."""
    lines = [
        [f"`{method}`", *pair_cells(method), *point_cells(method)] for method in wrench.METHODS
    ]
    violated = wrench.constraint_violation(DESIRED, BEAM, masses=(1, 1), inertias=(1, 1))
    footnote = ["`constraint_violation`", f"{number(violated[0, 0])} (footnote 2)"]
    return [*lines, [*footnote, *["—"] * (len(COLUMNS) - 2)]]


def pair_cells(method: str) -> list[str]:
    """What a method says to the beam of Fig. 2 and to the couple."""
    cells = []
    for forces in FIGURE_2:
        applied = np.zeros((2, 3))
        applied[:, 0] = forces
        internal = internal_of(applied, BEAM, method)
        cells.append("—" if internal is None else number(internal[0, 0]))
    internal = internal_of(COUPLE, BEAM, method)
    if internal is None:
        return [*cells, "—", "—"]
    return [*cells, number(abs(internal[0, 1])), number(internal[0, 2])]


def point_cells(method: str) -> list[str]:
    """What a method says to the three forces of Fig. 5."""
    internal = internal_of(FIGURE_5, POINT, method)
    if internal is None:
        return ["—"] * 3
    applied = np.array(FIGURE_5)
    size = np.linalg.norm(internal, axis=-1)
    cells = [number(np.linalg.norm(applied - internal, axis=-1).sum())]
    if method == "optimal":  # several splits cost the same: what is found depends on the solver
        return [*cells, "not unique", "≤ 1"]
    return [*cells, number(size.sum()), number((size / np.linalg.norm(applied, axis=-1)).max())]


def internal_of(applied: object, grips: object, method: str) -> FloatArray | None:
    """Internal wrenches, or None where the method does not define them."""
    try:
        return wrench.decompose(applied, grips, method=method).internal  # pyright: ignore
    except InvalidInput:
        return None


def number(value: float) -> str:
    """Three decimals, no negative zero, no needless zeros."""
    return f"{round(float(value), 3) + 0.0:g}"


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
