"""Mistakes in how wrenches were declared, as the motion of the object tells them.

Every reading of the file (frame, sign, order of grips, unit) is tried against Newton's and Euler's
laws; one that explains much where the declared one explains little is the likeliest mistake.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from coopenv.logs.consistency.laws import Laws
from coopenv.logs.layout import UNITS, Layout

BAD = 0.3  # unexplained share from which a declaration is doubted
GOOD = 0.2  # and up to which another one may take its place,
BETTER = 0.25  # if it leaves at most this part of what the first leaves
CLEAR = 0.1  # both, where recordings are clear
LITTLE = 0.1  # explained share of force that next to nothing explains
MOVES = 0.03  # [m/s] (change of) velocity from window to window, far above that of noise at rest
TURNS = 0.1  # [rad/s] alike
OTHER = {"object": "world", "world": "object"}


class Fit(NamedTuple):
    """Share of what was recorded that the motion explains, in [0, 1]; NaN where it is not known."""

    force: float = np.nan
    torque: float = np.nan
    power: float = np.nan


class _Reading(NamedTuple):
    """One way to understand the forces."""

    laws: Laws
    frame: str
    velocity: str
    sign: float

    def left(self) -> float:
        """Share of the resultant force that is left unexplained."""
        return self.laws.force(self.frame, self.velocity, self.sign)


def wrench_mistakes(candidates: list[Laws], layout: Layout, twist: str) -> Iterator[str]:
    """What would make wrenches explain the motion."""
    laws = candidates[0]
    if not laws.enough("force") and not laws.enough("torque"):  # no orientation
        if _much_better(laws.power(-1.0), laws.power(1.0)):
            yield _AGAINST
        return
    velocities = laws.velocities(twist) or [""]
    readings = [
        [
            _Reading(each, frame, velocity, sign)
            for velocity in velocities
            for frame in (layout.frame, OTHER[layout.frame])
            for sign in (1.0, -1.0)
        ]
        for each in candidates
    ]
    said = chosen = readings[0][0]
    decided = False
    if laws.enough("force"):
        decided = said.left() < BAD
        # another angle last: one that makes theta small is near to forces in the other frame
        best = min(readings[0], key=_Reading.left)
        for reading in (min(each, key=_Reading.left) for each in readings[1:]):
            best = reading if _much_better(reading.left(), best.left()) else best
        if _much_better(best.left(), said.left()):
            chosen, decided = best, True
            yield from _force_mistakes(chosen, said, layout, twist)
    if laws.enough("torque"):
        others = candidates[1:] if chosen.laws is laws else []
        yield from _torque_mistakes(chosen, others, decided, layout)


_REACTION = (
    "forces and torques may be those on the sensors instead of on the object; turn their signs, "
    "--map f1x=-f1x …"
)
_AGAINST = f"the power goes against the change of kinetic energy: {_REACTION}"


def _force_mistakes(chosen: _Reading, said: _Reading, layout: Layout, twist: str) -> Iterator[str]:
    begin = "the resultant force goes with the acceleration if"
    if chosen.laws is not said.laws:
        unit, options = _angle_said(chosen.laws, layout)
        yield f"{begin} theta is in {unit}: say {options}"
    if chosen.velocity not in ("pose", twist):
        twist = chosen.velocity
        yield f"{begin} the twist is in the {twist} frame: say --twist-frame {twist}"
    if chosen.frame != said.frame:
        also = f" --twist-frame {twist}" if chosen.laws.has_twist else ""
        yield f"{begin} forces are in the {chosen.frame} frame: say --frame {chosen.frame}{also}"
    if chosen.sign < 0:
        yield f"the resultant force goes against the acceleration: {_REACTION}"


def _angle_said(laws: Laws, layout: Layout) -> tuple[str, str]:
    """Unit of theta other than the declared one, and the options that say it."""
    unit = "rad" if layout.angle == "deg" else "deg"
    omega = f"{unit}/s"  # where pose and twist go together, both are in the other unit
    also = laws.enough("spin") and layout.angular_velocity != omega
    return unit, f"--angle {unit}" + f" --angular-velocity {omega}" * also


def _torque_mistakes(
    chosen: _Reading, others: list[Laws], decided: bool, layout: Layout
) -> Iterator[str]:
    laws, frame, sign = chosen.laws, chosen.frame, chosen.sign
    said = laws.torque(frame, force=sign, torque=sign)
    tried: list[tuple[float, str]] = []
    swaps = laws.num_swapped if decided or not laws.enough("force") else 0
    for i, j in combinations(range(swaps), 2):
        text = f"if the grips of effectors {i + 1} and {j + 1} are exchanged; exchange them"
        tried.append((laws.torque(frame, force=sign, torque=sign, swapped=(i, j)), text))
    for factor, word in ((1e-3, "large"), (1e3, "small")):
        unit = _unit_beside(layout.torque, factor)
        text = f"if torques are 1000 times too {word}; look at their unit{unit}"
        tried.append((laws.torque(frame, force=sign, torque=sign * factor), text))
    text = "if torques have the other sign; turn it, --map t1z=-t1z …"
    tried.append((laws.torque(frame, force=sign, torque=-sign), text))
    for other in others:
        if not decided and not other.theta_goes_with_omega():
            continue  # no more than a chance that it is this one
        unit, options = _angle_said(other, layout)
        text = f"if theta is in {unit}; say {options}"
        tried.append((other.torque(frame, force=sign, torque=sign), text))
    if not decided and (not laws.enough("force") or laws.power(-sign) < CLEAR):
        text = f"if all signs are turned; {_REACTION}"
        tried.append((laws.torque(frame, force=-sign, torque=-sign), text))
    if not decided:
        text = f"if forces are in the {OTHER[frame]} frame; say --frame {OTHER[frame]}"
        tried.append((laws.torque(OTHER[frame], force=sign, torque=sign), text))
    left, text = min(tried, key=lambda each: each[0])
    if _much_better(left, said):
        yield f"the resultant torque goes with the angular acceleration {text}"


def nothing_explains(laws: Laws, fit: Fit, layout: Layout) -> Iterator[str]:
    """Where force and power both go with nothing, though the object moves.

    Walls and wheels do no work that is not recorded, so that the power is still explained there.
    Springs and cables, which push the more the further the object is from some place, are tried.
    """
    if laws.speeding() < MOVES or not (fit.force < LITTLE and fit.power < 1 - BAD):
        return
    velocity = laws.velocities(str(layout.twist_frame))[0]
    if laws.force(layout.frame, velocity, 1.0, spring=True) < GOOD:
        return
    if laws.power(-1.0) < CLEAR:
        yield _AGAINST
    else:
        yield (
            f"the motion explains {100 * fit.force:.0f} % of the resultant force and "
            f"{100 * fit.power:.0f} % of the power, and no other frame, unit or sign that was "
            "tried explains them; look first at the sign of each axis and of each sensor (--map "
            "f1y=-f1y …), at units, at which sensor is which effector, whether forces and motion "
            "have the same times, and whether something else pushes, such as a spring or a cable"
        )


def _unit_beside(declared: str, factor: float) -> str:
    """The unit that is so many times the declared one, as advice."""
    known = UNITS["torque"]
    for unit, size in known.items():
        if np.isclose(size, factor * known[declared]):
            return f", such as --torque {unit}"
    return ""


def _much_better(left: float, said: float) -> bool:
    """Whether the evidence is strong that another declaration is the right one."""
    doubted = said > BAD and left < BETTER * said
    return left < GOOD and (doubted or (said > CLEAR and left < CLEAR * said))
