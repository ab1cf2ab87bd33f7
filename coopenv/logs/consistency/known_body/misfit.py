"""Misfit of what acts on a known body with what its motion needs, and how late the pose is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.body import Body
from coopenv.logs.consistency.known_body.known import Motion, Windows

DELAYS = 0.3  # [s] the longest that are tried
STILL = 0.02  # [m/s²] below which nothing is told
LEAST_TORQUE = 0.05  # of what the force does at the grips: torques below count as noise


@dataclass(frozen=True, slots=True)
class Misfit:
    """Wrenches that act and that are wanted, ``(W, 6)``, object frame; and what counts as much."""

    acting: FloatArray
    wanted: FloatArray
    scale: FloatArray  # (6,) [N, N·m]: root mean square of what moves the body
    mass: float  # [kg]

    @classmethod
    def of(
        cls, windows: Sequence[Windows], body: Body, dimension: int, declared: float = 0.0
    ) -> "Misfit":
        """Of all windows; ``declared`` is the reach of grips [m], where it was another."""
        acting = np.concatenate([np.hstack(each.acting()) for each in windows])
        wanted = np.concatenate([np.hstack(each.wanted(body, dimension)) for each in windows])
        reach = reach_of(windows)
        return cls.between(acting, wanted, body, (reach, declared or reach))

    @classmethod
    def between(
        cls, acting: FloatArray, wanted: FloatArray, body: Body, reaches: tuple[float, float]
    ) -> "Misfit":
        """Of wrenches ``(W, 6)``; ``reaches`` are how far away grips may be [m]."""
        mass = body.mass if body.mass is not None else np.nan
        return cls(acting, wanted, _scale(wanted, reaches), mass)

    def share(self, acting: FloatArray | None = None) -> float:
        """Mean square of what is left, by that of what moves the body, force and torque alike."""
        left = (self.acting if acting is None else acting) - self.wanted
        return float(((left / self.scale) ** 2).sum(axis=-1).mean() / 2)

    def is_still(self) -> bool:
        """Whether the body hardly moves."""
        return bool(self.scale[0] < STILL * self.mass)


def reach_of(windows: Sequence[Windows]) -> float:
    """The largest coordinate of a grip [m]."""
    return max(float(np.abs(each.motion.grips).max()) for each in windows)


def _scale(wanted: FloatArray, reaches: tuple[float, float]) -> FloatArray:
    """Root mean squares of force and torque, their means taken off."""
    least, most = min(reaches), max(reaches)
    moved = wanted - wanted.mean(axis=0)
    force, torque = (np.sqrt((part**2).sum(axis=-1).mean()) for part in np.hsplit(moved, 2))
    torque = max(torque, LEAST_TORQUE * least * force, 1e-12)
    force = max(force, LEAST_TORQUE * torque / max(most, 1e-3), 1e-12)
    return np.repeat([force, torque], 3)


def best_delay(
    motions: Sequence[Motion],
    body: Body,
    dimension: int,
    sensors: Sequence[int] = (),
    *,
    pose: bool = True,
) -> tuple[float, float]:
    """By how much [s] something is late where that fits best, and the `Misfit.share` then.

    Late may be the pose, or the wrenches of some sensors, or both.
    """
    step = max(each.step for each in motions)
    most = round(DELAYS / step)
    every = max(1, round(0.01 / step))

    def share(rows: int) -> float:
        # a delay is a time: where runs have other steps, it is another number of rows
        moved = [
            each.shifted(round(rows * step / each.step), sensors, pose=pose) for each in motions
        ]
        windows = [each for each in map(Windows, filter(_long, moved)) if len(each)]
        return Misfit.of(windows, body, dimension).share() if windows else np.inf

    rows = list(range(-most // every * every, most + 1, every))
    shares = [share(each) for each in rows]
    best = int(np.argmin(shares))
    if not 0 < best < len(rows) - 1:
        return rows[best] * step, shares[best]
    before, least, after = shares[best - 1 : best + 2]
    curve = before - 2 * least + after
    shift = 0.5 * (before - after) / curve if curve > 0 else 0.0
    least -= 0.125 * (before - after) ** 2 / curve if curve > 0 else 0.0
    return (rows[best] + shift * every) * step, max(least, 0.0)


def _long(motion: Motion) -> bool:
    return len(motion.position) > 2
