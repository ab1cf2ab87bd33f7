"""Campaign of wrenches of every family and scale, against bounds, other solvers and 60 digits.

What docs/reliability.md and docs/decomposition.md promise is looked at sample by sample. Where
levers and torques differ by many decades, or forces nearly agree there, the pages name exceptions:
solvers may then contradict each other, which is counted as `outside_gap`, up to a looser bound.
"""

from pathlib import Path

import numpy as np

from benchmarks.soak.drawn.problems import Problem, any_problems
from coopenv import wrench
from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import Decomposition
from coopenv.wrench.pair import on_axis
from tests.wrench.pair.reference import least_cost

NAME = "wrenches"
SHARE = 0.12
COUNT, FEW = 200, 4  # wrenches of a family for the solver that `auto` takes, and for others
MISSING = {"pair": 1e-11, "structured": 1e-8, "conic": 1e-9}  # in parts of the wrench, at 1 m
CLOSEST = 1e-14  # of the longest lever: closer grips may count as one, by rounding
EXACT = 1e-13  # of J(h), beside 60 digits
AGREED, AGREED_AT_ALL = 1e-9, 1e-2  # of J(h), beyond both gaps: ordinary ones, and all others


def trial(seed: int, folder: Path) -> dict[str, int]:
    """All families once, at one number of effectors, one dimension and one scale."""
    rng = np.random.default_rng([2, seed])
    weight = float(rng.choice([0.05, 0.5, 0.95, rng.uniform(0.02, 0.98)]))
    cost = {"torque_weight": weight, "include_induced": bool(rng.random() < 0.5)}
    counts = {"wrenches": 0, "by_other_solvers": 0, "outside_gap": 0, "exact": 0}
    problems = list(any_problems(rng, COUNT))
    for problem in problems:
        found = wrench.decompose(problem.applied, problem.grips, **cost)
        check(found, problem)
        counts["wrenches"] += len(problem.applied)
        for solver in ("structured", "conic") if problem.is_pair else ("conic",):
            few = problem._replace(applied=problem.applied[:FEW])
            other = wrench.decompose(few.applied, few.grips, solver=solver, **cost)
            check(other, few)
            counts["by_other_solvers"] += len(few.applied)
            counts["outside_gap"] += compare(found, other, few)
    pairs = [problem for problem in problems if problem.is_pair and as_given(problem.grips)]
    if pairs:
        check_exact(pairs[rng.integers(len(pairs))], **cost)
        counts["exact"] += 1
    return counts


def check(found: Decomposition, problem: Problem) -> None:
    """Raise unless the answer is finite, balances, is plausible, and knows what it may be off."""
    place = f"{found.solver}: {problem.name}"
    for name in ("manipulation", "cost", "gap", "relative_cost", "internal_force_level"):
        assert np.isfinite(getattr(found, name)).all(), f"{place}: {name} is not finite"
    lever = max(1.0, np.abs(problem.grips).max())
    size = np.maximum(np.abs(problem.applied).max(axis=(-2, -1)), 1e-300) * lever
    missing = np.max(found.residuals(), axis=0) / size
    told(missing <= MISSING[found.solver], missing, f"{place}: residual of the wrench's", problem)
    told(found.gap >= 0, found.gap, f"{place}: a gap of", problem)
    over = (found.gap - found.cost) / found.applied_cost.clip(1e-300)
    told(over <= 1e-12, over, f"{place}: a gap beyond the cost by", problem)
    dearer = (found.cost - found.gap - found.applied_cost) / found.applied_cost.clip(1e-300)
    told(dearer <= 1e-12, dearer, f"{place}: the gap leaves it dearer than no split by", problem)


def compare(found: Decomposition, other: Decomposition, problem: Problem) -> int:
    """Raise where two solvers contradict each other; how many do within what is documented.

    A gap of the whole cost says that nothing is known, and contradicts nobody.
    """
    if not problem.apart:
        return 0
    few = len(problem.applied)
    unit = other.applied_cost.clip(1e-300)
    beyond = np.abs(found.cost[:few] - other.cost) - found.gap[:few] - other.gap
    known = (found.gap[:few] < found.cost[:few]) & (other.gap < other.cost)
    beyond = np.where(known | (beyond <= 0.0), beyond, 0.0)
    allowed = AGREED if problem.ordinary else AGREED_AT_ALL
    place = f"{found.solver} and {other.solver}: {problem.name}"
    told(beyond / unit <= allowed, beyond / unit, f"{place}: beyond both gaps by", problem)
    return int((beyond / unit > AGREED).sum())


def check_exact(problem: Problem, torque_weight: float, include_induced: bool) -> None:
    """Raise unless the first wrench of a planar pair costs what 60 digits say."""
    applied, grips = problem.applied[0], problem.grips
    found = wrench.decompose(
        applied, grips, torque_weight=torque_weight, include_induced=include_induced
    )
    exact = least_cost(applied, grips, torque_weight, include_induced)
    off = np.abs(found.cost - exact) - found.gap
    unit = found.applied_cost.clip(1e-300)
    told(off / unit <= EXACT, off / unit, f"60 digits: {problem.name}: beyond the gap by", problem)


def as_given(grips: FloatArray) -> bool:
    """Whether the grips count as they are: not as one place, nor as on a line with the centre.

    On such a line the reference needs it along an axis of coordinates: elsewhere its own rounding
    leaves what is exactly on the rim of a ball.
    """
    (x1, y1), (x2, y2) = grips
    apart, longest = np.hypot(x1 - x2, y1 - y2), np.hypot(*grips.T).max()
    if apart <= CLOSEST * longest:
        return apart == 0
    return x1 == x2 == 0 or y1 == y2 == 0 or not on_axis.applies(grips)


def told(holds: BoolArray | np.bool_, value: FloatArray, what: str, problem: Problem) -> None:
    """Raise with the value and the wrench of the first sample for which it does not hold."""
    if not np.all(holds):
        first = int(np.argmin(np.atleast_1d(holds)))
        applied = problem.applied[first].tolist()
        raise AssertionError(
            f"{what} {np.atleast_1d(value)[first]:.1e}\n"
            f"applied = {applied}\ngrips = {problem.grips.tolist()}"
        )
