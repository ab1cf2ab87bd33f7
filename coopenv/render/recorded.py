"""What pictures of a recorded trial share: rows that can be drawn, their size, the floor."""

from abc import ABC, abstractmethod

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput
from coopenv.render.canvas import Picture
from coopenv.render.floor import Floor

REACH = 0.1  # [m] of an object whose grips are all at its centre of mass


class RecordedScene(ABC):
    """Draws rows of a recording on a floor that does not change.

    Arrows are as in `coopenv.render.Renderer`, the longest being the largest force of the
    recording.

    Parameters
    ----------
    pose
        ``(T, ...)`` world frame; NaN in rows that are not shown.
    grips
        ``(n, d)`` or ``(T, n, d)`` object frame [m], d being 2 or 3.
    applied, internal
        ``(T, n, 3)`` or ``(T, n, 6)`` object frame [N, N·m]; NaN in rows of which only the pose is
        shown.
    pose_columns
        What a recording has to have for a pose.

    Raises
    ------
    InvalidInput
        If no row has a pose.
    """

    _floor: Floor

    def __init__(
        self,
        pose: FloatArray,
        grips: FloatArray,
        applied: FloatArray,
        internal: FloatArray,
        *,
        pose_columns: str,
    ):
        rows, dimension = len(pose), grips.shape[-1]
        self._grips = np.broadcast_to(grips, (*applied.shape[:2], dimension))
        self._wrenches = np.nan_to_num(np.stack([applied, internal]))  # nothing drawn where bad
        numbers = [pose.reshape(rows, -1), self._grips.reshape(rows, -1)]
        self._known: BoolArray = np.all(np.isfinite(np.concatenate(numbers, axis=1)), axis=1)
        if not self._known.any():
            raise InvalidInput(
                "pose must be finite in some rows, got none; correct the recording's "
                f"{pose_columns}"
            )
        self._reach = float(np.linalg.norm(self._grips[self._known], axis=-1).max()) or REACH
        sizes = [
            np.linalg.norm(part, axis=-1)
            for part in np.split(self._wrenches[0], [dimension], axis=-1)
        ]
        self._largest = float(sizes[0].max()), float(sizes[1].max())  # force [N], torque [N·m]

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of a picture [px]."""
        return self._floor.size

    def picture(self, row: int) -> Picture:
        """A row, ``(height, width, 3)`` uint8; of one without a pose the floor alone."""
        self._canvas.pixels[:] = self._background
        if self._known[row]:
            self._draw(row)
        return self._canvas.pixels.copy()

    def _lay_floor(self, seen: FloatArray, width: int) -> None:
        """Make room for what is seen ``(K, 2)`` [m], right and up, in a picture that wide [px]."""
        self._floor = Floor(seen, self._reach, width)
        self._canvas, self._unit = self._floor.canvas, self._floor.unit
        self._background = self._paint()

    @abstractmethod
    def _paint(self) -> Picture:
        """What is the same in all rows: floor, grid, way, legend."""

    @abstractmethod
    def _draw(self, row: int) -> None:
        """Object, grips and wrenches of a row."""
