"""What a picture of a split shows, in metres: scales of forces and torques, arrows, arcs."""

from dataclasses import dataclass
from functools import cached_property
from math import floor, log10, pi

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.grasp import cross, sum_at_centre

LONGEST = 0.45  # of the object's size: the arrow of the largest force
WIDEST = 1.5 * pi  # [rad] the arc of the largest torque
VISIBLE = 1e-3  # of the largest arrow or arc; less is not drawn
RADIUS = 0.095  # of an arc, relative to the object's size
TINY = 1e-100  # [m, N, N·m] what is not larger is nothing: no scale could show it
ROUNDING = 1e-6  # a torque that is less of the largest force times the size is none; forces alike
OPPOSED = -0.98  # cosine below which an internal arrow covers the manipulation arrow


@dataclass(frozen=True)
class Scene:
    """One split of one sample, and how it is scaled.

    Parameters
    ----------
    applied, manipulation, internal
        ``(n, 3)`` or ``(n, 6)``, object frame [N, N·m].
    grips
        ``(n, 2)`` or ``(n, 3)``, object frame [m].
    outline
        ``(k, 2)`` corners of the object, object frame [m], or None.
    """

    applied: FloatArray
    manipulation: FloatArray
    internal: FloatArray
    grips: FloatArray
    outline: FloatArray | None = None

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.grips.shape[1]

    @cached_property
    def object_wrench(self) -> FloatArray:
        """h_o ``(3,)`` or ``(6,)`` [N, N·m]."""
        return sum_at_centre(self.applied, self.grips)

    @cached_property
    def size(self) -> float:
        """Of the object, the largest extent of its outline, grips and centre; 1 m for a point."""
        corners = np.zeros((1, self.dimension))
        points = [corners, self.grips, *([] if self.outline is None else [self.outline])]
        extent = float(np.ptp(np.concatenate(points), axis=0).max())
        return extent if extent > TINY else 1.0

    @cached_property
    def largest_force(self) -> float:
        """Of those that are drawn at grips [N]; 0 if it is rounding beside the torques."""
        force, torque = self._largest_force_and_torque
        return force if force * self.size > max(ROUNDING * torque, TINY) else 0.0

    @cached_property
    def largest_torque(self) -> float:
        """Of those that are drawn [N·m]; 0 if it is rounding beside the forces."""
        force, torque = self._largest_force_and_torque
        return torque if torque > max(ROUNDING * force * self.size, TINY) else 0.0

    @property
    def metres_per_newton(self) -> float:
        """How long a newton is drawn; 0 where there is no force."""
        return LONGEST * self.size / self.largest_force if self.largest_force > 0.0 else 0.0

    @property
    def radians_per_torque(self) -> float:
        """How wide a newton metre is drawn; 0 where there is no torque."""
        return WIDEST / self.largest_torque if self.largest_torque > 0.0 else 0.0

    def force(self, wrench: FloatArray) -> FloatArray:
        """Arrows ``(..., d)`` [m] of wrenches; zero where they would not be seen."""
        force = wrench[..., : self.dimension]
        seen = np.linalg.norm(force, axis=-1, keepdims=True) > VISIBLE * self.largest_force
        return np.where(seen, self.metres_per_newton * force, 0.0)

    def torque(self, wrench: FloatArray) -> FloatArray:
        """Arcs ``(..., 1)`` or axes of arcs ``(..., 3)`` [rad]; zero where not seen."""
        torque = wrench[..., self.dimension :]
        seen = np.linalg.norm(torque, axis=-1, keepdims=True) > VISIBLE * self.largest_torque
        return np.where(seen, self.radians_per_torque * torque, 0.0)

    def internal_starts(self) -> FloatArray:
        """Where internal arrows begin ``(n, d)`` [m]: at the tips of manipulation arrows.

        Beside them where they point back, as they would cover each other.
        """
        forward, back = self.force(self.manipulation), self.force(self.internal)
        starts = self.grips + forward
        for i, (one, other) in enumerate(zip(forward, back, strict=True)):
            length = float(np.linalg.norm(one) * np.linalg.norm(other))
            if length > 0.0 and float(one @ other) < OPPOSED * length:
                starts[i] += 0.03 * self.size * across(one)
        return starts

    @cached_property
    def _largest_force_and_torque(self) -> tuple[float, float]:
        d = self.dimension
        parts = np.concatenate([self.applied, self.manipulation, self.internal])
        torques = np.concatenate([parts[:, d:], self.object_wrench[None, d:]])
        force, torque = (np.linalg.norm(each, axis=-1).max() for each in (parts[:, :d], torques))
        return float(force), float(torque)


def across(vector: FloatArray) -> FloatArray:
    """A unit vector across another, to its left in the plane."""
    if len(vector) == 2:
        return np.array([-vector[1], vector[0]]) / float(np.linalg.norm(vector))
    other = cross(vector, np.eye(3)[np.abs(vector).argmin()])
    return other / float(np.linalg.norm(other))


def round_number(limit: float) -> float:
    """The largest of 1, 2, 5, 10, 20 and so on that is not above a positive limit."""
    power = 10.0 ** floor(log10(limit))
    return next(
        factor * power
        for factor in (10.0, 5.0, 2.0, 1.0, 0.5)
        if factor * power <= limit * 1.000001
    )
