"""Pictures of a recorded trial in the plane: the object as its grips tell, and its wrenches."""

from math import ceil, floor, log10

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, whole
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import moved
from coopenv.render.canvas import Canvas, Picture, around, arrow, text_width
from coopenv.render.look import (
    APPLIED,
    BODY,
    CORE,
    EDGE,
    FLOOR,
    FULL_TURN,
    GRID,
    INTERNAL,
    MARK,
    PAGE,
    SHAFT,
    TEXT,
    chevron,
    draw_wrenches,
)

THICKNESS = 0.12  # of the object drawn, per its reach
REACH = 0.1  # [m] of an object whose grips are all at its centre of mass
TALLEST = 1.2  # of a picture's floor, per width
MOST_LINES = 30  # of the floor's grid


class Stage:
    """Draws rows of a recording.

    What was held is not recorded, so it is drawn as its grips tell: a bar through the grips
    and the centre of mass, or the polygon of three grips and more, with a margin. Arrows are as in
    `coopenv.render.Renderer`, the longest being the largest force of the recording.

    Parameters
    ----------
    pose
        ``(T, 3)`` x, y [m], θ [rad]; NaN in rows that are not shown.
    grips
        ``(n, 2)`` or ``(T, n, 2)`` object frame [m].
    applied, internal
        ``(T, n, 3)`` object frame [N, N·m]; NaN in rows of which only the pose is shown.
    width
        Of the picture [px].

    Raises
    ------
    InvalidInput
        If no row has a pose.
    """

    def __init__(
        self,
        pose: FloatArray,
        grips: FloatArray,
        applied: FloatArray,
        internal: FloatArray,
        *,
        width: int = 480,
    ):
        width = whole(width, "width", at_least=160, at_most=16384)
        self._pose = pose
        self._grips = np.broadcast_to(grips, (*applied.shape[:2], 2))
        self._wrenches = np.nan_to_num(np.stack([applied, internal]))  # nothing drawn where bad
        numbers = np.concatenate([pose, self._grips.reshape(len(pose), -1)], axis=1)
        self._known: BoolArray = np.all(np.isfinite(numbers), axis=1)
        if not self._known.any():
            raise InvalidInput(
                "pose must be finite in some rows, got none; correct the recording's x, y, theta"
            )
        self._reach = float(np.linalg.norm(self._grips[self._known], axis=-1).max()) or REACH
        self._unit = min(max(width / 640, 0.6), 3.0)
        self._lay_out(width)
        forces = np.hypot(*self._wrenches[0, ..., :2].reshape(-1, 2).T)
        self._largest = float(forces.max()), float(np.abs(self._wrenches[0, ..., 2]).max())
        self._background = self._paint()

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of a picture [px]."""
        height, width, _ = self._canvas.pixels.shape
        return height, width

    def picture(self, row: int) -> Picture:
        """A row, ``(height, width, 3)`` uint8; of one without a pose the floor alone."""
        self._canvas.pixels[:] = self._background
        if self._known[row]:
            grips = self._pixels(moved(self._grips[row], self._pose[row]))
            self._draw_object(row, grips)
            self._draw_wrenches(row, grips)
        return self._canvas.pixels.copy()

    def _lay_out(self, width: int) -> None:
        """Room for the object wherever it was, with arrows beside it."""
        known = self._pose[self._known, :2]
        margin = 1.7 * self._reach
        low, high = known.min(axis=0) - margin, known.max(axis=0) + margin
        across, up = (high - low).tolist()
        self._scale = min(width / across, TALLEST * width / up)  # [px/m]
        self._floor = round(up * self._scale)
        self._size = max(12, round(17 * self._unit))
        self._row = round(1.4 * self._size)
        height = self._floor + 3 * self._row
        self._center = (low + high) / 2
        self._middle = np.array([width / 2, self._floor / 2])
        self._canvas = Canvas(width, height + height % 2)

    def _paint(self) -> Picture:
        """Floor, grid, the way of the centre of mass, legend."""
        canvas, unit = self._canvas, self._unit
        height, width, _ = canvas.pixels.shape
        canvas.fill((0, 0, width, height), PAGE)
        canvas.fill((0, 0, width, self._floor), FLOOR)
        step = self._grid()
        half = np.array([width, self._floor]) / (2 * self._scale)
        low, high = self._center - half, self._center + half
        for k in range(ceil(low[0] / step), floor(high[0] / step) + 1):
            x, _ = self._pixels((k * step, 0.0))
            canvas.fill((x, 0, x + max(unit, 1), self._floor), GRID)
        for k in range(ceil(low[1] / step), floor(high[1] / step) + 1):
            _, y = self._pixels((0.0, k * step))
            canvas.fill((0, y, width, y + max(unit, 1)), GRID)
        way = self._pixels(self._pose[self._known, :2])
        moves = np.hypot(*np.diff(np.rint(way), axis=0, prepend=np.inf).T) > 0
        with canvas.fine((0, 0, width, self._floor)) as pen:
            pen.line(way[moves], 1.4 * unit, MARK)
        self._write_legend(step)
        return canvas.pixels.copy()

    def _write_legend(self, step: float) -> None:
        canvas, unit, size = self._canvas, self._unit, self._size
        height, width, _ = canvas.pixels.shape
        force, torque = self._largest
        with canvas.fine((0, self._floor, width, height)) as pen:
            x, y = 12 * unit, self._floor + 0.8 * self._row
            for name in ("applied", "internal"):
                along = np.array([25 * unit, 0.0])
                pen.polygon(arrow(np.array([x, y]), along, SHAFT * unit), APPLIED)
                if name == "internal":
                    pen.polygon(arrow(np.array([x, y]), along, CORE * unit), INTERNAL)
                pen.text(x + 32 * unit, y, name, size, TEXT)
                x += 46 * unit + text_width(name, size)
            scale = f"largest {force:.3g} N, {torque:.3g} N·m; grid {step:g} m"
            pen.text(12 * unit, y + self._row, scale, size, TEXT)

    def _draw_object(self, row: int, grips: FloatArray) -> None:
        pose, unit = self._pose[row], self._unit
        center = self._pixels(pose[:2])
        half = THICKNESS * self._reach * self._scale / 2 + 4 * unit
        corners = self._corners(row)
        with self._canvas.fine(around([grips, center], half + 3 * unit)) as pen:
            for grown, color in ((1.6 * unit, EDGE), (0.0, BODY)):
                if len(corners) > 2:
                    pen.polygon(corners, color)
                pen.line(corners, 2 * (half + grown), color, closed=len(corners) > 2)
            chevron(pen, center, float(pose[2]), EDGE, unit)

    def _corners(self, row: int) -> FloatArray:
        """Of the object [px]: grips as they come round the centre of mass; of few it is one."""
        grips = self._grips[row]
        if len(grips) < 3:
            grips = np.insert(grips, 1, 0.0, axis=0)
        else:
            grips = grips[np.argsort(np.arctan2(grips[:, 1], grips[:, 0]), kind="stable")]
        return self._pixels(moved(grips, self._pose[row]))

    def _draw_wrenches(self, row: int, grips: FloatArray) -> None:
        force, torque = (largest or 1.0 for largest in self._largest)
        wrenches, angle = self._wrenches[:, row], float(self._pose[row, 2])
        longest = 0.8 * self._reach * self._scale  # [px]
        turned = moved(wrenches[..., :2], (0.0, 0.0, angle))
        forces = turned * (longest / force) * np.array([1, -1])
        turns = FULL_TURN * wrenches[..., 2] / torque
        outwards = angle + np.arctan2(self._grips[row, :, 1], self._grips[row, :, 0])
        draw_wrenches(self._canvas, grips, forces, turns, outwards, self._unit)

    def _grid(self) -> float:
        """Between lines of the floor [m]: a power of ten, for three to thirty of them."""
        return 10.0 ** ceil(log10(self._canvas.pixels.shape[1] / self._scale / MOST_LINES))

    def _pixels(self, points: object) -> FloatArray:
        """Points of the world frame [m] in the picture [px]."""
        offset = np.asarray(points, dtype=np.float64) - self._center
        return self._middle + self._scale * offset * (1, -1)
