"""One-dimensional method: of two opposing forces on a line, the smaller cancels as much."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.methods.forces_only import forces_of, without_torque
from coopenv.wrench.settings import Settings

ON_LINE = 1e-9  # part of a force across the line that counts as rounding


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Split two forces on the line through both grips (any line where the grips coincide).

    f_I,i = ½ sgn(f_i) (|f_1| + |f_2| − |f_1 + f_2|)    (eq. 8)

    Raises `InvalidInput` unless there are two effectors, and, when called, where a torque is
    applied or a force leaves the line.

    Source: Donner, Endo & Buss 2018, eq. 8.
    """
    if grips.shape[-2] != 2:
        raise InvalidInput(
            f"grips must be two positions for method='one_dimensional', got {grips.shape[-2]}; "
            "use method='optimal'"
        )
    line = grips[..., 1, :] - grips[..., 0, :]

    def solve(applied: FloatArray) -> Answer:
        force = forces_of(applied, grips, "one_dimensional")
        direction = _direction(line, force)
        along = (force * direction).sum(axis=-1)  # (..., 2) [N], signed
        _require_on_line(force, along[..., None] * direction)
        length = np.abs(along)
        opposed = length.sum(axis=-1) - np.abs(along.sum(axis=-1))
        opposed = np.minimum(0.5 * opposed, length.min(axis=-1))  # no more than the smaller
        internal = (np.sign(along) * opposed[..., None])[..., None] * direction
        return Answer(without_torque(force - internal, applied))

    return Prepared("closed_form", solve)


def _direction(line: FloatArray, force: FloatArray) -> FloatArray:
    """Unit vector ``(..., 1, d)`` of the line; of the larger force where the grips coincide."""
    larger = np.linalg.norm(force, axis=-1).argmax(axis=-1)[..., None, None]
    fallback = np.take_along_axis(force, larger, axis=-2)[..., 0, :]
    direction = np.where(line.any(axis=-1, keepdims=True), line, fallback)
    length = np.linalg.norm(direction, axis=-1, keepdims=True)
    return np.asarray(direction / np.where(length > 0, length, 1.0))[..., None, :]


def _require_on_line(force: FloatArray, along: FloatArray) -> None:
    across = np.linalg.norm(force - along, axis=-1)
    off = across > ON_LINE * np.linalg.norm(force, axis=-1)
    if off.any():
        where = tuple(int(i) for i in np.argwhere(off)[0])
        raise InvalidInput(
            "applied must hold forces on the line through both grips for "
            f"method='one_dimensional', got {force[where]} N, {across[where]:g} N across it, at "
            f"index {where}; use method='optimal'"
        )
