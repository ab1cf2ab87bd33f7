"""Room of a picture for what moves about in it: its scale, its canvas, its legend."""

import numpy as np

from coopenv.arrays import FloatArray, whole
from coopenv.render.canvas import Canvas, arrow, text_width
from coopenv.render.look import APPLIED, CORE, INTERNAL, SHAFT, TEXT

TALLEST = 1.2  # of a picture's floor, per width
MOST_LINES = 30  # of the floor's grid
MARGIN = 1.7  # reaches of the object, round it


class Floor:
    """Where on a picture things are seen.

    Parameters
    ----------
    seen
        ``(K, 2)`` wherever the object's centre of mass is [m], right and up as it is seen.
    reach
        Of the object [m].
    width
        Of the picture [px].
    """

    def __init__(self, seen: FloatArray, reach: float, width: int):
        width = whole(width, "width", at_least=160, at_most=16384)
        self.unit = min(max(width / 640, 0.6), 3.0)  # [px] of a line that is just well visible
        low, high = seen.min(axis=0) - MARGIN * reach, seen.max(axis=0) + MARGIN * reach
        across, up = (high - low).tolist()
        self.scale = min(width / across, TALLEST * width / up)  # [px/m]
        self.height = round(up * self.scale)  # [px] of the scene, the legend left out
        self._size = max(12, round(17 * self.unit))
        self._row = round(1.4 * self._size)
        height = self.height + 3 * self._row
        self._center = (low + high) / 2
        self._middle = np.array([width / 2, self.height / 2])
        self.canvas = Canvas(width, height + height % 2)

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of a picture [px]."""
        height, width, _ = self.canvas.pixels.shape
        return height, width

    @property
    def window(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest of what is seen [m]."""
        half = np.array([self.size[1], self.height]) / (2 * self.scale)
        return self._center - half, self._center + half

    @property
    def step(self) -> float:
        """Between lines of a grid [m]: a power of ten, for three to thirty of them."""
        return 10.0 ** np.ceil(np.log10(self.size[1] / self.scale / MOST_LINES))

    def pixels(self, points: object) -> FloatArray:
        """Points as they are seen [m] in the picture [px]."""
        offset = np.asarray(points, dtype=np.float64) - self._center
        return self._middle + self.scale * offset * (1, -1)

    def write_legend(self, force: float, torque: float) -> None:
        """Say which arrow is which, and how long: the largest force [N] and torque [N·m]."""
        unit, size = self.unit, self._size
        height, width = self.size
        with self.canvas.fine((0, self.height, width, height)) as pen:
            x, y = 12 * unit, self.height + 0.8 * self._row
            for name in ("applied", "internal"):
                along = np.array([25 * unit, 0.0])
                pen.polygon(arrow(np.array([x, y]), along, SHAFT * unit), APPLIED)
                if name == "internal":
                    pen.polygon(arrow(np.array([x, y]), along, CORE * unit), INTERNAL)
                pen.text(x + 32 * unit, y, name, size, TEXT)
                x += 46 * unit + text_width(name, size)
            scale = f"largest {force:.3g} N, {torque:.3g} N·m; grid {self.step:g} m"
            pen.text(12 * unit, y + self._row, scale, size, TEXT)
