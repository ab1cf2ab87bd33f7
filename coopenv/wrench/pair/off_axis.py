"""Two planar effectors off any line through the centre of mass: the optimum to rounding.

In the frame whose x axis runs along r_1 − r_2 let g = (u, v) be the internal force on effector 1,
−g that on effector 2. Plausible are the g in the lens between the discs with diameters [0, f_1] and
[0, −f_2] and in two strips along the levers (induced torques); v alone decides the torque T(v) left
to the effectors' pure torques. At a given v the feasible u are an interval, on which the cost is
convex. The sign of the derivative along the path of the best u says on which side the minimum lies.
Closing in on where it changes is exact to rounding in v, however flat the cost and however thin the
set. Where costs tie the answer is that of `on_axis`.

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction to one dimension is our own.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import TINY, compiled, gufunc
from coopenv.geometry.frames import rotated_back
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.cores import on_all_cores
from coopenv.wrench.measures import (
    APPLIED_COST,
    INCLUDE_INDUCED,
    TORQUE_WEIGHT,
    cost_weights,
    level_kernel,
    level_parameters,
)
from coopenv.wrench.pair.bracketed_root import root_of
from coopenv.wrench.pair.lens import (
    FIRST,
    LEVEL,
    ROUNDING,
    SECOND,
    TIE,
    at_vertex,
    chord,
    extent,
    heron,
    in_frame,
    remainder,
    resolution,
    rounded_extent,
    write,
)
from coopenv.wrench.settings import Settings

HEIGHT, DISTANCE = 4, 5  # columns of `frame` beside those of `lens`

CLOSE = 1e-2  # of the longest lever: grips so near that the difference of levers loses digits
WORTH_A_THREAD = 1000  # samples that occupy a core long enough for one to be started
MAX_HALVINGS = 200  # 60 find a number of ordinary size, the others one of 1e-40


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., 2, 2)``, none of them on one line through the centre of mass [m].
    settings
        Torque weight and whether induced torque is costed.
    """
    axis = frame(grips)
    weights = cost_weights(settings.torque_weight, settings.include_induced)
    parameters = level_parameters(settings.torque_weight, settings.include_induced, plausible=True)
    reach = np.abs(axis[..., [FIRST, SECOND, HEIGHT]]).max(axis=-1)
    worth = ROUNDING * reach / np.abs(axis[..., HEIGHT])

    def solve(applied: FloatArray) -> Answer:
        """Manipulation wrenches and gaps.

        The minimum of a convex function is bracketed: the gap is how wide the bracket can be in the
        end times how steep the cost. Near the axis a small change of v changes u a lot along the
        levers.
        """
        if axis.ndim == 1 and applied.ndim == 3:
            manipulation = np.empty(applied.shape)

            def solve_part(part: slice) -> None:
                decompose_off_axis(applied[part], axis, weights, manipulation[part])

            on_all_cores(solve_part, len(applied), WORTH_A_THREAD)
        else:
            manipulation = decompose_off_axis(applied, axis, weights)
        levels = level_kernel(applied, manipulation, grips, parameters)
        return Answer(manipulation, worth * levels[..., APPLIED_COST])

    return solve


def frame(grips: FloatArray) -> FloatArray:
    """Direction of r_1 − r_2, both grips along it, the line's height, and the grips' distance.

    ``(..., 6)`` [1, 1, m, m, m, m], of grips ``(..., 2, 2)`` not on a line through the centre of
    mass. The height is that of the centre of mass from the line, the distance from grip to grip.
    The columns are `COS`, `SIN`, `FIRST`, `SECOND`, `HEIGHT` and `DISTANCE`.
    """
    along = grips[..., 0, :] - grips[..., 1, :]
    apart = np.hypot(along[..., 0], along[..., 1])
    c, s = np.moveaxis(along / apart[..., None], -1, 0)
    x, y = grips[..., 0], grips[..., 1]
    levers, heights = rotated_back(c[..., None], s[..., None], x, y)
    a1, a2 = levers[..., 0], levers[..., 1]
    longest = np.hypot(x, y).max(axis=-1)
    distance = np.where(apart < CLOSE * longest, apart, a1 - a2)
    return np.stack([c, s, a1, a2, heights[..., 0], distance], axis=-1)


class Prices(NamedTuple):
    """What a unit costs."""

    force: float  # 1 − w
    along: float  # of u, for what it induces
    across: float  # of v, for what it induces
    torque: float  # of v, for the pure torque T(v) it leaves


class Case(NamedTuple):
    """All that the slope of the cost depends on, beside v."""

    forces: tuple[float, float, float, float]  # f_1 and f_2
    grips: tuple[float, float, float]  # both along the line, and the line's height
    distance: float  # from grip to grip
    induced: tuple[float, float]  # torques of f_1 and f_2
    torque: float  # the pure torques' sum
    prices: Prices


@compiled
def _strip(v, lever, height, torque):
    """Extent in u at height v of the g whose torque lever·v − height·u is between 0 and torque."""
    first, last = lever * v / height, (lever * v - torque) / height
    return min(first, last), max(first, last)


@compiled
def _ends(v, case):
    """Feasible u at height v, from low to high, and which constraint ends it on either side."""
    f1x, f1y, f2x, f2y = case.forces
    a1, a2, height = case.grips
    low, high = chord(v, f1x, f1y)
    at_low, at_high = 0, 0
    for k in range(1, 4):
        if k == 1:
            left, right = chord(v, -f2x, -f2y)
        elif k == 2:
            left, right = _strip(v, a1, height, case.induced[0])
        else:
            left, right = _strip(v, a2, height, -case.induced[1])
        if left > low:
            low, at_low = left, k
        if right < high:
            high, at_high = right, k
    return low, high, at_low, at_high


