"""Lengths in another unit: of the pose, of grips, of all that the layout says, or of everything.

Positions and grips are first scaled as they are, which shows the unit; then the recording is read
again with it, as offsets, loads and a tracked origin have lengths too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.body import Body
from coopenv.logs.calibration.load import Load
from coopenv.logs.consistency.known_body.found import Explanation
from coopenv.logs.consistency.known_body.known import Windows
from coopenv.logs.consistency.known_body.misfit import Misfit, reach_of
from coopenv.logs.consistency.known_body.otherwise import Again, Declared
from coopenv.logs.layout import UNITS, Layout

RANK = -1  # likelier than forces in another unit
PLAINLY = 0.5  # of what is left, below which another unit is worth another reading
Units = tuple[str, str]  # of positions and of grips


def lengths(
    windows: Sequence[Windows], layout: Layout, again: Again | None
) -> Iterator[Explanation]:
    """Another unit of lengths, where one would account for more than half of what is left."""
    said = layout if again is None else again.layout
    reach = reach_of(windows)
    plain = _without_lengths(said)
    shares = _shares((again.windows(plain) if again and plain != said else []) or windows, said)
    own = said.length
    best = min(shares, key=lambda units: shares[units])
    if not shares[best] < PLAINLY * shares[own, own]:
        return
    if again is None:
        if own in best or best[0] == best[1]:  # else they are two mistakes
            yield _as_it_is(best, windows, said)
        return
    near = [best] if best[0] == own else [best, (best[0], best[0]), (best[0], own)]
    for units in dict.fromkeys(near):
        declared = list(_declared(units, again))
        yield from again.explanations(declared, reach)
        if not declared and own in units:  # no layout says so
            yield _as_it_is(units, windows, said)


def _shares(windows: Sequence[Windows], layout: Layout) -> dict[Units, float]:
    """`Misfit.share` with positions and grips in every two units, about the point that suits it."""
    body, own = layout.body, layout.factor("length")
    still = [Windows(replace(each.motion, position=0 * each.motion.position)) for each in windows]
    acting, wanted = _both(windows, body)
    torques, weight = _acting_at(windows, body, 0.0), _both(still, body)[1]
    axes = np.eye(3)[: windows[0].motion.dimension] * any(layout.pose.com)
    moved = np.stack([_acting_at(windows, body, 1.0, axis) - acting for axis in axes], axis=-1)
    reach = reach_of(windows)
    made = {}
    for position, first in UNITS["length"].items():
        for grips, second in UNITS["length"].items():
            needs = weight + first / own * (wanted - weight)
            acts = torques + second / own * (acting - torques)
            misfit = Misfit.between(acts, needs, body, (reach, reach * second / own))
            best = _about_another_point(misfit, moved)
            made[position, grips] = np.inf if misfit.is_still() else misfit.share(best)
    return made


def _acting_at(
    windows: Sequence[Windows], body: Body, factor: float, shift: FloatArray | float = 0.0
) -> FloatArray:
    """Wrenches ``(W, 6)`` that act with other grips."""
    motions = (replace(each.motion, grips=factor * each.motion.grips + shift) for each in windows)
    return _both(list(map(Windows, motions)), body)[0]


def _about_another_point(misfit: Misfit, moved: FloatArray) -> FloatArray:
    """What acts about the point that leaves the least; ``moved`` is how it changes by metres."""
    columns = (moved / misfit.scale[:, None]).reshape(-1, moved.shape[-1])
    left = ((misfit.wanted - misfit.acting) / misfit.scale).ravel()
    return misfit.acting + moved @ np.linalg.lstsq(columns, left, rcond=1e-9)[0]


def _both(windows: Sequence[Windows], body: Body) -> tuple[FloatArray, FloatArray]:
    """Wrenches ``(W, 6)`` that act, and that are wanted."""
    misfit = Misfit.of(windows, body, windows[0].motion.dimension)
    return misfit.acting, misfit.wanted


def _without_lengths(layout: Layout) -> Layout:
    """Without what moves an origin, and without all but the weight of loads."""
    sensors = {
        number: replace(
            each, offset=(), load=each.load and Load(mass=each.load.mass, side=each.load.side)
        )
        for number, each in layout.sensors.items()
    }
    return replace(layout, sensors=sensors, pose=replace(layout.pose, com=()))


def _declared(units: Units, again: Again) -> Iterator[Declared]:
    """Layouts that say so; none where columns of one file have several units."""
    layout = again.layout
    own, (positions, grips) = layout.length, units
    of_layout = _scaled(layout, 1.0) != _scaled(layout, 2.0)
    if positions == grips:
        remedy = f"--length {grips}"
        yield Declared(
            "lengths", f"lengths are in {grips}", remedy, replace(layout, length=grips), RANK
        )
    in_columns = positions == grips if layout.grips is None else grips == own
    if positions != own and in_columns and of_layout:
        factor = layout.factor("length") / UNITS["length"][positions]
        yield Declared(
            "lengths",
            f"positions of the file are in {positions}",
            f"--length {positions}, and lengths of the layout in {positions} too",
            replace(_scaled(layout, factor), length=positions),
            RANK,
        )
    if positions == own and layout.grips is not None:
        factor = UNITS["length"][grips] / layout.factor("length")
        told = (factor * np.array(layout.grips)).round(9).tolist()
        only = replace(layout, grips=_scaled(layout, factor).grips)
        yield Declared("lengths", f"grips are in {grips}", f"grips = {told}", only, RANK)
        text, remedy = f"lengths of the layout are in {grips}", f"write them in {own}"
        if _scaled(layout, factor) != only:
            yield Declared("lengths", text, remedy, _scaled(layout, factor), RANK)


def _as_it_is(units: Units, windows: Sequence[Windows], layout: Layout) -> Explanation:
    """Another unit of what was read, which the file or the layout is to have."""
    own, (positions, grips) = layout.length, units
    first, second = (UNITS["length"][unit] / layout.factor("length") for unit in units)
    motions = (
        replace(
            each.motion, position=first * each.motion.position, grips=second * each.motion.grips
        )
        for each in windows
    )
    made, dimension = list(map(Windows, motions)), windows[0].motion.dimension
    left = Misfit.of(made, layout.body, dimension, reach_of(windows)).share()
    if positions == grips:
        return Explanation("lengths", f"lengths are in {grips}", f"--length {grips}", left, RANK)
    what, unit = ("grips", grips) if positions == own else ("positions", positions)
    remedy = f"bring all lengths into one unit and say it, as --length {own}"
    return Explanation("lengths", f"{what} are in {unit}", remedy, left, RANK)


def _scaled(layout: Layout, factor: float) -> Layout:
    """With all lengths that it says so many times as large."""

    def times(numbers: tuple) -> tuple:
        return tuple(times(each) if isinstance(each, tuple) else factor * each for each in numbers)

    sensors = {
        number: replace(
            each,
            offset=times(each.offset),
            load=each.load and replace(each.load, center=times(each.load.center)),
        )
        for number, each in layout.sensors.items()
    }
    pose = replace(layout.pose, com=times(layout.pose.com))
    grips = None if layout.grips is None else times(layout.grips)
    return replace(layout, sensors=sensors, pose=pose, grips=grips)
