"""Consistency of a recording: whether its wrenches explain the motion, or would if declared anew.

Newton's and Euler's laws hold whatever the mass: the resultant force goes with acceleration (and
with velocity, where there is friction), the resultant torque with angular acceleration, the power
with the change of kinetic energy. Where they do not, but would in another frame, with another sign,
order or unit, that is the likeliest mistake. Other forces on the object (walls, wheels, springs, a
cable that carries it) are not known here; they leave a part unexplained that is no evidence.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from coopenv.logs.consistency.known_body.balance import Balance, Balancing
from coopenv.logs.consistency.known_body.explanations import DOUBT, sentence
from coopenv.logs.consistency.known_body.otherwise import Again
from coopenv.logs.consistency.laws import LEAST_WINDOWS, Laws
from coopenv.logs.consistency.mistakes import (
    BAD,
    GOOD,
    MOVES,
    OTHER,
    TURNS,
    Fit,
    nothing_explains,
    wrench_mistakes,
)
from coopenv.logs.consistency.windows import WINDOW, Segments, at_different_times
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording
from coopenv.logs.recorded.devices import Devices

DEGREES = 180 / np.pi
APART = 2.0  # ratio of speeds of pose and twist from which one is in another unit


@dataclass(frozen=True, slots=True)
class Consistency:
    """Result of the comparison of wrenches with motion."""

    fit: Fit = field(default_factory=Fit)
    warnings: tuple[str, ...] = ()
    unchecked: str = ""  # why nothing could be compared
    balance: Balance | None = None  # with the motion of a known body, where mass and inertia are


class Check:
    """Compares the wrenches of a recording that comes chunk by chunk with its motion.

    Parameters
    ----------
    layout
        What was declared of the file.
    devices
        Whose pose and wrenches are, where several devices are joined.
    again
        Reads the recording again as if it had been declared otherwise, for mistakes that nothing
        else tells exactly; without it they are told where tables of the layout do not hide them.
    """

    def __init__(self, layout: Layout, devices: Devices | None = None, again: Again | None = None):
        self._layout = layout
        self._segments = Segments()
        self._laws = Laws(layout)
        self._other_angle: Laws | None = None  # as if rad were deg, or the reverse
        self._missing = "it has no rows"
        known = layout.body.mass is not None
        self._balancing = Balancing(layout, devices, again) if known else None

    def add(self, recording: Recording) -> None:
        """Append rows."""
        self._missing = _missing(recording)
        if self._missing:
            return
        recording = at_different_times(recording)
        if self._balancing is not None:
            self._balancing.add(recording)
        orientation = recording.orientation
        if self._other_angle is None and orientation is not None and orientation.ndim == 1:
            factor = DEGREES if self._layout.angle == "deg" else 1 / DEGREES
            self._other_angle = Laws(self._layout, angle=factor)
        for segment, rows in self._segments.of(recording):
            for laws in filter(None, (self._laws, self._other_angle)):
                laws.add(segment, rows)

    def result(self) -> Consistency:
        """Of all rows so far."""
        if self._balancing is None or self._missing:
            return self._of_laws()
        balance = self._balancing.result()
        exact = bool(balance.explanations) and balance.explanations[0].left < DOUBT
        found = self._of_laws(wrenches=not exact)  # which would only guess at the same mistake
        told = "" if balance.unchecked else sentence(balance.left, balance.explanations)
        if told:  # what numbers say comes first
            return replace(found, balance=balance, warnings=(told, *found.warnings))
        return replace(found, balance=balance)

    def _of_laws(self, *, wrenches: bool = True) -> Consistency:
        """What can be told of a body that is not known; of its wrenches too, or not."""
        if self._missing:
            return Consistency(unchecked=self._missing)
        if not self._laws.enough("power"):
            least = LEAST_WINDOWS + 1  # differences of windows are compared
            return Consistency(
                unchecked=f"fewer than {least * WINDOW:.1f} seconds, or {least} rows, in sequence"
            )
        fit = _fit(self._laws, self._layout)
        found = tuple(self._warnings(fit, wrenches=wrenches))
        if wrenches and not found:
            found = tuple(nothing_explains(self._laws, fit, self._layout))
        return Consistency(fit, found)

    def _warnings(self, fit: Fit, *, wrenches: bool) -> Iterator[str]:
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
        yield from self._speed()
        if not twist:
            yield from self._contradictions()
        if not wrenches:
            return
        candidates = [laws]
        doubted = not laws.enough("spin") or min(fit[:2]) < 1 - BAD  # theta and omega both wrong
        if doubted and not wrong and self._other_angle is not None:
            candidates.append(self._other_angle)
        yield from wrench_mistakes(candidates, layout, twist or str(layout.twist_frame))

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

    def _speed(self) -> Iterator[str]:
        """Whether position and velocity are in units, or at times, that do not go together."""
        left, ratio = self._laws.shift()
        if left < GOOD and not 1 / APART < ratio < APART:
            yield (
                f"the position moves {ratio:.3g} times as fast as the velocity says: look at the "
                "units, --length, --velocity and --time"
            )

    def _contradictions(self) -> Iterator[str]:
        """Whether pose and twist tell of motions that are not the same in any frame or unit."""
        both = [laws for laws in (self._laws, self._other_angle) if laws is not None]
        turns = ("orientation turns", "angular velocity", "theta=-theta or omega=-omega")
        for law, least, words in (
            ("shift", MOVES, ("position moves", "velocity", "x=-x … or vx=-vx …")),
            ("spin", TURNS, turns),
        ):
            told = [laws.shift if law == "shift" else laws.spin for laws in both]
            if self._laws.slower(law) > least and min(tell()[0] for tell in told) > BAD:
                yield _contradiction(*words, against=min(tell(-1.0)[0] for tell in told) < GOOD)


def _contradiction(pose: str, twist: str, columns: str, *, against: bool) -> str:
    """A warning that one of the two is wrong; ``columns`` are those whose sign may be."""
    turn = f"(--map {columns})"
    if against:
        return f"the {pose} against the {twist}: turn the sign of one of them {turn}"
    return (
        f"the {pose} otherwise than the {twist} says: one of them has the wrong sign of an axis "
        f"{turn}, axes exchanged, another frame, or other times"
    )


def _least_left(laws: Laws) -> float:
    """Share left unexplained when frame, velocity and sign are chosen to explain the most."""
    return min(
        laws.force(frame, velocity, sign)
        for frame in OTHER
        for velocity in laws.velocities("")
        for sign in (1.0, -1.0)
    )


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
