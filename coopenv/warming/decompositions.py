"""Decompositions that make up all that `coopenv.wrench` compiles."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.wrench.methods import METHODS
from coopenv.wrench.methods.optimal import SOLVERS

ON_AN_AXIS = np.array([(-0.9, 0.0), (0.9, 0.0)])  # [m]
OFF_AXIS = np.array([(0.8, 0.3), (-0.5, 0.9)])  # [m]
CLOSE = np.array([(0.8, 0.3), (0.8, 0.3)])  # [m]


def places() -> dict[str, FloatArray]:
    """Grips of a pair in every position, and of teams in the plane and in space [m]."""
    teams = np.random.default_rng(0).normal(size=(3, 3))
    return {
        "a pair on an axis": ON_AN_AXIS,
        "a pair off an axis": OFF_AXIS,
        "a pair at one place": CLOSE,
        "pairs of many kinds": np.stack([ON_AN_AXIS, OFF_AXIS, CLOSE]),
        "a pair in space": teams[:2],
        "a team in the plane": teams[:, :2].copy(),
        "a team in space": teams,
    }


def settings() -> list[wrench.Settings]:
    """Every method, and every solver of the optimal one."""
    methods = [wrench.Settings(method=name) for name in METHODS if name != "optimal"]
    solvers = [wrench.Settings(solver=name) for name in ("auto", *SOLVERS)]
    return [*methods, *solvers, *(replace(one, include_induced=True) for one in solvers)]


def works() -> Iterator[tuple[str, partial[object]]]:
    """What to compile: what it is, and a call that does it or is refused."""
    for (place, grips), one in product(places().items(), settings()):
        solver = "" if one.solver == "auto" else f" by {one.solver}"
        induced = ", induced torques costed" if one.include_induced else ""
        yield f"{one.method}{solver} of {place}{induced}", partial(_compile, grips, one)


def _compile(grips: FloatArray, one: wrench.Settings) -> None:
    wrench.Decomposer(grips, one).compile()
