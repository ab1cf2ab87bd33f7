"""Checks of hands against the rest of a configuration: action, ranges and substeps."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from coopenv.arrays import FloatArray, Range
from coopenv.errors import InvalidInput
from coopenv.physics.body import Body
from coopenv.physics.hands import (
    DAMPING,
    STIFFNESS,
    TORQUE_DAMPING,
    TORQUE_STIFFNESS,
    Hands,
    needed_substeps,
)
from coopenv.randomisation import Ranges, Variations

BY_HANDS = ("motion", "impedance")  # actions that hands carry out

_DRAWN = ("stiffness", "damping")  # of ranges, those of hands


def hands_for(action: str, hands: Hands | None, ranges: Ranges | None) -> Hands | None:
    """The hands of an environment with that ``action``, default ones if none are given.

    ``None`` where no hands carry it out.

    Raises
    ------
    InvalidInput
        If hands, or ranges of theirs, are given beside an action that none carry out.
    """
    if action in BY_HANDS:
        return Hands() if hands is None else hands
    wanted = " or ".join(f"action={name!r}" for name in BY_HANDS)
    if hands is not None:
        raise InvalidInput(
            f"hands must come with {wanted}, got action={action!r}; pass one of them, or hands=None"
        )
    for name in _DRAWN:
        if ranges is not None and getattr(ranges, name) is not None:
            raise InvalidInput(
                f"randomise.{name} must come with {wanted}, got action={action!r}; pass one of "
                "them, or drop the range"
            )
    return None


def check_integrable(
    hands: Hands,
    action: str,
    bodies: Sequence[Body],
    strengths: FloatArray,
    ranges: Ranges | None,
    dt: float,
    substeps: int,
) -> None:
    """Raise `InvalidInput` where substeps are too few for the stiffest hands on the lightest body.

    Also where the body rubs on its ground, of which springs and dampers know nothing.

    ``strengths`` ``(agent, 8)`` are those of the team; of ``ranges``, the ends that may need most
    substeps are looked at: the stiffest hands and the lightest body, longest and shortest, with its
    grips as far out as may be drawn.
    """
    rubbing = [("body", body.ground_friction) for body in bodies]
    if ranges is not None and ranges.ground_friction is not None:
        rubbing.append(("randomise", ranges.ground_friction[1]))
    for where, friction in rubbing:
        if friction > 0:
            raise InvalidInput(
                f"{where}.ground_friction must be 0 where hands hold the body, got {friction:g}; "
                "choose action='wrench' or 'force' there"
            )
    needed = 0
    for body in bodies:
        for held, table in _hardest(body, strengths, ranges):
            if action == "impedance":
                table[:, [STIFFNESS, TORQUE_STIFFNESS]] *= hands.stiffness_factors[1]
                table[:, [DAMPING, TORQUE_DAMPING]] *= hands.damping_factors[1]
            needed = max(needed, needed_substeps(held, table, dt))
    if needed > substeps:
        raise InvalidInput(
            f"substeps must be at least {needed} for hands this stiff on a body this light at "
            f"dt={dt:g} s, got {substeps}; raise it, or take less stiffness or damping"
        )


def _hardest(
    body: Body, strengths: FloatArray, ranges: Ranges | None
) -> Iterator[tuple[Body, FloatArray]]:
    """Bodies and tables of hands of which one needs the most substeps."""
    if ranges is None:
        yield body, strengths[:, 2:].copy()
        return
    lightest = {
        name: (getattr(ranges, name)[0],) * 2
        for name in ("mass", "inertia")
        if getattr(ranges, name) is not None
    }
    fixed = replace(Ranges(stiffness=ranges.stiffness, damping=ranges.damping), **lightest)
    for length in ranges.length or (None,):
        one = fixed if length is None else replace(fixed, length=(length, length))
        drawn = Variations(one, body, strengths)
        held, stiffest = drawn([1.0] * drawn.count)
        grips = tuple(_outwards(grip, ranges.grips) for grip in held.grips)
        yield replace(held, grips=grips), stiffest[:, 2:].copy()


def _outwards(
    grip: tuple[float, float], offsets: tuple[Range, Range] | None
) -> tuple[float, float]:
    """A grip as far out as it may be drawn; one at the centre of mass stays there."""
    x, y = grip
    if offsets is None or not (x or y):
        return grip
    return max((x + dx for dx in offsets[0]), key=abs), max((y + dy for dy in offsets[1]), key=abs)
