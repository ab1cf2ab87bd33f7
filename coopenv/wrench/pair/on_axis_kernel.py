"""The compiled part of `pair`: helpers first, as compilation needs them; read it from the end."""

from math import sqrt

import numpy as np

from coopenv.compiled import TINY, compiled, gufunc
from coopenv.wrench.pair.bracketed_root import root_of

TIE = 1e-12  # relative surcharge on pure torque: among equal costs the smallest Σ‖t_M‖ wins
LEVEL = 1e-14  # a derivative across the lens this small is rounding
FINE = 1e-17  # by how much the largest may be off
VANISHED = 1e-15  # a force this small, relative to the largest wrench component, has no direction


@compiled
def _nonzero(x):
    """Keep away from 0, on the same side of it."""
    return max(x, TINY) if x >= 0.0 else min(x, -TINY)


@compiled
def _slice(v, dx, dy):
    """Extent in u, at height v, of the disc with diameter 0 to (dx, dy); no cancellation."""
    half = 0.5 * abs(dx)
    product = v * (dy - v)
    far = half + sqrt(max(half * half + product, 0.0))
    near = min(-product / max(far, TINY), far)
    return (near, far) if dx >= 0.0 else (-far, -near)


@compiled
def _vertex(forces):
    """Height of the lens' second vertex: the foot of the perpendicular from 0 on f_1 to −f_2."""
    f1x, f1y, f2x, f2y = forces
    fx, fy = f1x + f2x, f1y + f2y
    return fx * (f2x * f1y - f2y * f1x) / max(fx * fx + fy * fy, TINY)


@compiled
def _lens_extent(forces):
    """Lowest and highest v in the lens: a vertex, or one disc's end where the other contains it."""
    f1x, f1y, f2x, f2y = forces
    r1, r2 = 0.5 * sqrt(f1x * f1x + f1y * f1y), 0.5 * sqrt(f2x * f2x + f2y * f2y)
    lowest = max(0.5 * f1y - r1, -0.5 * f2y - r2)
    highest = min(0.5 * f1y + r1, -0.5 * f2y + r2)
    vertex = _vertex(forces)
    low, high = min(vertex, 0.0), max(vertex, 0.0)
    for sign in (-1.0, 1.0):
        for k in range(2):
            end = 0.5 * f1y + sign * r1 if k == 0 else -0.5 * f2y + sign * r2
            distance = (0.5 * (f1x + f2x)) ** 2
            distance += (end + 0.5 * f2y) ** 2 if k == 0 else (end - 0.5 * f1y) ** 2
            radius = r2 if k == 0 else r1
            if distance <= radius * radius * (1.0 + 1e-12):
                low, high = min(low, end), max(high, end)
    return max(low, min(lowest, 0.0)), min(high, max(highest, 0.0))


@compiled
def _interval(forces, t1, t2, a1, a2, lever):
    """Interval of feasible v: induced torques, pure torques, and the lens where it is narrower."""
    _, f1y, _, f2y = forces
    low, high = -np.inf, np.inf
    if a1 != 0.0:
        low, high = min(f1y, 0.0), max(f1y, 0.0)
    if a2 != 0.0:
        low, high = max(low, min(-f2y, 0.0)), min(high, max(-f2y, 0.0))
    if a1 == 0.0 or a2 == 0.0:
        lens_low, lens_high = _lens_extent(forces)
        low, high = max(low, lens_low), min(high, lens_high)
    divisor = _nonzero(lever)
    take = (max(t1, 0.0) + max(t2, 0.0)) / divisor
    give = -(min(t1, 0.0) + min(t2, 0.0)) / divisor
    if lever != 0.0:  # lever·v may take up to all positive, give up to all negative pure torque
        low, high = max(low, min(-take, give)), min(high, max(-take, give))
    return low, high


@compiled
def _best_u(forces, v):
    """Heron's point, where |f_M,1| + |f_M,2| is least at height v, clipped to the lens."""
    f1x, f1y, f2x, f2y = forces
    low1, high1 = _slice(v, f1x, f1y)
    low2, high2 = _slice(v, -f2x, -f2y)
    low, high = max(low1, low2), min(high1, high2)
    if low > high:  # rounding, at the lens' ends
        return 0.5 * (low + high)
    rise1, rise2 = abs(f1y - v), abs(f2y + v)
    u = f1x - (f1x + f2x) * rise1 / max(rise1 + rise2, TINY)
    return min(max(u, low), high)


