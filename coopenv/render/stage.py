"""Pictures of a recorded trial in the plane: the object as its grips tell, and its wrenches."""

from math import ceil, floor

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import moved
from coopenv.render.canvas import Picture, around
from coopenv.render.look import (
    BODY,
    EDGE,
    FLOOR,
    FULL_TURN,
    GRID,
    MARK,
    PAGE,
    chevron,
    draw_wrenches,
)
from coopenv.render.recorded import RecordedScene

THICKNESS = 0.12  # of the object drawn, per its reach


class Stage(RecordedScene):
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
        super().__init__(pose, grips, applied, internal, pose_columns="x, y, theta")
        self._pose = pose
        self._lay_floor(pose[self._known, :2], width)

    def _paint(self) -> Picture:
        """Floor, grid, the way of the centre of mass, legend."""
        canvas, unit, floor_height = self._canvas, self._unit, self._floor.height
        height, width = self.size
        canvas.fill((0, 0, width, height), PAGE)
        canvas.fill((0, 0, width, floor_height), FLOOR)
        step, (low, high) = self._floor.step, self._floor.window
        for k in range(ceil(low[0] / step), floor(high[0] / step) + 1):
            x, _ = self._floor.pixels((k * step, 0.0))
            canvas.fill((x, 0, x + max(unit, 1), floor_height), GRID)
        for k in range(ceil(low[1] / step), floor(high[1] / step) + 1):
            _, y = self._floor.pixels((0.0, k * step))
            canvas.fill((0, y, width, y + max(unit, 1)), GRID)
        way = self._floor.pixels(self._pose[self._known, :2])
        moves = np.hypot(*np.diff(np.rint(way), axis=0, prepend=np.inf).T) > 0
        with canvas.fine((0, 0, width, floor_height)) as pen:
            pen.line(way[moves], 1.4 * unit, MARK)
        self._floor.write_legend(*self._largest)
        return canvas.pixels.copy()

    def _draw(self, row: int) -> None:
        grips = self._floor.pixels(moved(self._grips[row], self._pose[row]))
        self._draw_object(row, grips)
        self._draw_wrenches(row, grips)

    def _draw_object(self, row: int, grips: FloatArray) -> None:
        pose, unit = self._pose[row], self._unit
        center = self._floor.pixels(pose[:2])
        half = THICKNESS * self._reach * self._floor.scale / 2 + 4 * unit
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
        return self._floor.pixels(moved(grips, self._pose[row]))

    def _draw_wrenches(self, row: int, grips: FloatArray) -> None:
        force, torque = (largest or 1.0 for largest in self._largest)
        wrenches, angle = self._wrenches[:, row], float(self._pose[row, 2])
        longest = 0.8 * self._reach * self._floor.scale  # [px]
        turned = moved(wrenches[..., :2], (0.0, 0.0, angle))
        forces = turned * (longest / force) * np.array([1, -1])
        turns = FULL_TURN * wrenches[..., 2] / torque
        outwards = angle + np.arctan2(self._grips[row, :, 1], self._grips[row, :, 0])
        draw_wrenches(self._canvas, grips, forces, turns, outwards, self._unit)
