"""Forces and torques in another unit: by the factor that fits best, or by the units there are."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.consistency.known_body.corrected import Corrected
from coopenv.logs.consistency.known_body.found import Explanation
from coopenv.logs.consistency.known_body.taken import mounting, weights
from coopenv.logs.layout import UNITS, Layout

NEAR = 0.03  # of a factor between two units
KNOWN, ANY = 0, 4  # ranks of a unit that is known, and of a factor that is of none


def units(sums: Corrected, layout: Layout) -> Iterator[Explanation]:
    """Forces, or torques, or both, in another unit."""
    force, torque = sums.numbers({}, torque=0.0), sums.numbers({}, force=0.0)
    moves = [i for i in range(sums.num_effectors) if _offset_of(layout, i)]
    # what was taken off readings, and added to them, in the wrong unit
    keys = [("offset", i, a) for i in moves for a in sums.force_axes]
    keys += weights(sums) if any(each.load is not None for each in layout.sensors.values()) else []
    columns = np.stack([force, torque, *(sums.only(key) for key in keys)], axis=-1)
    matrix, target = sums.residuals()
    gains = np.linalg.lstsq(matrix @ columns, target, rcond=1e-9)[0]
    names, remedies = [], []
    rank = KNOWN
    for kind, gain in zip(("force", "torque"), gains[:2].tolist(), strict=True):
        if gain <= 0:
            return
        if abs(gain - 1) < NEAR:
            continue
        unit = _unit_of(kind, gain * layout.factor(kind))
        wrong = f"{gain:.3g} times too small" if gain > 1 else f"{1 / gain:.3g} times too large"
        names.append(f"{kind}s are {f'in {unit}' if unit else wrong}")
        remedies.append(f"--{kind} {unit}" if unit else f"scale {kind}s")
        rank = rank if unit else ANY
    if names:
        left = sums.share(columns @ gains)
        yield Explanation("units", " and ".join(names), ", ".join(remedies), left, rank)


def other_units(sums: Corrected, layout: Layout) -> Iterator[Explanation]:
    """Forces, torques or both in another unit, one of those that are known."""
    force, torque = sums.numbers({}, torque=0.0), sums.numbers({}, force=0.0)
    moved = np.zeros_like(force)  # by the offsets, which have a force's unit beside a torque's
    for i in range(sums.num_effectors):
        for a, length in zip(sums.force_axes, _mounted_offset(i, layout), strict=False):
            moved += length * sums.only(("offset", i, a))
    tried = []
    for one, other in product(UNITS["force"], UNITS["torque"]):
        said = {"force": one, "torque": other}
        changed = {kind: unit for kind, unit in said.items() if unit != getattr(layout, kind)}
        gains = [UNITS[kind][unit] / layout.factor(kind) for kind, unit in said.items()]
        mixed = gains[0] * force + gains[1] * torque + (gains[0] - gains[1]) * moved
        left = sums.share(mixed)
        tried += [(left, len(changed), changed)] * bool(changed)
    least = min(left for left, *_ in tried)
    if not np.isfinite(least):
        return
    alike = [each for each in tried if each[0] <= 2 * least]
    left, _, changed = min(alike, key=lambda each: (each[1], each[0]))
    names = [f"{kind}s are in {unit}" for kind, unit in changed.items()]
    remedies = [f"--{kind} {unit}" for kind, unit in changed.items()]
    yield Explanation("units", " and ".join(names), ", ".join(remedies), left, KNOWN)


def _mounted_offset(i: int, layout: Layout) -> FloatArray:
    """A declared offset along the object's axes [m]; of no length where there is none."""
    own = np.array(_offset_of(layout, i)) * layout.factor("length")
    return own if not len(own) else mounting(i, layout) @ np.resize([*own, 0.0], 3)


def _unit_of(kind: str, size: float) -> str:
    """The unit of that size, if it is near one."""
    for unit, factor in UNITS[kind].items():
        if abs(size / factor - 1) < NEAR:
            return unit
    return ""


def _offset_of(layout: Layout, i: int) -> tuple[float, ...]:
    sensor = layout.sensors.get(i + 1)
    return () if sensor is None else sensor.offset
