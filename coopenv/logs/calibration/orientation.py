"""Conventions of orientations: quaternions of either order, matrices, Euler angles, vectors."""

import re
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from coopenv.arrays import FloatArray, number_array
from coopenv.errors import InvalidInput, UnknownName

COUNTS = {"quaternion": 4, "matrix": 9, "euler": 3, "rotation_vector": 3}  # numbers of each
ORDERS = {
    "quaternion": ("wxyz", "xyzw"),
    "matrix": ("rows", "columns"),
    "rotation_vector": ("xyz",),
}
IN_ANGLES = ("euler", "rotation_vector")  # whose numbers have the unit of angles
SEQUENCE = re.compile(r"(?:[xyz]{3}|[XYZ]{3})")
ORTHOGONAL = 0.01  # how far RᵀR may be from 1, as the length of a quaternion may


def quaternions(values: npt.ArrayLike, kind: str, order: str | None = None) -> FloatArray:
    """Unit quaternions w, x, y, z of orientations written in some other way.

    Parameters
    ----------
    values
        ``(..., 4)``, ``(..., 9)`` or ``(..., 3)`` [rad], as ``kind`` is.
    kind
        ``"quaternion"``, ``"matrix"``, ``"euler"``, or ``"rotation_vector"``: along the axis of the
        rotation, as long as its angle.
    order
        Of a quaternion: ``"wxyz"`` (default) or ``"xyzw"``. Of a matrix: ``"rows"`` (default), row
        by row, or ``"columns"``. Of Euler angles: three axes, small letters about the axes of the
        world, capitals about those that turn with the object, such as ``"ZYX"``; no default. Of a
        rotation vector: ``"xyz"``.

    Returns
    -------
    ``(..., 4)``; quaternions keep their length. NaN where a number is, and zero where nine numbers
    are no rotation (RᵀR ≠ 1 by more than 0.01, or a mirror image).

    Raises
    ------
    UnknownName
        If there is no such kind or order.
    InvalidInput
        If a shape is wrong.
    """
    order = checked_order(kind, order, "order")
    given = number_array(values, "values")
    if not given.ndim or given.shape[-1] != COUNTS[kind]:
        raise InvalidInput(
            f"values must be {COUNTS[kind]} numbers each for a {kind}, got shape {given.shape}; "
            "put them on the last axis"
        )
    if kind == "quaternion":
        return given[..., [3, 0, 1, 2]] if order == "xyzw" else given.copy()
    flat = given.reshape(-1, COUNTS[kind])
    usable = np.asarray(np.isfinite(flat).all(axis=-1))
    made = np.full((len(flat), 4), np.nan)
    if kind == "euler":
        made[usable] = _wxyz(Rotation.from_euler(order, flat[usable]))
        return made.reshape(*given.shape[:-1], 4)
    if kind == "rotation_vector":
        made[usable] = _wxyz(Rotation.from_rotvec(flat[usable]))
        return made.reshape(*given.shape[:-1], 4)
    matrix = flat.reshape(-1, 3, 3)
    matrix = matrix.swapaxes(1, 2) if order == "columns" else matrix
    made[usable] = 0.0
    usable[usable] = are_rotations(matrix[usable])
    made[usable] = _wxyz(Rotation.from_matrix(matrix[usable]))
    return made.reshape(*given.shape[:-1], 4)


def heading(quaternion: FloatArray) -> FloatArray:
    """Angle ``(...)`` [rad] about z to which the object's x axis is turned; in (−π, π].

    ``quaternion`` is ``(..., 4)`` w, x, y, z; of unit length, which for an orientation in the plane
    is all that matters.
    """
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    return np.arctan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def tilt(quaternion: FloatArray) -> FloatArray:
    """Angle ``(...)`` [rad] between the object's z axis and the world's; as in `heading`."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    with np.errstate(over="ignore", invalid="ignore"):
        return 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))


def rotation_matrix(quaternion: FloatArray) -> FloatArray:
    """Matrices ``(..., 3, 3)`` of quaternions ``(..., 4)`` w, x, y, z of any length but zero."""
    flat = quaternion.reshape(-1, 4)[:, [1, 2, 3, 0]]
    return Rotation.from_quat(flat).as_matrix().reshape(*quaternion.shape[:-1], 3, 3)


def are_rotations(matrix: FloatArray) -> npt.NDArray[np.bool_]:
    """Which matrices ``(..., d, d)`` are rotations, within `ORTHOGONAL`."""
    with np.errstate(over="ignore", invalid="ignore"):
        product = matrix.swapaxes(-1, -2) @ matrix
        near = (np.abs(product - np.eye(matrix.shape[-1])) < ORTHOGONAL).all(axis=(-1, -2))
        return near & (np.linalg.det(np.where(near[..., None, None], matrix, 0.0)) > 0)


def checked_order(kind: str, order: str | None, key: str) -> str:
    """The order of an orientation of that kind, by default the first that is known."""
    if not isinstance(kind, str) or kind not in COUNTS:
        raise UnknownName("kind of orientation", kind, COUNTS)
    if kind == "euler":
        fits = isinstance(order, str) and SEQUENCE.fullmatch(order)
        if not fits or not order or any(a == b for a, b in pairwise(order)):
            raise InvalidInput(
                f"{key} must be three axes for Euler angles, got {order!r}; write 'ZYX' for angles "
                "about the axes that turn with the object, 'xyz' for those of the world"
            )
        return order
    if order is None:
        return ORDERS[kind][0]
    if order not in ORDERS[kind]:
        raise UnknownName(key, order, ORDERS[kind])
    return order


def _wxyz(rotation: Rotation) -> FloatArray:
    return rotation.as_quat()[..., [3, 0, 1, 2]]
