"""Consistency of a recording: whether its wrenches explain the motion, or would if declared anew.

Newton's and Euler's laws hold whatever the mass: the resultant force goes with acceleration (and
with velocity, where there is friction), the resultant torque with angular acceleration, the power
with the change of kinetic energy. Where they do not, but would in another frame, with another sign,
order or unit, that is the likeliest mistake. Other forces on the object (walls, wheels, springs, a
cable that carries it) are not known here; they leave a part unexplained that is no evidence.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np

from coopenv.logs.consistency.laws import LEAST_WINDOWS, Laws
from coopenv.logs.consistency.windows import Segments
from coopenv.logs.layout import UNITS, Layout
from coopenv.logs.recording import Recording

BAD = 0.3  # unexplained share from which a declaration is doubted
GOOD = 0.2  # and up to which another one may take its place,
BETTER = 0.25  # if it leaves at most this part of what the first leaves
CLEAR = 0.1  # both, where recordings are clear
DEGREES = 180 / np.pi
OTHER = {"object": "world", "world": "object"}


class Fit(NamedTuple):
    """Share of what was recorded that the motion explains, in [0, 1]; NaN where it is not known."""

    force: float = np.nan
    torque: float = np.nan
    power: float = np.nan


@dataclass(frozen=True, slots=True)
class Consistency:
    """Result of the comparison of wrenches with motion."""

    fit: Fit = field(default_factory=Fit)
    warnings: tuple[str, ...] = ()
    unchecked: str = ""  # why nothing could be compared


class Check:
    """Compares the wrenches of a recording that comes chunk by chunk with its motion.

    Parameters
    ----------
    layout
        What was declared of the file.
    """

    def __init__(self, layout: Layout):
        self._layout = layout
        self._segments = Segments()
        self._laws = Laws(layout)
        self._other_angle: Laws | None = None  # as if rad were deg, or the reverse
        self._missing = "it has no rows"

    def add(self, recording: Recording) -> None:
        """Append rows."""
        self._missing = _missing(recording)
        if self._missing:
            return
        orientation = recording.orientation
        if self._other_angle is None and orientation is not None and orientation.ndim == 1:
            factor = DEGREES if self._layout.angle == "deg" else 1 / DEGREES
            self._other_angle = Laws(self._layout, angle=factor)
        for segment, rows in self._segments.of(recording):
            for laws in filter(None, (self._laws, self._other_angle)):
                laws.add(segment, rows)

    def result(self) -> Consistency:
        """Of all rows so far."""
        if self._missing:
            return Consistency(unchecked=self._missing)
        if not self._laws.enough("power"):
            return Consistency(unchecked=f"fewer than {LEAST_WINDOWS} windows of rows in sequence")
        return Consistency(_fit(self._laws, self._layout), tuple(self._warnings()))

    def _warnings(self) -> Iterator[str]:
        """The likeliest mistakes; kinematics first, as it tells what else to believe."""
        laws, layout = self._laws, self._layout
        angle, wrong = self._angle()
        if angle:
            yield angle
        if wrong and self._other_angle is not None:
            laws = self._other_angle
        twist = OTHER[str(layout.twist_frame)] if laws.twist_is_in_the_other_frame() else ""
        if twist:
            yield f"the twist goes with the pose in the {twist} frame: say --twist-frame {twist}"
        candidates = [laws]
        if not laws.enough("spin") and self._other_angle is not None:
            candidates.append(self._other_angle)
        yield from _wrench_mistakes(candidates, layout, twist or str(layout.twist_frame))

    def _angle(self) -> tuple[str, bool]:
        """What is wrong with angles where pose and twist both tell them, and whether theta is."""
        layout, laws = self._layout, self._laws
        left, ratio = laws.spin()
        if left > BAD and self._other_angle is not None:  # degrees may jump at 180
            left, ratio = self._other_angle.spin()
            ratio /= self._other_angle.angle
        if left > GOOD or not np.isfinite(ratio):
            return "", False
        many = ratio > 1  # theta too large, or omega too small
        if not 0.7 < (ratio if many else 1 / max(ratio, 1e-9)) / DEGREES < 1.4:
            return "", False
        theta = layout.angle == ("rad" if many else "deg") and self._other_angle is not None
        omega = layout.angular_velocity == ("deg/s" if many else "rad/s")
        units = ("deg", "rad/s") if many else ("rad", "deg/s")
        said = [f"--angle {units[0]}"] * theta + [f"--angular-velocity {units[1]}"] * omega
        if not said:
            return "", False
        if theta and omega and self._other_angle is not None:  # one of them: what forces say
            theta = _least_left(self._other_angle) < _least_left(laws)
        return (
            f"the orientation turns {ratio:.3g} times as fast as the angular velocity says, as "
            f"degrees taken for radians or the reverse do: say {' or '.join(said)}"
        ), theta


def _least_left(laws: Laws) -> float:
    """Share left unexplained when frame, velocity and sign are chosen to explain the most."""
    return min(
        laws.force(frame, velocity, sign)
        for frame in OTHER
        for velocity in laws.velocities("")
        for sign in (1.0, -1.0)
    )


class _Reading(NamedTuple):
    """One way to understand the forces."""

    laws: Laws
    frame: str
    velocity: str
    sign: float


def _wrench_mistakes(candidates: list[Laws], layout: Layout, twist: str) -> Iterator[str]:
    """What would make wrenches explain the motion."""
    laws = candidates[0]
    if not laws.enough("force") and not laws.enough("torque"):  # no orientation
        if _much_better(laws.power(-1.0), laws.power(1.0)):
            yield f"the power goes against the change of kinetic energy: {_REACTION}"
        return
    velocities = laws.velocities(twist) or [""]
    readings = [
        _Reading(each, frame, velocity, sign)
        for each in candidates
        for velocity in velocities
        for frame in (layout.frame, OTHER[layout.frame])
        for sign in (1.0, -1.0)
    ]
    chosen, decided = readings[0], False
    if laws.enough("force"):
        left = [each.laws.force(each.frame, each.velocity, each.sign) for each in readings]
        best = int(np.argmin(left))
        decided = left[0] < BAD
        if _much_better(left[best], left[0]):
            chosen, decided = readings[best], True
            yield from _force_mistakes(chosen, readings[0], twist)
    if laws.enough("torque"):
        yield from _torque_mistakes(chosen, decided, layout)


_REACTION = (
    "forces and torques may be those on the sensors instead of on the object; turn their signs, "
    "--map f1x=-f1x …"
)


def _force_mistakes(chosen: _Reading, said: _Reading, twist: str) -> Iterator[str]:
    begin = "the resultant force goes with the acceleration if"
    if chosen.laws is not said.laws:
        unit = "deg" if chosen.laws.angle < 1 else "rad"
        yield f"{begin} theta is in {unit}: say --angle {unit}"
    if chosen.velocity not in ("pose", twist):
        twist = chosen.velocity
        yield f"{begin} the twist is in the {twist} frame: say --twist-frame {twist}"
    if chosen.frame != said.frame:
        also = f" --twist-frame {twist}" if chosen.laws.has_twist else ""
        yield f"{begin} forces are in the {chosen.frame} frame: say --frame {chosen.frame}{also}"
    if chosen.sign < 0:
        yield f"the resultant force goes against the acceleration: {_REACTION}"


def _torque_mistakes(chosen: _Reading, decided: bool, layout: Layout) -> Iterator[str]:
    laws, frame, sign = chosen.laws, chosen.frame, chosen.sign
    said = laws.torque(frame, force=sign, torque=sign)
    tried: list[tuple[float, str]] = []
    for i, j in combinations(range(laws.num_swapped), 2):
        text = f"if the grips of effectors {i + 1} and {j + 1} are exchanged; exchange them"
        tried.append((laws.torque(frame, force=sign, torque=sign, swapped=(i, j)), text))
    for factor, word in ((1e-3, "large"), (1e3, "small")):
        unit = _unit_beside(layout.torque, factor)
        text = f"if torques are 1000 times too {word}; look at their unit{unit}"
        tried.append((laws.torque(frame, force=sign, torque=sign * factor), text))
    text = "if torques have the other sign; turn it, --map t1z=-t1z …"
    tried.append((laws.torque(frame, force=sign, torque=-sign), text))
    if not decided:
        text = f"if all signs are turned; {_REACTION}"
        tried.append((laws.torque(frame, force=-sign, torque=-sign), text))
        text = f"if forces are in the {OTHER[frame]} frame; say --frame {OTHER[frame]}"
        tried.append((laws.torque(OTHER[frame], force=sign, torque=sign), text))
    left, text = min(tried, key=lambda each: each[0])
    if _much_better(left, said):
        yield f"the resultant torque goes with the angular acceleration {text}"


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


def _fit(laws: Laws, layout: Layout) -> Fit:
    """What the motion explains as it was declared."""
    velocities = laws.velocities(str(layout.twist_frame))
    force = laws.force(layout.frame, velocities[0], 1.0) if laws.enough("force") else np.nan
    torque = laws.torque(layout.frame, force=1.0, torque=1.0) if laws.enough("torque") else np.nan
    return Fit(1 - force, 1 - torque, 1 - laws.power(1.0))


def _missing(recording: Recording) -> str:
    """What the comparison needs and the file has not."""
    if recording.time is None:
        return "it has no time"
    if recording.twist is None and (recording.position is None or recording.orientation is None):
        return "it has neither a twist nor a whole pose"
    return ""
