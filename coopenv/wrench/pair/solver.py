"""Solver for two effectors in the plane: the optimum to rounding, by a search on one number.

`on_axis` solves for grips on one line through the centre of mass, `off_axis` for all others. A
batch may hold both.
"""

from functools import partial

import numpy as np

from coopenv.arrays import FloatArray, in_rows
from coopenv.errors import InvalidInput
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.pair import off_axis, on_axis
from coopenv.wrench.settings import Settings


def applies(grips: FloatArray) -> bool:
    """Whether grips ``(..., n, d)`` are two planar positions."""
    return grips.shape[-2:] == (2, 2)


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Check the grips once and return the solver for any number of applied wrenches.

    Parameters
    ----------
    grips
        ``(..., 2, 2)`` [m].
    settings
        Torque weight and whether induced torque is costed.

    Raises
    ------
    InvalidInput
        If the grips are not two or not planar.
    """
    if not applies(grips):
        raise InvalidInput(
            "grips must be two planar positions, of shape (..., 2, 2), for solver='pair', got "
            f"{grips.shape}; use solver='structured'"
        )
    on = on_axis.applies(grips)
    if on.all():
        return on_axis.prepare(grips, settings)
    if not on.any():
        return off_axis.prepare(grips, settings)
    return partial(_solve_both, grips, settings)


def _solve_both(grips: FloatArray, settings: Settings, applied: FloatArray) -> Answer:
    """Solve for grips of which some are on an axis and some are not."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    wrenches, places = in_rows(applied, batch), in_rows(grips, batch)
    manipulation, gap = np.empty(wrenches.shape), np.zeros(len(wrenches))
    on = on_axis.applies(places)
    off = ~on
    manipulation[on] = on_axis.prepare(places[on], settings)(wrenches[on]).manipulation
    answer = off_axis.prepare(places[off], settings)(wrenches[off])
    manipulation[off], gap[off] = answer.manipulation, answer.gap
    return Answer(manipulation.reshape(*batch, *applied.shape[-2:]), gap.reshape(batch))
