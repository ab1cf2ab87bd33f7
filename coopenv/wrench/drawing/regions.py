"""Where manipulation forces of plausible splits lie in the plane: discs, bands and their lens."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.grasp import moment, sum_at_centre

CORNERS = 240  # of the polygon that stands for a disc
SLACK = 1e-9  # of the largest force or torque, so that a band of no width keeps its line


def disc(force: FloatArray) -> FloatArray:
    """Corners ``(k, 2)`` of the disc with the diameter from 0 to a force (eq. 9) [N]."""
    angles = np.linspace(0.0, 2 * np.pi, CORNERS, endpoint=False)
    # a corner lies on the force itself, another on 0
    angles += np.arctan2(force[1], force[0])
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return 0.5 * force + 0.5 * np.linalg.norm(force) * circle


def disc_and_band(applied: FloatArray, grips: FloatArray, effector: int) -> FloatArray:
    """Corners of what one effector's own bounds (9) and (10) leave for f_M,i [N]."""
    force, grip = applied[effector, :2], grips[effector]
    inside = _within(disc(force), *_band(force, grip), _slack(applied, grips))
    return inside if len(inside) else force[None, :].copy()


def feasible_forces(applied: FloatArray, grips: FloatArray) -> FloatArray:
    """Corners of all f_M,1 of plausible splits of a pair, f_M,2 = f_o − f_M,1 (eqs. 9-11) [N].

    A point or a line where that is all there is; what was applied always belongs to it.
    """
    total = applied[:, :2].sum(axis=0)
    slack = _slack(applied, grips)
    polygon = disc_and_band(applied, grips, 0)
    for normal, low, high in _halves(total - disc(applied[1, :2])):
        polygon = _within(polygon, normal, low, high, slack)
    normal, low, high = _band(applied[1, :2], grips[1])
    reach = float(normal @ total)
    polygon = _within(polygon, normal, reach - high, reach - low, slack)
    polygon = _within(polygon, *_torques(applied, grips), slack)
    return polygon if len(polygon) else applied[:1, :2].copy()


def _band(force: FloatArray, grip: FloatArray) -> tuple[FloatArray, float, float]:
    """Normal and ends of the band of forces that induce no more torque than was (eq. 10)."""
    normal = np.array([-grip[1], grip[0]])  # r × p = normal · p
    torque = float(normal @ force)
    return normal, min(torque, 0.0), max(torque, 0.0)


def _torques(applied: FloatArray, grips: FloatArray) -> tuple[FloatArray, float, float]:
    """The band of f_M,1 that leave a torque which pure torques can supply (eqs. 11, 18)."""
    first, second = (np.array([-y, x]) for x, y in grips)
    wanted = float(sum_at_centre(applied, grips)[2]) - float(second @ applied[:, :2].sum(axis=0))
    low, high = np.minimum(applied[:, 2], 0.0).sum(), np.maximum(applied[:, 2], 0.0).sum()
    return first - second, wanted - float(high), wanted - float(low)


def _halves(polygon: FloatArray) -> list[tuple[FloatArray, float, float]]:
    """A convex polygon as half-planes; none for a point, whose only force is decided elsewhere."""
    centre = polygon.mean(axis=0)
    radius = np.linalg.norm(polygon - centre, axis=-1).max()
    if radius == 0.0:
        return [(axis, float(axis @ centre), float(axis @ centre)) for axis in np.eye(2)]
    edges = np.roll(polygon, -1, axis=0) - polygon
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    normals *= np.sign(((polygon - centre) * normals).sum(axis=-1, keepdims=True))
    ends = (polygon * normals).sum(axis=-1)
    return [(n, -np.inf, float(end)) for n, end in zip(normals, ends, strict=True)]


def _within(
    polygon: FloatArray, normal: FloatArray, low: float, high: float, slack: float
) -> FloatArray:
    """A convex polygon ``(k, 2)`` cut to low ≤ normal · p ≤ high."""
    for sign, end in ((1.0, high), (-1.0, -low)):
        if np.isfinite(end) and len(polygon):
            polygon = _cut(polygon, sign * normal, end + slack)
    return polygon


def _cut(polygon: FloatArray, normal: FloatArray, end: float) -> FloatArray:
    """The part of a convex polygon where normal · p ≤ end (Sutherland & Hodgman)."""
    beyond = polygon @ normal - end
    kept: list[FloatArray] = []
    for i, place in enumerate(beyond):
        j = (i + 1) % len(polygon)
        if place <= 0.0:
            kept.append(polygon[i])
        if (place < 0.0 < beyond[j]) or (beyond[j] < 0.0 < place):
            part = place / (place - beyond[j])
            kept.append(polygon[i] + part * (polygon[j] - polygon[i]))
    return np.array(kept).reshape(-1, 2)


def _slack(applied: FloatArray, grips: FloatArray) -> float:
    sizes = (np.abs(applied).max(), np.abs(moment(grips, applied)).max())
    return SLACK * float(max(sizes))
