"""Optimal method: the cheapest plausible wrench of the same resultant, and its registry of solvers.

minimise  J(h_M) = Σ_i (1−w)‖f_M,i‖ + s·w‖t_fM,i‖ + w‖t_M,i‖    (eq. 17)
subject to  G h_M = G h  and every part of h_M in the ball over the same part of h  (eqs. 18-21)
"""

from functools import partial

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, in_rows
from coopenv.wrench.answer import Answer, Prepare, Prepared, Solve
from coopenv.wrench.methods import close_grips
from coopenv.wrench.pair import solver as pair
from coopenv.wrench.settings import Settings


def _structured(grips: FloatArray, settings: Settings) -> Solve:
    """Prepare `structured`, which asks others for what it cannot resolve or certify.

    Of two planar effectors whose grips nearly coincide that is `pair`, otherwise `conic`.
    """
    from coopenv.wrench.conic import solver as conic  # here, as many programs need neither
    from coopenv.wrench.structured import solver as structured

    close = close_grips.nearly_coincide(grips) if pair.applies(grips) else np.zeros((), np.bool_)
    if close.all():
        return partial(_taken_over, pair.prepare(grips, settings))
    if close.any():
        return partial(_structured_or_pair, close, grips, settings)
    solve = structured.prepare(grips, settings, conic.prepare)
    return close_grips.with_rounding_counted(solve, grips, settings)


def _taken_over(solve: Solve, applied: FloatArray) -> Answer:
    """Answer of another solver, marked as such."""
    answer = solve(applied)
    batch = answer.manipulation.shape[:-2]
    gap = np.zeros(batch) if answer.gap is None else answer.gap
    return Answer(answer.manipulation, gap, np.ones(batch, dtype=np.bool_))


def _structured_or_pair(
    close: BoolArray, grips: FloatArray, settings: Settings, applied: FloatArray
) -> Answer:
    """Answer of `pair` where grips are close, of `structured` elsewhere."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    wrenches, places = in_rows(applied, batch), in_rows(grips, batch)
    own = np.broadcast_to(close, batch).ravel()
    manipulation, gap = np.empty(wrenches.shape), np.empty(len(wrenches))
    fell_back = np.empty(len(wrenches), dtype=np.bool_)
    for some in (own, ~own):
        answer = _structured(places[some], settings)(wrenches[some])
        manipulation[some], gap[some], fell_back[some] = answer
    shape = (*batch, *applied.shape[-2:])
    return Answer(manipulation.reshape(shape), gap.reshape(batch), fell_back.reshape(batch))


def _conic(grips: FloatArray, settings: Settings) -> Solve:
    """Prepare `conic`."""
    from coopenv.wrench.conic import solver as conic

    return close_grips.with_rounding_counted(conic.prepare(grips, settings), grips, settings)


SOLVERS: dict[str, Prepare] = {
    "pair": pair.prepare,
    "structured": _structured,
    "conic": _conic,
}


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Choose the fastest exact solver for these grips, or take the one that was asked for."""
    name = settings.solver
    if name == "auto":
        name = "pair" if pair.applies(grips) else "structured"
    return Prepared(name, SOLVERS[name](grips, settings))
