"""Bounds where forces nearly agree and levers are so long that hardly anything of them decides."""

from decimal import Context, Decimal, localcontext

import numpy as np
import pytest

from coopenv import wrench
from coopenv.arrays import FloatArray
from tests.wrench.structured.cases import agreeing, grips_of_kind

FAR_RING = [
    [395590.03178525, 0.0, 0.0],
    [122244.04262696789, 376228.4775107689, 0.0],
    [-320039.05851959286, 232521.98663728067, 0.0],
    [-320039.0585195929, -232521.98663728058, 0.0],
    [122244.0426269678, -376228.477510769, 0.0],
]
HARDLY_DIFFERENT = [
    [
        -2.8602665970947195e-11, 1.3419605585049196e-11, 1.2776422277983074e-11,
        1.564899806438532e-13, 2.157229522296152e-13, 1.2100349196505663e-13,
    ],
    [
        -7.803915042283556e-11, 3.661388134325961e-11, 3.485902834306484e-11,
        1.9355102871229756e-13, 2.6681196545517587e-13, 1.4966038178633202e-13,
    ],
    [
        -2.3421277749771072e-11, 1.0988636855154856e-11, 1.046196659201834e-11,
        3.035380113623602e-13, 4.184300848785565e-13, 2.3470613916532966e-13,
    ],
    [
        -8.039854409497696e-11, 3.77208457407579e-11, 3.591293757270204e-11,
        1.9670083649739423e-13, 2.711540062411334e-13, 1.520959235601943e-13,
    ],
    [
        -2.8843347096359078e-11, 1.353252668003546e-11, 1.2883931318236697e-11,
        1.6903487545255324e-13, 2.330162096585353e-13, 1.307036393248669e-13,
    ],
]  # fmt: skip
MULTIPLIERS = ["1e3", "1e5", "1e7", "1e9", "1e10", "1e11", "1e13"]  # of Σ f, tried in turn
PARTS = slice(0, 3), slice(3, 6)  # force and torque
PROBLEMS = 15  # of four wrenches, a seed
Vector = list[Decimal]


def inner(a: Vector, b: Vector) -> Decimal:
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))


def length(a: Vector) -> Decimal:
    return inner(a, a).sqrt()


def along(a: Vector) -> Vector:
    return [x / length(a) for x in a]


def crossed(a: Vector, b: Vector) -> Vector:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def at_least(applied: list[list[float]], grips: list[list[float]], weight: float) -> Decimal:
    """What no plausible split costs less than, by weak duality in 60 digits; no induced torque.

    Any multipliers will do: of force along Σ f, of torque along Σ t at the price of torque.
    """
    w = Decimal(weight)
    force, torque = ([[Decimal(x) for x in row[part]] for row in applied] for part in PARTS)
    places = [[Decimal(x) for x in grip] for grip in grips]
    towards, about = (
        along([sum(x, Decimal(0)) for x in zip(*rows, strict=True)]) for rows in (force, torque)
    )
    turn = [w * x for x in about]
    best = Decimal(0)
    for multiplier in map(Decimal, MULTIPLIERS):
        least = Decimal(0)
        for f, t, r in zip(force, torque, places, strict=True):
            seen = zip(towards, along(f), crossed(turn, r), strict=True)
            left = [(1 - w) * own - multiplier * x - lever for x, own, lever in seen]
            least += (1 - w) * length(f) + inner(turn, t)
            least -= (length(left) * length(f) + inner(left, f)) / 2
        best = max(best, least)
    return best


def test_the_bound_owns_up_where_missing_balance_decides_on_all_that_is_saved():
    with localcontext(Context(prec=60)):
        least = float(at_least(HARDLY_DIFFERENT, FAR_RING, 0.95))
    d = wrench.decompose(HARDLY_DIFFERENT, FAR_RING, solver="structured", torque_weight=0.95)
    assert least >= 0.98 * d.applied_cost  # so that next to nothing is internal
    assert d.cost + d.gap >= least
    assert 0.0 <= d.gap <= d.cost


def hardly_different(rng: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray, float]:
    """Wrenches of forces that agree but for rounding, far from the centre of mass.

    Their torques are about what the little that forces differ by makes there, and cost as much.
    """
    num_effectors, dimension = int(rng.integers(3, 9)), int(rng.choice([2, 3]))
    kind = str(rng.choice(["scattered", "ring", "integer"]))
    off, lever = 10.0 ** rng.uniform(-12.0, -7.0), 10.0 ** rng.uniform(1.0, 6.0)
    twisted = lever * off * 10.0 ** rng.uniform(-1.5, 1.5)
    applied = agreeing(rng, count, num_effectors, dimension)
    applied += off * rng.normal(size=applied.shape)
    applied[..., dimension:] *= twisted
    weight = float(np.clip(1.0 / (1.0 + twisted), 1e-3, 0.999))
    return applied, grips_of_kind(rng, kind, num_effectors, dimension) * lever, weight


@pytest.mark.parametrize("seed", range(4))
def test_solvers_agree_within_their_gaps_where_forces_hardly_differ_far_away(seed):
    rng = np.random.default_rng([14, seed])
    for _ in range(PROBLEMS):
        applied, grips, weight = hardly_different(rng, 4)
        ours, other = (
            wrench.decompose(applied, grips, solver=solver, torque_weight=weight)
            for solver in ("structured", "conic")
        )
        assert (ours.gap >= 0.0).all()
        known = (ours.gap < ours.cost) & (other.gap < other.cost)  # else nothing is known
        beyond = np.abs(ours.cost - other.cost) - ours.gap - other.gap
        assert (beyond[known] <= 1e-9 * ours.applied_cost[known]).all()
