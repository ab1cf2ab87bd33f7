"""Bounds of the structured solver where multipliers grow without end."""

from fractions import Fraction

import numpy as np

from coopenv import wrench

NEARLY_A_LINE = [
    [-1.5673514835467413, 9.115746596059694e-14, 3.0895962611418926e-14],
    [-0.19906340855167456, -5.796606139581584e-13, 2.59084979499615e-13],
]
HARDLY_OPPOSED = [
    [-1685.9747715051435, -2885.8496956696777, 8744.057211847, 0.0, 0.0, 0.0],
    [4484.891100827108, 2858.9438329723857, 1315.137141809679, 0.0, 0.0, 0.0],
]
HARDLY_DIFFERENT = [
    [
        2.0990937133873442e-11, -1.9501440173855155e-09, 7.926367844382086e-10,
        7.072531746532744e-09, -6.339648081177431e-09, -8.210224755170691e-09,
    ],
    [
        1.5588140316192096e-11, -1.4482044350679781e-09, 5.886232991991597e-10,
        2.653355630717299e-09, -2.3784044626741058e-09, -3.0801765210155203e-09,
    ],
]  # fmt: skip
COSTS = {"torque_weight": 0.05, "include_induced": True}


def inner(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def crossed(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def nothing_can_be_internal(forces, grips):
    """Whether two forces without torques have no internal part, in exact arithmetic.

    Such a part is g_1 = a d, g_2 = -a d for d = r_1 - r_2, and its inner products with the forces,
    and those of what both induce, are all positive (eqs. 19 and 20).
    """
    (f1, f2), (r1, r2) = ([[Fraction(x) for x in v] for v in pair] for pair in (forces, grips))
    along = [x - y for x, y in zip(r1, r2, strict=True)]
    against = [-x for x in along]
    products = [inner(along, f1), inner(against, f2)]
    products.append(inner(crossed(r1, along), crossed(r1, f1)))
    products.append(inner(crossed(r2, against), crossed(r2, f2)))
    return min(products) < 0 < max(products)


def test_the_bound_allows_for_what_rounding_saves_where_nothing_can_be_internal():
    d = wrench.decompose(HARDLY_OPPOSED, NEARLY_A_LINE, solver="structured", **COSTS)
    assert nothing_can_be_internal(np.array(HARDLY_OPPOSED)[:, :3].tolist(), NEARLY_A_LINE)
    assert d.gap >= 0.0
    assert abs(d.cost - d.applied_cost) <= d.gap + 1e-12 * d.applied_cost


def test_the_bound_is_not_negative_where_forces_hardly_differ():
    grips = [[-1.0, -1.0, 0.0], [0.0, -1.0, -1.0]]
    d = wrench.decompose(HARDLY_DIFFERENT, grips, solver="structured", **COSTS)
    assert 0.0 <= d.gap <= 1e-7 * d.applied_cost
    other = wrench.decompose(HARDLY_DIFFERENT, grips, solver="conic", **COSTS)
    assert abs(d.cost - other.cost) <= d.gap + other.gap + 1e-15 * d.applied_cost