@compiled
def _arc(v, dx, dy, side):
    """Right (side 1) or left (-1) end of a disc at height v, and the unit tangent upwards there."""
    left, right = _slice(v, dx, dy)
    radius = max(0.5 * sqrt(dx * dx + dy * dy), TINY)
    tangent_x = side * (0.5 * dy - v) / radius
    tangent_y = sqrt(max(0.25 * dx * dx + v * (dy - v), 0.0)) / radius
    return (right if side > 0.0 else left), tangent_x, tangent_y


@compiled
def _direction(x, y, tangent_x, tangent_y, sign):
    """Unit vector of a force; one that vanishes does so along the tangent."""
    force = sqrt(x * x + y * y)
    per_force = 1.0 / max(force, VANISHED)
    if force > VANISHED:
        return x * per_force, y * per_force
    return sign * tangent_x, sign * tangent_y


@compiled
def _slope(v, case):
    """Derivative of the cost along the path (best u(v), v), of the sign of d cost / d v.

    Where the path runs along an arc it is taken per unit of arc length, which keeps it finite
    where the arc is level.
    """
    forces, weights, piece = case
    f1x, f1y, f2x, f2y = forces
    force_weight, induced1, induced2, torque_weight = weights
    low_is_1, high_is_1, sign1, sign2, sign_torque = piece
    climb = -induced1 * sign1 + induced2 * sign2 + torque_weight * sign_torque
    across1, across2 = f1y - v, f2y + v
    for side in (1.0, -1.0):
        first = high_is_1 if side > 0.0 else low_is_1
        dx, dy = (f1x, f1y) if first else (-f2x, -f2y)
        u, tx, ty = _arc(v, dx, dy, side)
        e1x, e1y = _direction(f1x - u, across1, tx, ty, sign1)
        e2x, e2y = _direction(f2x + u, across2, tx, ty, sign2)
        if side * (e2x - e1x) < -LEVEL:  # the cost falls beyond the arc: the path is on it
            return force_weight * ((e2x - e1x) * tx + (e2y - e1y) * ty) + climb * ty
    along, rise = f1x + f2x, abs(across1) + abs(across2)
    length = sqrt(along * along + rise * rise)
    steepness = (rise + TINY) / (length + TINY)  # 1 where both vanish
    return force_weight * (sign2 - sign1) * steepness + climb


_root = root_of(_slope)


@compiled
def _ordered(a, b):
    return min(a, b), max(a, b)


@compiled
def _edges(forces, low, high, no_torque, a1, a2):
    """Ends and kinks of the cost in ascending order; kinks outside fall on an end."""
    vertex = min(max(_vertex(forces), low), high)
    k1, k2 = _ordered(min(max(no_torque, low), high), vertex)
    if a1 != 0.0 and a2 != 0.0:  # then forces keep their sign across the line, and so does v
        return (low, k1, k2, high, high, high, high)
    no_f1y, no_f2y = min(max(forces[1], low), high), min(max(-forces[3], low), high)
    k3, k4 = _ordered(no_f1y, no_f2y)
    k5 = min(max(0.0, low), high)
    k1, k3 = _ordered(k1, k3)  # merge two sorted pairs,
    k2, k4 = _ordered(k2, k4)
    k2, k3 = _ordered(k2, k3)
    k4, k5 = _ordered(k4, k5)  # and let the fifth sink to its place
    k3, k4 = _ordered(k3, k4)
    k2, k3 = _ordered(k2, k3)
    k1, k2 = _ordered(k1, k2)
    return (low, k1, k2, k3, k4, k5, high)


@compiled
def _piece(forces, applied_torque, lever, v):
    """What stays the same between two kinks: the bounding arcs and the signs of f_y and T."""
    f1x, f1y, f2x, f2y = forces
    low1, high1 = _slice(v, f1x, f1y)
    low2, high2 = _slice(v, -f2x, -f2y)
    sign1 = 1.0 if f1y - v > 0.0 else -1.0
    sign2 = 1.0 if f2y + v > 0.0 else -1.0
    sign_torque = 1.0 if applied_torque + lever * v > 0.0 else -1.0
    return (low1 >= low2, high1 <= high2, sign1, sign2, sign_torque)


