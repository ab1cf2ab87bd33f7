"""Pose and filters, as a layout's ``[pose]`` and ``[filters]`` say."""

from dataclasses import dataclass

from coopenv.arrays import number, positive, whole
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.orientation import COUNTS, checked_order
from coopenv.logs.calibration.stated import vector_or_nothing

MOST_DELAY = 10.0  # [s]
FASTEST = 1e6  # [Hz]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """How the orientation is written, and which point of the object is tracked, when."""

    orientation: str = "quaternion"  # or "matrix", "euler", "rotation_vector"
    columns: tuple[str, ...] = ()  # of the file, in order: 4, 9 or 3; () are the documented ones
    order: str | None = None  # see `coopenv.logs.calibration.quaternions`
    com: tuple[float, ...] = ()  # centre of mass in the tracked frame [unit of lengths]; () is 0
    delay: float = 0.0  # [s] by which pose and twist are late; negative where forces are

    def checked(self, key: str) -> "Pose":
        """With every field checked; ``key`` names it in errors."""
        written = self.columns or self.orientation != "quaternion"
        order = self.order
        if written or order is not None:
            order = checked_order(self.orientation, order, f"{key}.order")
        columns = self.columns
        if not isinstance(columns, list | tuple) or not all(isinstance(c, str) for c in columns):
            raise InvalidInput(f"{key}.columns must be names, got {columns!r}; list them")
        if written and len(columns) != COUNTS[self.orientation]:
            raise InvalidInput(
                f"{key}.columns must name the {COUNTS[self.orientation]} columns of a "
                f"{self.orientation}, got {len(columns)}; list them in their order"
            )
        if len(set(columns)) < len(columns):
            raise InvalidInput(f"{key}.columns must differ, got {list(columns)}; correct them")
        delay = number(self.delay, f"{key}.delay")
        if delay:
            positive(abs(delay), f"{key}.delay", unit="s", at_most=MOST_DELAY)
        return Pose(
            orientation=self.orientation,
            columns=tuple(columns),
            order=order,
            com=vector_or_nothing(self.com, f"{key}.com"),
            delay=delay,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Filters:
    """Zero-phase low pass, twist from pose, resampling: nothing of it unless it is said."""

    wrench: float | None = None  # [Hz] cutoff of forces and torques
    pose: float | None = None  # [Hz]
    twist: float | None = None  # [Hz]
    order: int = 2  # of the Butterworth filter, which passes forward and backward
    twist_window: float | None = None  # [s] of the polynomials that give the twist from the pose
    rate: float | None = None  # [Hz] of the rows that come out

    def checked(self, key: str) -> "Filters":
        """With every field checked; ``key`` names it in errors."""
        for name in ("wrench", "pose", "twist", "rate"):
            if getattr(self, name) is not None:
                positive(getattr(self, name), f"{key}.{name}", unit="Hz", at_most=FASTEST)
        if self.twist_window is not None:
            positive(self.twist_window, f"{key}.twist_window", unit="s", at_most=MOST_DELAY)
        whole(self.order, f"{key}.order", at_least=1, at_most=8)
        return self
