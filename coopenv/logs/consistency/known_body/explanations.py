"""The usual mistakes with sensors and poses, and which of them would account for a misfit.

Each is tried against the motion of a body whose mass and inertia are known. The simplest of those
that account for about as much as the best is the likeliest.
"""

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.consistency.known_body.corrected import UNIT, Corrected
from coopenv.logs.consistency.known_body.fitted import (
    bias,
    center_of_mass,
    handle,
    offset,
    rotation,
    weight,
)
from coopenv.logs.consistency.known_body.found import Explanation, label
from coopenv.logs.consistency.known_body.known import Windows
from coopenv.logs.consistency.known_body.late import Times
from coopenv.logs.consistency.known_body.lengths import lengths
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.consistency.known_body.otherwise import Again, declared_otherwise
from coopenv.logs.consistency.known_body.poses import mistakes_of_pose
from coopenv.logs.consistency.known_body.taken import constants, loads, mounting
from coopenv.logs.consistency.known_body.units import other_units, units
from coopenv.logs.layout import Layout

DOUBT = 0.0005  # share that is left, above which a mistake is looked for
BETTER = 0.3  # of it, that a mistake may leave
ENOUGH = 0.2  # and the most that one may leave
ALIKE = 2.0  # times what the best leaves: as good
MOST_EFFECTORS = 6  # of which sensors are tried one by one
ALIKE_OTHERS = ("grips", "units")  # may leave as little as exchanged sensors do
AXES = "xyz"


def explanations(
    windows: Sequence[Windows],
    misfit: Misfit,
    layout: Layout,
    times: Times,
    again: Again | None = None,
) -> Iterator[Explanation]:
    """Mistakes that would account for most of what is left, likeliest first; at most three.

    ``times`` are the delays that fit best.
    """
    left = misfit.share()
    if left < DOUBT:
        return
    devices, (dimension, count) = times.devices, _size(windows)
    tried = [*times.explanations(layout)]
    tried += mistakes_of_pose(windows, layout, label(devices.pose) if devices else "")
    good = []
    if count <= MOST_EFFECTORS:
        sums = Corrected(windows, misfit, layout.body, dimension, devices)
        tried += [*_of_readings(sums, layout), *_of_places(sums, layout)]
        tried += [*bias(sums), *weight(sums), *center_of_mass(sums, layout)]
        good = _beside_what_was_taken_off(sums, layout)
    tried += lengths(windows, layout, again)
    most = min(BETTER * left, ENOUGH)
    good += [each for each in tried if each.left < most]
    if again is not None and not any(_settles(each) for each in good):
        found = again.explanations(declared_otherwise(again, count))
        exact = [each for each in found if each.left < most]
        told = {each.kind for each in exact}
        good = [*exact, *(each for each in good if each.kind not in told)]
    yield from likeliest(good, left)


def _size(windows: Sequence[Windows]) -> tuple[int, int]:
    """Dimension, and number of effectors."""
    motion = windows[0].motion
    return motion.dimension, motion.force.shape[1]


def _settles(found: Explanation) -> bool:
    """Whether nothing is left to doubt, so that the recording need not be read again."""
    return found.left < DOUBT and found.kind not in ALIKE_OTHERS


def likeliest(good: Sequence[Explanation], left: float) -> Iterator[Explanation]:
    """Those that leave about as little as the best, one of a kind, the simplest first."""
    if not good:
        return
    least = min(each.left for each in good)
    alike = [each for each in good if each.left <= ALIKE * least + 0.002 * left]
    kinds: dict[str, Explanation] = {}
    for each in sorted(alike, key=lambda each: (each.rank, each.sensors, each.left)):
        kinds.setdefault(each.kind, each)
    yield from sorted(kinds.values(), key=lambda each: (each.rank, each.left))[:3]


def _of_readings(sums: Corrected, layout: Layout) -> Iterator[Explanation]:
    """Readings that are to be understood otherwise."""
    for group in _groups(sums.num_effectors):
        yield from _turned(sums, group, layout)
        yield from rotation(sums, group, layout)
    yield from other_units(sums, layout) if sums.free else units(sums, layout)


