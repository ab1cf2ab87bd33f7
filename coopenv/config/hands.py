"""Checks of hands against the rest of a configuration: action, ranges and substeps."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from coopenv.arrays import FloatArray, Range
from coopenv.errors import InvalidInput
from coopenv.observation import Entry
from coopenv.observation.observation import find_block
from coopenv.physics.body import Body
from coopenv.physics.hands import (
    DAMPING,
    STIFFNESS,
    TORQUE_DAMPING,
    TORQUE_STIFFNESS,
    Hands,
    needed_substeps,
)
from coopenv.physics.strengths import parted
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
    wanted = _wanted()
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


def check_senses(
    hands: Hands | None, observe: Iterable[Entry], **sums: Mapping[str, Any] | None
) -> None:
    """Raise `InvalidInput` where something tells of hands, and there are none.

    That are blocks of ``observe``, and terms of the ``sums`` by the names of their keywords, which
    say ``needs_hands``.
    """
    if hands is not None:
        return
    wanting = [("observe", each.name) for each in map(find_block, observe) if each.needs_hands]
    for keyword, terms in sums.items():
        for name, term in (terms or {}).items():
            if getattr(term, "needs_hands", False):
                wanting.append((keyword, name))
    for keyword, name in wanting:
        raise InvalidInput(
            f"{keyword} {name!r} must come with {_wanted()}, as it tells of hands; pass one of "
            "them, or leave it out"
        )


def _wanted() -> str:
    """The actions that hands carry out, for errors."""
    return " or ".join(f"action={name!r}" for name in BY_HANDS)


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

    ``strengths`` ``(agent, column)`` are those of the team, all of which may have hands; of
    ``ranges``, the ends that may need most substeps are looked at: the stiffest hands and the
    lightest body, longest and shortest, with its grips as far out as may be drawn.
    """
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
        yield body, parted(strengths)[1]
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
        grips = tuple(outwards(grip, ranges.grips) for grip in held.grips)
        yield replace(held, grips=grips), parted(stiffest)[1]


def outwards(grip: tuple[float, float], offsets: tuple[Range, Range] | None) -> tuple[float, float]:
    """A grip as far out as it may be drawn; one at the centre of mass stays there."""
    x, y = grip
    if offsets is None or not (x or y):
        return grip
    return max((x + dx for dx in offsets[0]), key=abs), max((y + dy for dy in offsets[1]), key=abs)
