"""Pictures of a recorded trial in space: the object as its grips tell, seen from above and aside.

Drawn without perspective, so that lengths along one direction are the same everywhere. A floor
below, with the object's shadow, tells how high it is.
"""

from math import ceil

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.render.canvas import Pen, Picture, around, arrow
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
    SHADOW,
    SHAFT,
    agent_color,
)
from coopenv.render.recorded import RecordedScene

AZIMUTH, ELEVATION = np.radians((-60.0, 25.0))  # [rad] from where it is looked at
THICKNESS = 0.08  # of the spokes drawn, per its reach
ARC = 0.28  # [reach] radius of the arrow that stands for a torque


def view(azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> FloatArray:
    """How points of space are seen: ``(2, 3)``, right and up; z is always up.

    >>> np.round(view(-np.pi / 2, 0.0), 12) + 0.0
    array([[1., 0., 0.],
           [0., 0., 1.]])
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    low, high = np.cos(elevation), np.sin(elevation)
    return np.array([[-s, c, 0.0], [-c * high, -s * high, low]])


class SpaceStage(RecordedScene):
    """Draws rows of a recording in space.

    What was held is not recorded: it is drawn as spokes from the centre of mass to the grips.
    A force is an arrow at its grip, a torque an arrow round its axis, and in the applied ones is
    what is internal of them. The longest arrow is the largest force of the recording.

    Parameters
    ----------
    position
        ``(T, 3)`` of the centre of mass, world frame [m]; NaN in rows that are not shown.
    rotation
        ``(T, 3, 3)`` from the object's frame to the world's.
    grips
        ``(n, 3)`` or ``(T, n, 3)`` object frame [m].
    applied, internal
        ``(T, n, 6)`` object frame [N, N·m]; NaN in rows of which only the pose is shown.
    width
        Of the picture [px].

    Raises
    ------
    InvalidInput
        If no row has a pose.
    """

    def __init__(
        self,
        position: FloatArray,
        rotation: FloatArray,
        grips: FloatArray,
        applied: FloatArray,
        internal: FloatArray,
        *,
        width: int = 480,
    ):
        pose = np.concatenate([position, rotation.reshape(len(position), -1)], axis=1)
        columns = "x, y, z and qw, qx, qy, qz"
        super().__init__(pose, grips, applied, internal, pose_columns=columns)
        self._position, self._rotation = position, rotation
        self._view = view()
        known = position[self._known]
        self._bottom = float(known[:, 2].min()) - self._reach  # of the floor [m]
        self._lay_floor(np.concatenate([known, self._below(known)]) @ self._view.T, width)

    def _seen(self, points: object) -> FloatArray:
        """Points of the world frame [m] in the picture [px]."""
        return self._floor.pixels(np.asarray(points, dtype=np.float64) @ self._view.T)

    def _far_first(self, grips: FloatArray) -> list[int]:
        towards = np.cross(*self._view)  # to where it is looked at from
        return np.argsort(grips @ towards, kind="stable").tolist()

    def _below(self, points: FloatArray) -> FloatArray:
        """On the floor, right under points of the world frame."""
        return np.concatenate([points[..., :2], np.full_like(points[..., 2:], self._bottom)], -1)

    def _paint(self) -> Picture:
        """Floor, its grid, the shadow of the centre of mass on its way, legend."""
        canvas, unit = self._canvas, self._unit
        height, width = self.size
        canvas.fill((0, 0, width, height), PAGE)
        canvas.fill((0, 0, width, self._floor.height), FLOOR)
        known, step = self._position[self._known], self._floor.step
        first = np.floor((known[:, :2].min(axis=0) - self._reach) / step).astype(int)
        last = np.ceil((known[:, :2].max(axis=0) + self._reach) / step).astype(int)
        ways = [self._seen(known), self._seen(self._below(known))]
        with canvas.fine((0, 0, width, self._floor.height)) as pen:
            for k in range(first[0], last[0] + 1):
                self._grid_line(pen, [(k, first[1]), (k, last[1])])
            for k in range(first[1], last[1] + 1):
                self._grid_line(pen, [(first[0], k), (last[0], k)])
            for way, color in zip(ways, (MARK, SHADOW), strict=True):
                moves = np.hypot(*np.diff(np.rint(way), axis=0, prepend=np.inf).T) > 0
                pen.line(way[moves], 1.4 * unit, color)
        self._floor.write_legend(*self._largest)
        return canvas.pixels.copy()

    def _grid_line(self, pen: Pen, ends: list[tuple[int, int]]) -> None:
        step = self._floor.step
        line = self._seen([(step * x, step * y, self._bottom) for x, y in ends])
        pen.line(line, max(self._unit, 1), GRID)

    def _draw(self, row: int) -> None:
        center, turn = self._position[row], self._rotation[row]
        grips = center + self._grips[row] @ turn.T
        self._draw_object(center, grips)
        for agent in self._far_first(grips):
            self._draw_wrench(agent, grips[agent], self._wrenches[:, row, agent], turn)

    def _draw_object(self, center: FloatArray, grips: FloatArray) -> None:
        unit, hub = self._unit, self._seen(center)
        half = THICKNESS * self._reach * self._floor.scale / 2 + 3 * unit
        tips, shadow_hub = self._seen(grips), self._seen(self._below(center))
        shadows = self._seen(self._below(grips))
        with self._canvas.fine(around([tips, hub, shadows, shadow_hub], half + 3 * unit)) as pen:
            for shadow in shadows:
                pen.line([shadow_hub, shadow], half, SHADOW)
            pen.line([hub, shadow_hub], max(unit, 1), SHADOW)
            for grown, color in ((1.6 * unit, EDGE), (0.0, BODY)):
                for tip in tips:
                    pen.line([hub, tip], 2 * (half + grown), color)
            pen.disc(hub, 2.5 * unit, EDGE)

    def _draw_wrench(
        self, agent: int, grip: FloatArray, wrenches: FloatArray, turn: FloatArray
    ) -> None:
        """The grip of an agent, and at it the applied wrench with the internal one in it."""
        unit, place = self._unit, self._seen(grip)
        dark, bright = (
            self._shapes(grip, turn @ wrench[:3], turn @ wrench[3:], width * unit)
            for wrench, width in zip(wrenches, (SHAFT, CORE), strict=True)
        )
        with self._canvas.fine(around([place, *dark, *bright], 10 * unit)) as pen:
            for shape in dark:
                pen.line(shape, 2 * unit, FLOOR, closed=True)  # sets it off from the object
            for shapes, color in ((dark, APPLIED), (bright, INTERNAL)):
                for shape in shapes:
                    pen.polygon(shape, color)
            for radius, color in ((7, EDGE), (5.8, PAGE), (4.6, agent_color(agent))):
                pen.disc(place, radius * unit, color)

    def _shapes(
        self, grip: FloatArray, force: FloatArray, torque: FloatArray, width: float
    ) -> list[FloatArray]:
        """Outlines [px] of a force and of a torque; negligible ones are left out."""
        shapes, place = [], self._seen(grip)
        largest_force, largest_torque = (largest or 1.0 for largest in self._largest)
        along = self._seen(grip + 0.8 * self._reach / largest_force * force) - place
        if np.hypot(*along) > 2 * self._unit:
            shapes.append(arrow(place, along, width))
        sweep = FULL_TURN * float(np.linalg.norm(torque)) / largest_torque
        if sweep > 0.3:
            shapes.append(self._arc(grip, torque, sweep, 0.65 * width))
        return shapes

    def _arc(self, grip: FloatArray, torque: FloatArray, sweep: float, width: float) -> FloatArray:
        """Outline of an arrow that goes round the axis of a torque by the right hand's rule."""
        axis = torque / np.linalg.norm(torque)
        side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        side /= np.linalg.norm(side)
        other, radius = np.cross(axis, side), ARC * self._reach
        neck = sweep - min(3 * width / (radius * self._floor.scale), sweep / 2)
        angles = np.linspace(0.0, neck, 2 + ceil(5 * sweep))
        ring = radius * (np.outer(np.cos(angles), side) + np.outer(np.sin(angles), other))
        return _thick(self._seen(grip + ring), width)


def _thick(line: FloatArray, width: float) -> FloatArray:
    """Outline of an arrow along a line ``(k, 2)`` [px], as thick where it is seen edgewise."""
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    across = width * along[:, ::-1] * (-1, 1)
    end, tip = line[-1], line[-1] + 3 * width * along[-1]
    head = [end + 1.6 * across[-1], tip, end - 1.6 * across[-1]]
    return np.array([*(line + across / 2), *head, *(line - across / 2)[::-1]])
