"""Rim of a plate: its corners, and where a team holds it evenly."""

from math import cos, pi, sin
from typing import Any

import numpy as np

from coopenv.arrays import FARTHEST, FloatArray, positive, stated_array, whole
from coopenv.errors import InvalidInput

_INWARD = 0.9  # of a grip's way from the centre of mass to the rim


def polygon(radius: float, sides: int) -> FloatArray:
    """Corners ``(sides, 2)`` [m] of a regular polygon, the first on the x axis."""
    radius = positive(radius, "radius", unit="m", at_most=FARTHEST)
    sides = whole(sides, "sides", at_least=3, at_most=1000)
    angles = [2 * pi * k / sides for k in range(sides)]
    return radius * np.array([(cos(angle), sin(angle)) for angle in angles])


def rectangle(size: Any) -> FloatArray:
    """Corners ``(4, 2)`` [m] of a rectangle."""
    given = stated_array(size, "size")
    if given.shape != (2,) or (given <= 0).any() or (given > FARTHEST).any():
        raise InvalidInput(
            f"size must be two positive numbers of at most {FARTHEST:g}, got {size!r}; give "
            "metres (x, y)"
        )
    return given / 2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def even_grips(outline: FloatArray, num_agents: int) -> FloatArray:
    """Grips ``(num_agents, 2)`` [m] at equal lengths of rim, 10 % nearer to the centre than it.

    The first is on the positive x axis, the others follow counter-clockwise. ``outline`` is convex
    and holds the origin, its corners in either order.

    Raises
    ------
    InvalidInput
        If ``num_agents`` is not a whole number from 1 to 1000.
    """
    num_agents = whole(num_agents, "num_agents", at_least=1, at_most=1000)
    return np.round(_INWARD * _round_the_rim(outline, num_agents), 12) + 0.0


def _round_the_rim(outline: FloatArray, count: int) -> FloatArray:
    """``count`` points ``(count, 2)`` at equal lengths of rim, from the positive x axis on."""
    (x, y), (x_next, y_next) = outline[0], outline[1]
    if x * y_next - y * x_next < 0:  # clockwise
        outline = outline[::-1]
    y = outline[:, 1]
    first = next(k for k in range(len(outline)) if y[k] >= 0 and y[k - 1] < 0)
    share = y[first] / (y[first] - y[first - 1])  # of the edge that crosses the axis
    start = share * outline[first - 1] + (1 - share) * outline[first]
    path = np.concatenate([[start], np.roll(outline, -first, axis=0), [start]])
    walked = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    stops = walked[-1] * np.arange(count) / count
    return np.stack([np.interp(stops, walked, path[:, k]) for k in range(2)], axis=-1)
