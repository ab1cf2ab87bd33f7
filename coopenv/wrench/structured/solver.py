"""Any number of effectors, in the plane or in space, in time linear in their number.

A primal-dual interior-point method (`interior_point`). The effectors are coupled only by the
balance of force and torque, so every Newton step comes down to one system of 6 equations
(`newton`); four effectors are treated at once (`lanes`). Where the forces agree (`agreement`),
which is the most common state of a good team, the feasible set has no interior and the answer is
written down instead; so it is where all that would be internal, 1e-5 of the cost at most, may be
rounding. Every answer is balanced and inside every ball to rounding and carries a bound on its
suboptimality from the dual program (`certificate`). A sample whose bound is worse than 1e-8 is
tried again with shorter, more central steps, balance being taken about the middle of the grips
(`alignment`); one still worse than `ACCEPTED` is also given to `conic`. The answer with the better
bound is kept.

Two effectors in the plane leave one unknown. Off the axis it is closed in on to the last digit
(`pair_off_axis`); the bound is the width of the bracket times the steepest slope of the cost.

The bound speaks of the wrench as it is read: forces and torques below 1e-12 of the largest (1e-14
where a torque's cost is no trifle) are left as applied, which the gap counts, a force within 1e-11
of its lever's direction counts as along it, and balance holds to 1e-13. Where the feasible set is
thin, rounding is worth its root: 1e-8 to 1e-7 of the cost where forces agree but for 1e-10 to 1e-7,
and 1e-6 to 1e-5 where a lever is very short. The answer may be cheaper than the optimum by that
much; the gap contains an estimate of it (`certificate.undercut`).

With levers from 10⁻⁶ to 10⁶ m and torques from 10⁻⁶ to 10⁶ times what they make of the forces, of
320,040 random wrenches one keeps a gap above 1e-7 of the cost; beyond, up to 10¹², one in 3,000.
Where forces agree but for 1e-9, levers of 10² m and more leave gaps of 1e-6 and more (10⁴ m: 1e-4).

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction and the bound are our own.
"""

from functools import partial

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import SolverError
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.conic import solver as conic
from coopenv.wrench.cores import on_all_cores
from coopenv.wrench.pair import off_axis as pair_off_axis
from coopenv.wrench.pair import on_axis as pair
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured.batch import solve_batch

TOLERANCE = 1e-9  # wanted gap, relative to the applied cost
IN_PLANE = (
    1e-12  # the same where one iteration more gets there: flat costs turn ε into √ε of answer
)
WORTH_A_THREAD = 200  # effectors that occupy a core long enough for one to be started
ACCEPTED = 1e-7  # gap up to which an answer is not tried again: `conic` is seldom better


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., n, 2)`` or ``(..., n, 3)`` [m], of any batch shape.
    settings
        Torque weight and whether induced torque is costed.
    """
    pairs = pair_off_axis.applies(grips)
    if pairs.all():
        return pair_off_axis.prepare(grips, settings)
    return partial(_solve_some if pairs.any() else _solve, grips, settings)


def _solve_some(grips: FloatArray, settings: Settings, applied: FloatArray) -> Answer:
    """Solve for planar pairs of which some are on the axis and some are not."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    rows, places = _rows(applied, batch), _rows(grips, batch)
    manipulation, gap = np.empty(rows.shape), np.zeros(len(rows))
    fell_back = np.zeros(len(rows), dtype=np.bool_)
    off_axis = pair_off_axis.applies(places)
    on_axis = ~off_axis
    solve = pair_off_axis.prepare(places[off_axis], settings)
    manipulation[off_axis], gap[off_axis] = solve(rows[off_axis])[:2]
    if settings.solver == "auto":  # as it would choose for these alone
        manipulation[on_axis] = pair.prepare(places[on_axis], settings)(rows[on_axis]).manipulation
    else:
        part = _solve(places[on_axis], settings, rows[on_axis])
        manipulation[on_axis], gap[on_axis], fell_back[on_axis] = part
    shape = (*batch, *applied.shape[-2:])
    return Answer(manipulation.reshape(shape), gap.reshape(batch), fell_back.reshape(batch))


def _solve(grips: FloatArray, settings: Settings, applied: FloatArray) -> Answer:
    """Manipulation wrenches, gaps [N], and where the answer is `conic`'s."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    rows = _rows(applied, batch)
    places = grips.reshape(1, *grips.shape[-2:]) if grips.ndim == 2 else _rows(grips, batch)
    tolerance = IN_PLANE if grips.shape[-1] == 2 else TOLERANCE
    manipulation, report = iterate(rows, places, settings, tolerance)
    gap, applied_cost, undercut = report[:, 0], report[:, 1], report[:, 4]
    fell_back = np.zeros(len(rows), dtype=np.bool_)
    for index in np.flatnonzero(~(gap <= ACCEPTED * applied_cost)):
        place = places[index if len(places) > 1 else 0]
        answer = _fall_back(rows[index], place, settings, gap[index])
        if answer is not None:
            manipulation[index], gap[index] = answer
            fell_back[index], undercut[index] = True, 0.0  # `conic` has counted its own
    gap = gap + undercut
    shape = (*batch, *applied.shape[-2:])
    return Answer(manipulation.reshape(shape), gap.reshape(batch), fell_back.reshape(batch))


def _rows(array: FloatArray, batch: tuple[int, ...]) -> FloatArray:
    """Broadcast to the batch shape, which becomes one contiguous axis."""
    core = array.shape[-2:]
    return np.broadcast_to(array, (*batch, *core)).reshape(-1, *core)


def iterate(
    applied: FloatArray, grips: FloatArray, settings: Settings, tolerance: float = TOLERANCE
) -> tuple[FloatArray, FloatArray]:
    """Solve without falling back, on all cores where that pays; the same bits on any number.

    Parameters
    ----------
    applied
        ``(m, n, 3)`` or ``(m, n, 6)`` [N, N·m].
    grips
        ``(m, n, d)``, or ``(1, n, d)`` for all [m].
    settings
        Torque weight and whether induced torque is costed.
    tolerance
        Gap at which to stop, relative to the applied cost; below `TOLERANCE` only as long as it
        falls fast.

    Returns
    -------
    Manipulation wrenches, and ``(m, 5)``: gap [N], applied cost [N], cost [N], iterations, and by
    how much rounding may have brought the cost below the optimum [N].
    """
    # one signature to compile for: C order, writeable
    applied, grips = (np.require(array, requirements=["C", "W"]) for array in (applied, grips))
    manipulation, report = np.empty(applied.shape), np.empty((len(applied), 5))
    weight, induced = settings.torque_weight, float(settings.include_induced)

    def solve(part: slice) -> None:
        place = grips[part] if len(grips) > 1 else grips
        solve_batch(
            applied[part], place, weight, induced, tolerance, manipulation[part], report[part]
        )

    on_all_cores(solve, len(applied), WORTH_A_THREAD / applied.shape[1])
    return manipulation, report


def _fall_back(
    applied: FloatArray, grips: FloatArray, settings: Settings, gap: float
) -> tuple[FloatArray, float] | None:
    """Answer of `conic` and its own bound; None where that is not below ``gap``."""
    try:
        answer, bound = conic.answers(grips, settings, applied)[:2]
    except SolverError:
        return None
    return (answer, float(bound)) if bound is not None and bound < gap else None
