"""The compiled part of `pair_off_axis`: helpers first; read it from the end."""

from math import sqrt

import numpy as np

from coopenv.compiled import TINY, compiled, gufunc
from coopenv.wrench.pair.bracketed_root import root_of
from coopenv.wrench.pair.on_axis_kernel import (
    LEVEL,
    TIE,
    _in_line,
    _left,
    _resolution,
    _slice,
    _write,
)

ROUNDING = 4e-16  # of a number, relative to what it is the difference of
MAX_HALVINGS = 200  # 60 find a number of ordinary size, the others one of 1e-40


@compiled
def _strip(v, lever, height, torque):
    """Extent in u at height v of the g whose torque lever·v − height·u is between 0 and torque."""
    first, last = lever * v / height, (lever * v - torque) / height
    return min(first, last), max(first, last)


@compiled
def _ends(v, case):
    """Feasible u at height v, from low to high, and which constraint ends it on either side."""
    (f1x, f1y, f2x, f2y), (a1, a2, height), (torque1, torque2), _ = case
    low, high = _slice(v, f1x, f1y)
    at_low, at_high = 0, 0
    for k in range(1, 4):
        if k == 1:
            left, right = _slice(v, -f2x, -f2y)
        elif k == 2:
            left, right = _strip(v, a1, height, torque1)
        else:
            left, right = _strip(v, a2, height, -torque2)
        if left > low:
            low, at_low = left, k
        if right < high:
            high, at_high = right, k
    return low, high, at_low, at_high


@compiled
def _tangent(k, side, v, case):
    """Unit tangent, upwards, to the constraint that ends the feasible set on one side."""
    (f1x, f1y, f2x, f2y), (a1, a2, height), _, _ = case
    if k >= 2:
        lever = a1 if k == 2 else a2
        length = sqrt(lever * lever + height * height)
        sign = 1.0 if height > 0.0 else -1.0
        return sign * lever / length, sign * height / length
    dx, dy = (f1x, f1y) if k == 0 else (-f2x, -f2y)
    radius = max(0.5 * sqrt(dx * dx + dy * dy), TINY)
    half = sqrt(max(0.25 * dx * dx + v * (dy - v), 0.0))
    return side * (0.5 * dy - v) / radius, half / radius


@compiled
def _pull(u, v, case):
    """Derivatives of the costs of forces and induced torques by u and v."""
    (f1x, f1y, f2x, f2y), _, _, (force_weight, along, across, _, _) = case
    x1, y1, x2, y2 = f1x - u, f1y - v, f2x + u, f2y + v
    n1, n2 = max(sqrt(x1 * x1 + y1 * y1), TINY), max(sqrt(x2 * x2 + y2 * y2), TINY)
    return (
        force_weight * (x2 / n2 - x1 / n1) + along,
        force_weight * (y2 / n2 - y1 / n1) + across,
    )


@compiled
def _best(v, low, high, case):
    """The u of least cost at height v, and whether it is at the low (-1) or the high (1) end."""
    if _pull(low, v, case)[0] >= -LEVEL:
        return low, -1
    if _pull(high, v, case)[0] <= LEVEL:
        return high, 1
    (f1x, f1y, f2x, f2y), _, _, (_, along, _, _, _) = case
    rise1, rise2 = abs(f1y - v), abs(f2y + v)
    heron = f1x - (f1x + f2x) * rise1 / max(rise1 + rise2, TINY)
    if along == 0.0:
        return min(max(heron, low), high), 0
    for _ in range(MAX_HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if _pull(middle, v, case)[0] < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high), 0


@compiled
def _slope(v, case):
    """Sign of the derivative of the cost along the path of the best u, at height v.

    Where nothing is feasible it points back to v = 0, which is.
    """
    _, levers, _, (_, _, _, torque_weight, torque) = case
    low, high, at_low, at_high = _ends(v, case)
    if low > high:
        return 1.0 if v > 0.0 else -1.0
    u, side = _best(v, low, high, case)
    by_u, by_v = _pull(u, v, case)
    left = torque + (levers[0] - levers[1]) * v
    by_v += torque_weight if left > 0.0 else -torque_weight
    if side == 0:
        return by_v
    tx, ty = _tangent(at_low if side < 0 else at_high, side, v, case)
    return by_u * tx + by_v * ty


