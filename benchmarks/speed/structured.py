"""The structured solver beside Clarabel, and how often it has to fall back on it.

`conic` is Clarabel with the set-up of its program in Python; "solve alone" is what Clarabel itself
reports. CVXPY with Clarabel, where it is installed, is what a user would write down, its program
compiled afresh for every wrench. One thread each, the compared ones alternating; of the processor
time of several runs the least counts, for others may use the machine.
"""

import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray
from coopenv.wrench.conic import solver as conic
from coopenv.wrench.conic.cone_program import ConeProgram
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured import solver as structured
from coopenv.wrench.structured.batch import ITERATIONS, REPORT, memory_for, solve_batch

SIZES = (2, 3, 4, 10, 100, 1000)
PAPER = {2: "0.4 (beam)", 3: "0.8", 4: "1.1", 10: "2.1"}  # [s], its own machine
REPEATS = 7
SETTINGS = Settings()
NAMES = ("normal", "integer", "no torque", "some zero", "lines", "uneven")


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    return [
        (
            "Effectors in space (targets: ≤ 40 µs at n = 3; 12 × conic, 10 × at 1000)",
            [
                "n",
                "structured [µs]",
                "iterations",
                "per effector and iteration [µs]",
                "agreeing [µs]",
                "conic [µs]",
                "conic / structured",
                "Clarabel's solve alone [µs]",
                "CVXPY + Clarabel [µs]",
                "paper [s]",
            ],
            [_speed(n) for n in SIZES],
        ),
        (
            "Samples in doubt: bound above 1e-7 of J(h), and answer taken from conic",
            ["family", "wrenches", "in doubt", "fell back", "largest bound / J(h)"],
            _doubts(),
        ),
    ]


def _speed(num_effectors: int) -> list[str]:
    rng = np.random.default_rng(num_effectors)
    count = max(2, min(100, 600 // num_effectors))
    grips = rng.normal(size=(num_effectors, 3))
    applied = rng.normal(size=(count, num_effectors, 6))
    agreeing = rng.random((count, num_effectors, 1)) * rng.normal(size=(count, 1, 6))
    few = applied[: max(1, 12 // num_effectors)]
    runs: dict[str, Callable[[], float]] = {
        "ours": lambda: _structured(applied, grips)[0],
        "agreeing": lambda: _structured(agreeing, grips)[0],
        "conic": lambda: _timed(lambda: conic.prepare(grips, SETTINGS)(few)) / len(few),
    }
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(REPEATS if num_effectors < 100 else 3):
        for name, run in runs.items():
            times[name].append(run() * 1e6)
    ours, agree, oracle = (min(times[name]) for name in runs)
    iterations = _structured(applied, grips)[1]
    return [
        f"{num_effectors}",
        f"{ours:,.1f}",
        f"{iterations:.1f}",
        f"{ours / num_effectors / iterations:.2f}",
        f"{agree:,.1f}",
        f"{oracle:,.0f}",
        f"{oracle / ours:.0f} ×",
        f"{_clarabel_alone(few, grips):,.0f}",
        f"{_cvxpy(few[0], grips):,.0f}" if find_spec("cvxpy") else "not installed",
        PAPER.get(num_effectors, ""),
    ]


def _timed(run: Callable[[], Any]) -> float:
    began = time.thread_time()
    run()
    return time.thread_time() - began


def _structured(applied: FloatArray, grips: FloatArray) -> tuple[float, float]:
    """Seconds a sample on one thread, and iterations."""
    manipulation, report = np.empty_like(applied), np.empty((len(applied), REPORT))
    settings = (0.5, 0.0, structured.WANTED_GAP)
    memory = memory_for(applied.shape[1])
    arguments = (applied, grips[None].copy(), *settings, manipulation, report, memory)
    solve_batch(*arguments)
    seconds = _timed(lambda: solve_batch(*arguments))
    return seconds / len(applied), float(report[:, ITERATIONS].mean())


def _clarabel_alone(applied: FloatArray, grips: FloatArray) -> float:
    """Microseconds that Clarabel itself reports a sample."""
    seconds: list[float] = []
    solve = ConeProgram.solve

    def watched(self: ConeProgram, *arguments: Any) -> Any:
        solution = solve(self, *arguments)
        seconds.append(solution.solve_time)
        return solution

    ConeProgram.solve = watched  # pyright: ignore[reportAttributeAccessIssue]
    try:
        conic.prepare(grips, SETTINGS)(applied)
    finally:
        ConeProgram.solve = solve
    return min(seconds) * 1e6


def _cvxpy(applied: FloatArray, grips: FloatArray) -> float:
    """Microseconds for eqs. 17-21 as one would write them down."""
    cp: Any = import_module("cvxpy")
    matrix = wrench.grasp_matrix(grips)

    def solve() -> None:
        h = cp.Variable(applied.shape)
        cost, limits = 0.0, [matrix @ cp.vec(h, order="C") == matrix @ applied.ravel()]
        for i, (x, y, z) in enumerate(grips):
            cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            cost += 0.5 * cp.norm(h[i, :3]) + 0.5 * cp.norm(h[i, 3:])
            for part, own in (
                (h[i, :3], applied[i, :3]),
                (h[i, 3:], applied[i, 3:]),
                (cross @ h[i, :3], cross @ applied[i, :3]),
            ):
                limits.append(cp.norm(part - own / 2) <= np.linalg.norm(own) / 2)
        cp.Problem(cp.Minimize(cost), limits).solve(solver="CLARABEL")

    return min(_timed(solve) for _ in range(3 if len(grips) < 100 else 1)) * 1e6


def _doubts() -> list[list[str]]:
    rows = []
    for name in (*NAMES, "agreeing", "within 1e-9", "within 1e-6", "within 1e-3"):
        rng = np.random.default_rng(0)
        doubt, fell_back = [], []
        for n, dimension in ((2, 2), (3, 2), (3, 3), (6, 3)):
            for include_induced in (False, True):
                grips = rng.normal(size=(n, dimension))
                applied = _family(rng, name, n, dimension)
                d = wrench.decompose(
                    applied, grips, solver="structured", include_induced=include_induced
                )
                doubt.append(d.gap / np.maximum(d.applied_cost, 1e-300))
                fell_back.append(d.fell_back)
        bound, back = np.concatenate(doubt), np.concatenate(fell_back)
        share = f"{(bound > structured.ACCEPTED_GAP).mean():.2%}"
        rows.append([name, f"{len(bound):,}", share, f"{back.mean():.2%}", f"{bound.max():.0e}"])
    return rows


def _family(rng: np.random.Generator, name: str, n: int, dimension: int) -> FloatArray:
    size = (100, n, 3 * dimension - 3)
    force, torque = slice(0, dimension), slice(dimension, None)
    normal = rng.normal(size=size)
    if name == "integer":
        return rng.integers(-2, 3, size=size).astype(float)
    if name == "no torque":
        normal[..., torque] = 0.0
    elif name == "some zero":
        normal *= rng.random((100, n, 1)) < 0.6
    elif name == "lines":
        for part in (force, torque):
            normal[..., part] = normal[..., part][..., :1] * rng.normal(
                size=normal[:, :1, part].shape
            )
    elif name == "uneven":
        normal *= 10.0 ** rng.uniform(-8, 0, size=size)
    elif name != "normal":
        apart = float(name.removeprefix("within ")) if " " in name else 0.0
        for part in (force, torque):
            normal[..., part] = rng.random((100, n, 1)) * normal[:, :1, part]
        normal += apart * rng.normal(size=size)
    return normal
