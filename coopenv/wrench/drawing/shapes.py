"""Outlines of arrows, straight and round, as polygons in the plane."""

import numpy as np

from coopenv.arrays import FloatArray

HEAD = 3.4  # length of a head, in widths of the shaft
SPREAD = 1.45  # half a head's width, in widths of the shaft
MOST = 0.7  # of an arrow may be its head


def arrow(start: FloatArray, vector: FloatArray, width: float) -> FloatArray:
    """Corners ``(7, 2)`` of an arrow whose tip is at ``start + vector`` [m].

    ``vector`` must not be zero. A short arrow is thinner, so that it keeps its form.
    """
    length = float(np.linalg.norm(vector))
    width = min(width, MOST * length / HEAD)
    along = vector / length
    left = np.array([-along[1], along[0]])
    neck = length - HEAD * width
    half, spread = 0.5 * width, SPREAD * width
    corners = [(0, half), (neck, half), (neck, spread), (length, 0)]
    corners += [(neck, -spread), (neck, -half), (0, -half)]
    return np.array([start + a * along + b * left for a, b in corners])


def round_arrow(
    centre: FloatArray, radius: float, start: float, sweep: float, width: float
) -> FloatArray:
    """Corners ``(k, 2)`` of an arrow along a circle, from angle ``start`` on over ``sweep`` [rad].

    ``sweep`` must not be zero; its sign is the sense of rotation, its end the tip of the arrow.
    """
    turn, size = np.sign(sweep), abs(sweep)
    width = min(width, MOST * size * radius / HEAD)
    neck = size - HEAD * width / radius
    angles = start + turn * np.linspace(0.0, neck, 2 + int(neck / 0.05))
    outer = _on_circle(radius + 0.5 * width, angles)
    inner = _on_circle(radius - 0.5 * width, angles[::-1])
    head = np.concatenate(
        [
            _on_circle(radius + SPREAD * width, angles[-1:]),
            _on_circle(radius, np.array([start + sweep])),
            _on_circle(radius - SPREAD * width, angles[-1:]),
        ]
    )
    return centre + np.concatenate([outer, head, inner])


def _on_circle(radius: float, angles: FloatArray) -> FloatArray:
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
