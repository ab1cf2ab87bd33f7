"""Pictures of what is internal and what is not, drawn by `coopenv.wrench.plot`: docs/concepts/.

python -m benchmarks.site.concepts
"""

import numpy as np

from benchmarks.pages import DOCS
from coopenv import wrench
from coopenv.render import save_png
from coopenv.render.canvas import Picture

FOLDER = DOCS / "concepts"
SIZE, DPI, MARGIN = (4.4, 3.1), 180, 12  # [in], [1/in], [px]
GRIPS = ((-0.9, 0.0), (0.9, 0.0))  # [m], object frame
BEAM = ((-1.0, -0.05), (1.0, -0.05), (1.0, 0.05), (-1.0, 0.05))
# name -> force and torque of the left and of the right agent, object frame [N, N, N·m]
CASES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "together": ((6.0, 0.0, 0.0), (6.0, 0.0, 0.0)),
    "alone": ((8.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    "against": ((9.0, 0.0, 0.0), (-3.0, 0.0, 0.0)),
    "squeeze": ((8.0, 0.0, 0.0), (-8.0, 0.0, 0.0)),
    "couple": ((0.0, -6.0, 0.0), (0.0, 6.0, 0.0)),
    "across": ((6.0, 6.0, 0.0), (6.0, -6.0, 0.0)),
}


def picture(name: str) -> Picture:
    """The split of that case, without the white above and below it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, dpi=DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.88))
    wrench.plot(CASES[name], GRIPS, regions=False, outline=BEAM, legend=False, ax=axes)
    axes.set_axis_off()
    canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[..., :3]
    rows = np.flatnonzero((drawn < 255).any(axis=(1, 2)))
    return np.ascontiguousarray(drawn[max(rows[0] - MARGIN, 0) : rows[-1] + MARGIN])


def main() -> None:
    """Draw all cases."""
    FOLDER.mkdir(exist_ok=True)
    for name in CASES:
        path = FOLDER / f"{name}.png"
        save_png(path, picture(name))
        print(path.relative_to(DOCS.parent))


if __name__ == "__main__":
    main()
