"""Lens of plausible internal forces of two planar effectors, and the frame it is seen in: kernels.

The internal force is g = (u, v) on effector 1 and −g on effector 2, in a frame whose x axis runs
along the effectors' line. It is plausible inside two discs, with the diameters [0, f_1] and
[0, −f_2]: together they make a lens with a vertex at 0. `on_axis`, `off_axis` and
`prioritized_torque` search it. Forces are in units of the largest component of the wrench.
"""

from math import sqrt

import numpy as np

from coopenv.compiled import TINY, compiled
from coopenv.geometry.frames import rotated, rotated_back

# Columns of a frame, ``axis``
COS, SIN = 0, 1  # direction of the line
FIRST, SECOND = 2, 3  # places of the grips along it [m]
ON_LINE = 4  # columns in all where the line passes through the centre of mass

TIE = 1e-12  # relative surcharge on pure torque: among equal costs the smallest Σ‖t_M‖ wins
LEVEL = 1e-14  # a derivative across the lens this small is rounding
FINE = 1e-17  # by how much the largest component may be off
DISC = 2e-15  # the same for the radius of a disc, where something else is exact
ROUNDING = 4e-16  # of a number, relative to what it is the difference of


@compiled
def nonzero(x):
    """Keep away from 0, on the same side of it."""
    return max(x, TINY) if x >= 0.0 else min(x, -TINY)


@compiled
def chord(v, dx, dy):
    """Extent in u, at height v, of the disc with diameter 0 to (dx, dy); no cancellation."""
    half = 0.5 * abs(dx)
    product = v * (dy - v)
    far = half + sqrt(max(half * half + product, 0.0))
    near = min(-product / max(far, TINY), far)
    return (near, far) if dx >= 0.0 else (-far, -near)


@compiled
def vertex(forces):
    """Height of the lens' second vertex: the foot of the perpendicular from 0 on f_1 to −f_2."""
    f1x, f1y, f2x, f2y = forces
    fx, fy = f1x + f2x, f1y + f2y
    return fx * (f2x * f1y - f2y * f1x) / max(fx * fx + fy * fy, TINY)


@compiled
def _ends(forces):
    """Lowest and highest v in the lens: a vertex, or one disc's end where the other contains it."""
    f1x, f1y, f2x, f2y = forces
    r1, r2 = 0.5 * sqrt(f1x * f1x + f1y * f1y), 0.5 * sqrt(f2x * f2x + f2y * f2y)
    lowest = max(0.5 * f1y - r1, -0.5 * f2y - r2)
    highest = min(0.5 * f1y + r1, -0.5 * f2y + r2)
    second = vertex(forces)
    low, high = min(second, 0.0), max(second, 0.0)
    for sign in (-1.0, 1.0):
        for k in range(2):
            end = 0.5 * f1y + sign * r1 if k == 0 else -0.5 * f2y + sign * r2
            along, across = 0.5 * (f1x + f2x), end + 0.5 * f2y if k == 0 else end - 0.5 * f1y
            distance = along * along + across * across
            radius = r2 if k == 0 else r1
            if distance <= radius * radius * (1.0 + 1e-12):
                low, high = min(low, end), max(high, end)
    return max(low, min(lowest, 0.0)), min(high, max(highest, 0.0))


@compiled
def heights_on_axis(forces, torques, a1, a2):
    """Lowest and highest feasible v of grips on an axis, at the signed levers a1 and a2.

    Induced and pure torques limit v, and the lens where it is narrower.
    """
    _, f1y, _, f2y = forces
    t1, t2 = torques
    lever = a1 - a2
    low, high = -np.inf, np.inf
    if a1 != 0.0:
        low, high = min(f1y, 0.0), max(f1y, 0.0)
    if a2 != 0.0:
        low, high = max(low, min(-f2y, 0.0)), min(high, max(-f2y, 0.0))
    if a1 == 0.0 or a2 == 0.0:
        lens_low, lens_high = _ends(forces)
        low, high = max(low, lens_low), min(high, lens_high)
    divisor = nonzero(lever)
    take = (max(t1, 0.0) + max(t2, 0.0)) / divisor
    give = -(min(t1, 0.0) + min(t2, 0.0)) / divisor
    if lever != 0.0:  # lever·v may take up to all positive, give up to all negative pure torque
        low, high = max(low, min(-take, give)), min(high, max(-take, give))
    return low, high


@compiled
def extent(v, forces):
    """Extent of the lens in u at height v; at its ends rounding may leave none, low > high."""
    f1x, f1y, f2x, f2y = forces
    low1, high1 = chord(v, f1x, f1y)
    low2, high2 = chord(v, -f2x, -f2y)
    return max(low1, low2), min(high1, high2)