@compiled
def _resolution(forces, lever):
    """By how much v may be off: rounding of the forces, and of what it makes of the torque."""
    f1x, f1y, f2x, f2y = forces
    largest = max(max(abs(f1x), abs(f1y)), max(abs(f2x), abs(f2y)))
    return FINE * largest / (1.0 + abs(lever))


@compiled
def _minimise(forces, weights, applied_torque, lever, low, high, no_torque, a1, a2):
    """Minimiser v of the convex cost on [low, high]; exact where it is a kink or an end."""
    edges = _edges(forces, low, high, no_torque, a1, a2)
    for k in range(6):
        left, right = edges[k], edges[k + 1]
        if right <= left:
            continue
        case = forces, weights, _piece(forces, applied_torque, lever, 0.5 * (left + right))
        slope_left = _slope(left, case)
        if slope_left >= 0.0:
            return left
        slope_right = _slope(right, case)
        if slope_right > 0.0:
            resolution = _resolution(forces, lever)
            return _root(left, slope_left, right, slope_right, case, resolution)
    return high


@compiled
def _left(torque, supplied):
    """What is left of a torque, 0 where it is rounding."""
    left = torque + supplied
    return left if abs(left) > 4e-16 * abs(torque) else 0.0


@compiled
def _solve(forces, torques, a1, a2, w, induced):
    """Best internal force (u, v) on effector 1 and the pure torque T that remains needed."""
    t1, t2 = torques
    lever, applied_torque = a1 - a2, t1 + t2
    low, high = _interval(forces, t1, t2, a1, a2, lever)
    weights = (1.0 - w, induced * w * abs(a1), induced * w * abs(a2), w * (1.0 + TIE) * lever)
    v = low
    if high > low:
        no_torque = -applied_torque / _nonzero(lever)
        v = _minimise(forces, weights, applied_torque, lever, low, high, no_torque, a1, a2)
    return _best_u(forces, v), v, _left(applied_torque, lever * v)


@compiled
def _share(own, other, torque):
    """Fraction of an effector's torque that is needed: in proportion among those of T's sign."""
    if own * torque <= 0.0:
        return 0.0
    supply = abs(own) + (abs(other) if other * torque > 0.0 else 0.0)
    return min(abs(torque) / max(supply, TINY), 1.0)


@compiled
def _in_line(applied, axis):
    """Forces and torques in the frame of the line, the largest component as unit; and that unit."""
    scale = 0.0
    for i in range(2):
        for k in range(3):
            scale = max(scale, abs(applied[i, k]))
    shrink = 1.0 / max(scale, TINY)
    c, s = axis[0], axis[1]
    f1x = (c * applied[0, 0] + s * applied[0, 1]) * shrink
    f1y = (c * applied[0, 1] - s * applied[0, 0]) * shrink
    f2x = (c * applied[1, 0] + s * applied[1, 1]) * shrink
    f2y = (c * applied[1, 1] - s * applied[1, 0]) * shrink
    return (f1x, f1y, f2x, f2y), (applied[0, 2] * shrink, applied[1, 2] * shrink), scale


@compiled
def _write(applied, axis, u, v, torques, torque, scale, manipulation):
    """Take the internal force (u, v) off, and leave the pure torque T to the effectors."""
    c, s = axis[0], axis[1]
    t1, t2 = torques
    gx, gy = (c * u - s * v) * scale, (s * u + c * v) * scale
    manipulation[0, 0] = applied[0, 0] - gx
    manipulation[0, 1] = applied[0, 1] - gy
    manipulation[1, 0] = applied[1, 0] + gx
    manipulation[1, 1] = applied[1, 1] + gy
    manipulation[0, 2] = applied[0, 2] * _share(t1, t2, torque)
    manipulation[1, 2] = applied[1, 2] * _share(t2, t1, torque)


@gufunc("(n,k),(a),(p)->(n,k)", "void(float64[:,:], float64[:], float64[:], float64[:,:])")
def decompose_pair(applied, axis, weights, manipulation):
    """Write the manipulation wrench of one sample; all arguments as prepared by `prepare`."""
    forces, torques, scale = _in_line(applied, axis)
    u, v, torque = _solve(forces, torques, axis[2], axis[3], weights[0], weights[1])
    _write(applied, axis, u, v, torques, torque, scale, manipulation)