_root = root_of(_slope)


@compiled
def _interval(forces, t1, t2, distance):
    """Lowest and highest v for which both discs and the pure torques may have room."""
    f1x, f1y, f2x, f2y = forces
    r1, r2 = 0.5 * sqrt(f1x * f1x + f1y * f1y), 0.5 * sqrt(f2x * f2x + f2y * f2y)
    low = max(0.5 * f1y - r1, -0.5 * f2y - r2)
    high = min(0.5 * f1y + r1, -0.5 * f2y + r2)
    low = max(low, -(max(t1, 0.0) + max(t2, 0.0)) / distance)
    high = min(high, -(min(t1, 0.0) + min(t2, 0.0)) / distance)
    return min(low, 0.0), max(high, 0.0)


@compiled
def _best_u(v, case):
    """The best u at height v; where rounding leaves none, one in the discs, as strips are steep."""
    low, high, _, _ = _ends(v, case)
    if low <= high:
        return _best(v, low, high, case)[0]
    f1x, f1y, f2x, f2y = case[0]
    low1, high1 = _slice(v, f1x, f1y)
    low2, high2 = _slice(v, -f2x, -f2y)
    left, right = max(low1, low2), min(high1, high2)
    if left > right:
        return 0.5 * (left + right)
    return min(max(0.5 * (low + high), left), right)


@compiled
def _induced(fx, fy, lever, height):
    """Torque that a force induces at the centre of mass, 0 where it is rounding."""
    first, second = lever * fy, height * fx
    torque = first - second
    return torque if abs(torque) > ROUNDING * (abs(first) + abs(second)) else 0.0


@compiled
def _case(forces, torques, axis, weights):
    """All that the search needs: forces, grips, induced torques, and the prices."""
    f1x, f1y, f2x, f2y = forces
    a1, a2, height = axis[2], axis[3], axis[4]
    torque1, torque2 = _induced(f1x, f1y, a1, height), _induced(f2x, f2y, a2, height)
    w, induced = weights[0], weights[0] * weights[1]
    sign1, sign2 = np.sign(torque1), np.sign(torque2)
    prices = (
        1.0 - w,  # of force
        induced * height * (sign1 - sign2),  # of u, for what it induces
        induced * (sign2 * a2 - sign1 * a1),  # of v, for what it induces
        w * (1.0 + TIE) * (a1 - a2),  # of v, for the torque T it leaves
        torques[0] + torques[1],
    )
    return forces, (a1, a2, height), (torque1, torque2), prices


@compiled
def _best_v(case, torques):
    """Height v of least cost."""
    forces, (a1, a2, height), _, _ = case
    low, high = _interval(forces, torques[0], torques[1], a1 - a2)
    if high <= low:
        return low
    lever = max(abs(a1), abs(a2)) + abs(height)
    resolution = _resolution(forces, a1 - a2) * abs(height) / lever
    # the signs at the ends are not asked for: at v = 0, where one may be, all constraints meet
    v = _root(low, -1.0, high, 1.0, case, resolution)
    return v if abs(v) > 2.0 * resolution else 0.0


@gufunc("(n,k),(a),(p)->(n,k)", "void(float64[:,:], float64[:], float64[:], float64[:,:])")
def decompose_off_axis(applied, axis, weights, manipulation):
    """Write the manipulation wrench of one sample.

    ``axis`` is what `frame` says of the grips, ``weights`` are w and s.
    """
    forces, torques, scale = _in_line(applied, axis)
    case = _case(forces, torques, axis, weights)
    v = _best_v(case, torques)
    u = _best_u(v, case)
    torque = _left(torques[0] + torques[1], (axis[2] - axis[3]) * v)
    _write(applied, axis, u, v, torques, torque, scale, manipulation)