@compiled
def _tangent(k, side, v, case):
    """Unit tangent, upwards, to the constraint that ends the feasible set on one side."""
    f1x, f1y, f2x, f2y = case.forces
    a1, a2, height = case.grips
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
    f1x, f1y, f2x, f2y = case.forces
    prices = case.prices
    x1, y1, x2, y2 = f1x - u, f1y - v, f2x + u, f2y + v
    n1, n2 = max(sqrt(x1 * x1 + y1 * y1), TINY), max(sqrt(x2 * x2 + y2 * y2), TINY)
    return (
        prices.force * (x2 / n2 - x1 / n1) + prices.along,
        prices.force * (y2 / n2 - y1 / n1) + prices.across,
    )


@compiled
def _best(v, low, high, case):
    """The u of least cost at height v, and whether it is at the low (-1) or the high (1) end."""
    if _pull(low, v, case)[0] >= -LEVEL:
        return low, -1
    if _pull(high, v, case)[0] <= LEVEL:
        return high, 1
    if case.prices.along == 0.0:
        return min(max(heron(v, case.forces), low), high), 0
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
    low, high, at_low, at_high = _ends(v, case)
    if low > high:
        return 1.0 if v > 0.0 else -1.0
    u, side = _best(v, low, high, case)
    by_u, by_v = _pull(u, v, case)
    left = case.torque + case.distance * v
    by_v += case.prices.torque if left > 0.0 else -case.prices.torque
    if side == 0:
        return by_v
    tx, ty = _tangent(at_low if side < 0 else at_high, side, v, case)
    return by_u * tx + by_v * ty


_root = root_of(_slope)


@compiled
def _heights(forces, torques, distance):
    """Lowest and highest v for which both discs and the pure torques may have room."""
    f1x, f1y, f2x, f2y = forces
    t1, t2 = torques
    r1, r2 = 0.5 * sqrt(f1x * f1x + f1y * f1y), 0.5 * sqrt(f2x * f2x + f2y * f2y)
    low = max(0.5 * f1y - r1, -0.5 * f2y - r2)
    high = min(0.5 * f1y + r1, -0.5 * f2y + r2)
    low = max(low, -(max(t1, 0.0) + max(t2, 0.0)) / distance)
    high = min(high, -(min(t1, 0.0) + min(t2, 0.0)) / distance)
    return min(low, 0.0), max(high, 0.0)


@compiled
def _best_u(v, case):
    """The best u at height v; where rounding leaves none, one in the discs, as strips are steep.

    Where a disc is level, its end moves by far more than rounding of v. It is put off by what
    rounding of the forces would do there, so that it does not overrule a strip that is exact.
    """
    low, high, at_low, at_high = _ends(v, case)
    if low <= high:
        return _best(v, low, high, case)[0]
    left, right = extent(v, case.forces)
    if left > right:
        return at_vertex(v, case.forces)
    u = 0.5 * (low + high)
    if at_low <= 1:
        u = high
    elif at_high <= 1:
        u = low
    left, right = rounded_extent(v, case.forces)
    return min(max(u, left), right)


@compiled
def _induced(fx, fy, lever, height):
    """Torque that a force induces at the centre of mass, 0 where it is rounding."""
    first, second = lever * fy, height * fx
    torque = first - second
    return torque if abs(torque) > ROUNDING * (abs(first) + abs(second)) else 0.0


@compiled
def _case(forces, torques, axis, weights):
    """Forces, grips, torques and prices that the search needs."""
    f1x, f1y, f2x, f2y = forces
    a1, a2, height, distance = axis[FIRST], axis[SECOND], axis[HEIGHT], axis[DISTANCE]
    torque1, torque2 = _induced(f1x, f1y, a1, height), _induced(f2x, f2y, a2, height)
    w = weights[TORQUE_WEIGHT]
    induced = w * weights[INCLUDE_INDUCED]
    sign1, sign2 = np.sign(torque1), np.sign(torque2)
    prices = Prices(
        1.0 - w,
        induced * height * (sign1 - sign2),
        induced * (sign2 * a2 - sign1 * a1),
        w * (1.0 + TIE) * distance,
    )
    torque, induced_torques = torques[0] + torques[1], (torque1, torque2)
    return Case(forces, (a1, a2, height), distance, induced_torques, torque, prices)


@compiled
def _best_v(case, torques):
    """Height v of least cost."""
    a1, a2, height = case.grips
    low, high = _heights(case.forces, torques, case.distance)
    if high <= low:
        return low
    lever = max(abs(a1), abs(a2)) + abs(height)
    fine = resolution(case.forces, case.distance) * abs(height) / lever
    # the signs at the ends are not asked for: at v = 0, where one may be, all constraints meet
    v = _root(low, -1.0, high, 1.0, case, fine)
    return v if abs(v) > 2.0 * fine else 0.0


@gufunc("(n,k),(a),(p)->(n,k)", "void(float64[:,:], float64[:], float64[:], float64[:,:])")
def decompose_off_axis(applied, axis, weights, manipulation):
    """Write the manipulation wrench of one sample.

    ``axis`` is what `frame` says of the grips, ``weights`` are those of `cost_weights`.
    """
    forces, torques, scale = in_frame(applied, axis)
    case = _case(forces, torques, axis, weights)
    v = _best_v(case, torques)
    u = _best_u(v, case)
    torque = remainder(case.torque, case.distance * v)
    write(applied, axis, u, v, torques, torque, scale, manipulation)