def _of_places(sums: Corrected, layout: Layout) -> Iterator[Explanation]:
    """Where sensors are, and what they carry."""
    for group in _groups(sums.num_effectors):
        yield from offset(sums, group, layout)
        yield from handle(sums, group, layout)


def _beside_what_was_taken_off(sums: Corrected, layout: Layout) -> list[Explanation]:
    """Mistakes that are good once tares that were found, and loads, are taken off anew."""
    found, carried = constants(sums, layout), loads(sums, layout)
    made = []
    for keys, tried in (([*found, *carried], _of_readings), (found, _of_places)):
        if keys:
            freed = sums.freed(keys)
            least = min(BETTER * freed.share(freed.as_declared), ENOUGH)
            made += [each for each in tried(freed, layout) if each.left < least]
    return made


def sentence(left: float, found: Sequence[Explanation]) -> str:
    """The warning about what is left, and about mistakes that would account for it; or nothing."""
    if not found:
        if left < ENOUGH:
            return ""
        return (
            f"{100 * left:.2g} % of what moves the known body is not accounted for, and none of "
            "the usual mistakes alone would do so: look at mass, inertia and drag, at each sensor "
            "by itself, and whether something else pushes"
        )
    first, *others = found
    more = f"; or if {' or '.join(each.text for each in others)}" if others else ""
    return (
        f"the known body moves as the wrenches say if {first.text}: {first.remedy} (then "
        f"{100 * first.left:.2g} instead of {100 * left:.2g} % is not accounted for{more})"
    )


def _groups(count: int) -> Iterator[tuple[int, ...]]:
    """All sensors, and each alone."""
    if count > 1:
        yield tuple(range(count))
    yield from ((i,) for i in range(count))


def _turned(sums: Corrected, group: tuple[int, ...], layout: Layout) -> Iterator[Explanation]:
    """Signs and axes of some sensors, the file's: the mistakes that have no number."""
    who, d = sums.named(group), len(sums.force_axes)
    keys = f"[sensors.{group[0] + 1}]" if len(group) == 1 else "each sensor's table"

    mounted = {i: mounting(i, layout) for i in group}

    def left(force: FloatArray, torque: FloatArray) -> float:
        axes = {i: turn @ force @ turn.T for i, turn in mounted.items()}
        torque_axes = {i: turn @ torque @ turn.T for i, turn in mounted.items()}
        return sums.share(sums.numbers(axes, torque_axes=torque_axes))

    text, declared = f"the reaction on {who} is recorded", layout.sensors.get(group[0] + 1)
    sign = -1 if declared is None else -declared.sign
    yield Explanation("sign", text, f"{keys} sign = {sign:g}", left(-UNIT, -UNIT), 0)
    text = f"torques of {who} have the other sign"
    yield Explanation("sign", text, "turn it, --map t1z=-t1z …", left(UNIT, -UNIT), 0)
    if d == 2 and any(abs(turn[2, :2]).max() > 1e-3 for turn in mounted.values()):
        return  # the file's axes are not those of the plane
    for a in sums.force_axes:
        flip = np.diag([-1.0 if b == a else 1.0 for b in range(3)])
        name = f"f{AXES[a]}"
        text = f"{name} of {who} has the other sign"
        yield Explanation("axis", text, f"turn it, --map {name}=-{name} …", left(flip, UNIT), 0)
    for order in permutations(range(d)):
        for signs in product((1.0, -1.0), repeat=d):
            if order == tuple(range(d)):
                continue
            matrix = np.eye(3)
            matrix[:d, :d] = np.array(signs)[:, None] * np.eye(d)[list(order)]
            axes = ", ".join(
                f"{AXES[a]} is {'-' if signs[a] < 0 else ''}{AXES[order[a]]}" for a in range(d)
            )
            rank = 1 if min(signs) > 0 else 2
            for torque, kind in ((matrix, "axes"), (UNIT, "axes of forces"))[3 - d :]:
                text = f"{kind} of {who} are exchanged ({axes} of the file)"
                remedy = "exchange them with --map"
                yield Explanation("axes", text, remedy, left(matrix, torque), rank)
