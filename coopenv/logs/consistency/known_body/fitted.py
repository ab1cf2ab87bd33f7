"""Mistakes that have numbers, which are fitted: rotation, offset, bias, load, centre of mass."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from coopenv.arrays import FloatArray
from coopenv.logs.consistency.known_body.corrected import MOST_LOAD, Corrected
from coopenv.logs.consistency.known_body.found import Explanation, are
from coopenv.logs.consistency.known_body.taken import mounting, weights
from coopenv.logs.layout import Layout

LEAST_TURN = np.radians(2.0)
LEAST_OFFSET, MOST_OFFSET = 0.004, 0.5  # [m]
LEAST_MASS = 0.01  # [kg]
RANKS = {"load": 2, "rotation": 3, "offset": 3, "com": 3, "bias": 4}


def rotation(sums: Corrected, group: tuple[int, ...], layout: Layout) -> Iterator[Explanation]:
    """Sensors that are turned against the object, each by its own."""
    from scipy.optimize import least_squares

    plane = len(sums.force_axes) == 2
    matrix, target = sums.residuals()
    size = 1 if plane else 3

    def axes(vectors: FloatArray) -> dict[int, FloatArray]:
        turned = vectors.reshape(len(group), size)
        if plane:
            turned = np.hstack([np.zeros((len(group), 2)), turned])
        return dict(zip(group, Rotation.from_rotvec(turned).as_matrix(), strict=True))

    def left(vectors: FloatArray) -> FloatArray:
        return matrix @ sums.numbers(axes(vectors)) - target

    starts = [np.zeros(size * len(group))]
    starts += [np.full(size * len(group), each) for each in ((2.0, -2.0) if plane else (1.0,))]
    best = min((least_squares(left, start) for start in starts), key=lambda each: each.cost)
    turned = best.x.reshape(len(group), size)
    angle = np.linalg.norm(turned, axis=-1)
    if angle.max() < LEAST_TURN:
        return
    unit = layout.factor("angle")
    found = axes(best.x)
    mounted = np.stack([mounting(i, layout) for i in group])
    whole = Rotation.from_matrix([found[i] for i in group]) * Rotation.from_matrix(mounted)
    if plane:
        said = " and ".join(f"{np.degrees(float(each[0])):.3g}°" for each in turned)
    else:
        said = " and ".join(f"{np.degrees(float(each)):.3g}°" for each in angle)
    if plane and (mounted[:, 2, 2] > 1 - 1e-6).all():
        values = [f"{float(each[2]) / unit:.3g}" for each in whole.as_rotvec()]
    else:
        quaternions = whole.as_quat()[:, [3, 0, 1, 2]]
        values = [f"{{ quaternion = {_listed(each, 3)} }}" for each in quaternions]
    said += " more than is said" * any(_is_turned(i, layout) for i in group)
    yield Explanation(
        "rotation",
        f"{sums.named(group)} {are(group)} turned by {said}",
        _tables(group, "rotation", values),
        sums.share(sums.numbers(axes(best.x))),
        RANKS["rotation"],
        len(group),
    )


def offset(sums: Corrected, group: tuple[int, ...], layout: Layout) -> Iterator[Explanation]:
    """Sensors that are not where the hand grips."""
    keys = [("offset", i, a) for i in group for a in sums.force_axes]
    found = sums.fitted(keys)
    places = found.reshape(len(group), -1)
    if not LEAST_OFFSET <= np.linalg.norm(places, axis=-1).max() <= MOST_OFFSET:
        return
    values = [_as_declared(i, each, layout) for i, each in zip(group, places, strict=True)]
    yield Explanation(
        "offset",
        f"{sums.named(group)} {are(group)} beside the grip, which is "
        f"{' and '.join(f'{_listed(each, 3)} m' for each in places)} from there (object's axes)",
        _tables(group, "offset", values),
        sums.share_with(keys, found),
        RANKS["offset"],
        len(group),
    )


def bias(sums: Corrected) -> Iterator[Explanation]:
    """A constant in the readings; of which sensor, their sum does not tell."""
    forces = [("bias force", a) for a in sums.force_axes]
    torques = [("bias torque", a) for a in sums.torque_axes]
    found = sums.fitted([*forces, *torques])
    force, torque = -found[: len(forces)], -found[len(forces) :]
    yield Explanation(
        "bias",
        f"sensors have a bias, together of {_listed(force, 3)} N and about the centre of mass "
        f"{_listed(torque, 3)} N·m",
        "take it off, [sensors.1] tare = { first = 1.0 } where they hold nothing in that time, "
        "or as numbers",
        sums.share_with([*forces, *torques], found),
        RANKS["bias"],
    )


def weight(sums: Corrected) -> Iterator[Explanation]:
    """Weight of what hangs on sensors; on which of them, their sum does not tell."""
    keys = weights(sums)
    found = sums.fitted(keys)
    mass = float(found[0])
    light = LEAST_MASS < abs(mass) < MOST_LOAD * sums.mass
    if not light or not sums.bodies_pull.any():
        return
    side = "hand" if mass > 0 else "object"
    yield Explanation(
        "load",
        f"sensors carry together {abs(mass):.3g} kg on the {side}'s side",
        f'[sensors.1] load = {{ mass = …, center = […], side = "{side}" }}',
        sums.share_with(keys, found),
        RANKS["load"],
    )


def handle(sums: Corrected, group: tuple[int, ...], layout: Layout) -> Iterator[Explanation]:
    """Weight and inertia of what hangs on sensors."""
    keys = [("mass", i) for i in group]
    keys += [("moment", i, a) for i in group for a in sums.force_axes]
    found = sums.fitted(keys)
    masses = found[: len(group)]
    if not LEAST_MASS < np.abs(masses).sum() < MOST_LOAD * sums.mass:
        return
    alike = (masses > 0).all() or (masses < 0).all()
    side = "hand" if masses[0] > 0 else "object"
    if not alike:
        return
    said = " and ".join(f"{abs(float(each)):.3g} kg" for each in masses)
    carry = "carries" if len(group) == 1 else "carry"
    yield Explanation(
        "load",
        f"{sums.named(group)} {carry} {said} on the {side}'s side",
        ", ".join(_load_as_declared(i, m, layout) for i, m in zip(group, masses, strict=True)),
        sums.share_with(keys, found),
        RANKS["load"] + 1,
        len(group),
    )


def center_of_mass(sums: Corrected, layout: Layout) -> Iterator[Explanation]:
    """A tracked origin that is not the centre of mass."""
    keys = [("com", a) for a in sums.force_axes]
    found = sums.fitted(keys)
    if np.linalg.norm(found) > LEAST_OFFSET:
        unit = layout.factor("length")
        yield Explanation(
            "com",
            f"the centre of mass is at {_listed(found, 3)} m of the "
            f"{'tracked frame' if not any(layout.pose.com) else 'one that is said'}",
            f"[pose] com = {_listed(found / unit + np.array(layout.pose.com or 0.0), 3)}",
            sums.share_with(keys, found),
            RANKS["com"],
        )


def _as_declared(i: int, place: FloatArray, layout: Layout) -> str:
    """What an offset along the object's axes [m] makes of the one that a layout may have."""
    sensor = layout.sensors.get(i + 1)
    unit = layout.factor("length")
    if sensor is None:
        return _listed(place / unit, 3)
    own = mounting(i, layout).T @ np.resize([*place, 0.0], 3)
    known = np.resize([*sensor.offset, 0.0], 3) if sensor.offset else np.zeros(3)
    of_six = sensor.asks_for_six_axes(layout.factor("angle"))  # whose z may be in the plane
    return _listed((own / unit + known)[: 3 if of_six else len(place)], 3)


def _is_turned(i: int, layout: Layout) -> bool:
    sensor = layout.sensors.get(i + 1)
    return sensor is not None and sensor.rotation is not None


def _load_as_declared(i: int, mass: float, layout: Layout) -> str:
    """What a mass [kg], on the hand's side if positive, makes of the load that is declared."""
    sensor = layout.sensors.get(i + 1)
    load = None if sensor is None else sensor.load
    if load is not None:
        mass += load.mass if load.side == "hand" else -load.mass
    side = "hand" if mass > 0 else "object"
    if load is None:
        return f'[sensors.{i + 1}] load = {{ mass = {abs(mass):.3g}, side = "{side}" }}'
    return f'[sensors.{i + 1}.load] mass = {abs(mass):.3g} side = "{side}"'


def _tables(group: tuple[int, ...], key: str, values: Sequence[str]) -> str:
    """Lines of a layout."""
    return ", ".join(
        f"[sensors.{i + 1}] {key} = {value}" for i, value in zip(group, values, strict=True)
    )


def _listed(numbers: FloatArray, digits: int) -> str:
    return f"[{', '.join(f'{float(each):.{digits}g}' for each in numbers)}]"