@compiled
def rounded_extent(v, forces):
    """`extent` of discs whose radii are larger by `DISC` of the largest component."""
    f1x, f1y, f2x, f2y = forces
    low1, high1 = _rounded_chord(v, f1x, f1y)
    low2, high2 = _rounded_chord(v, -f2x, -f2y)
    return max(low1, low2), min(high1, high2)


@compiled
def _rounded_chord(v, dx, dy):
    """`chord` of a disc whose radius is larger by `DISC`: longer by 2 r `DISC` / chord, or more."""
    low, high = chord(v, dx, dy)
    square = max(0.25 * dx * dx + v * (dy - v), 0.0)
    wider = square + DISC * sqrt(dx * dx + dy * dy)
    more = sqrt(wider) - sqrt(square)
    return low - more, high + more


@compiled
def heron(v, forces):
    """The u where ‖f_M,1‖ + ‖f_M,2‖ is least at height v, in the lens or not."""
    f1x, f1y, f2x, f2y = forces
    rise1, rise2 = abs(f1y - v), abs(f2y + v)
    return f1x - (f1x + f2x) * rise1 / max(rise1 + rise2, TINY)


@compiled
def at_vertex(v, forces):
    """The u of the vertex nearer to v.

    Where an arc is level at a vertex, rounding of v moves its end by the root of itself: no arc
    tells u there, and their mean would be outside the lens by as much.
    """
    f1x, f1y, f2x, f2y = forces
    second = vertex(forces)
    if abs(v) <= abs(v - second):
        return 0.0
    fx, fy = f1x + f2x, f1y + f2y
    return fy * (f2y * f1x - f2x * f1y) / max(fx * fx + fy * fy, TINY)


@compiled
def heron_in_lens(v, forces):
    """The u of `heron`, clipped to the lens."""
    low, high = extent(v, forces)
    if low > high:
        return at_vertex(v, forces)
    return min(max(heron(v, forces), low), high)


@compiled
def resolution(forces, lever):
    """By how much v may be off: rounding of the forces, and of what it makes of the torque."""
    f1x, f1y, f2x, f2y = forces
    largest = max(max(abs(f1x), abs(f1y)), max(abs(f2x), abs(f2y)))
    return FINE * largest / (1.0 + abs(lever))


@compiled
def remainder(torque, supplied):
    """What is left of a torque, 0 where it is rounding."""
    left = torque + supplied
    return left if abs(left) > ROUNDING * abs(torque) else 0.0


@compiled
def in_frame(applied, axis):
    """Forces and torques in the frame of the line, the largest component as unit; and that unit.

    Of ``axis`` it reads `COS` and `SIN`.
    """
    scale = 0.0
    for i in range(2):
        for k in range(3):
            scale = max(scale, abs(applied[i, k]))
    shrink = 1.0 / max(scale, TINY)
    f1x, f1y = rotated_back(axis[COS], axis[SIN], applied[0, 0], applied[0, 1])
    f2x, f2y = rotated_back(axis[COS], axis[SIN], applied[1, 0], applied[1, 1])
    forces = (f1x * shrink, f1y * shrink, f2x * shrink, f2y * shrink)
    return forces, (applied[0, 2] * shrink, applied[1, 2] * shrink), scale


@compiled
def _needed(own, other, torque):
    """Fraction of an effector's torque that is needed: in proportion among those of T's sign."""
    if own * torque <= 0.0:
        return 0.0
    supply = abs(own) + (abs(other) if other * torque > 0.0 else 0.0)
    return min(abs(torque) / max(supply, TINY), 1.0)


@compiled
def write(applied, axis, u, v, torques, torque, scale, manipulation):
    """Write manipulation wrenches: (u, v) off the forces, the pure torque T left to the effectors.

    ``u``, ``v``, ``torques`` and T, ``torque``, are in the frame and unit of `in_frame`.
    """
    t1, t2 = torques
    gx, gy = rotated(axis[COS], axis[SIN], u, v)
    gx, gy = gx * scale, gy * scale
    manipulation[0, 0] = applied[0, 0] - gx
    manipulation[0, 1] = applied[0, 1] - gy
    manipulation[1, 0] = applied[1, 0] + gx
    manipulation[1, 1] = applied[1, 1] + gy
    manipulation[0, 2] = applied[0, 2] * _needed(t1, t2, torque)
    manipulation[1, 2] = applied[1, 2] * _needed(t2, t1, torque)
