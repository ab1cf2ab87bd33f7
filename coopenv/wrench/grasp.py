"""Grasp matrix, object wrench and induced torque, and validation of grips and wrenches."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.compiled import gufunc, inlined
from coopenv.errors import InvalidInput


def grasp_matrix(grips: npt.ArrayLike) -> FloatArray:
    """Matrix G that sums the effectors' wrenches at the centre of mass.

    h_o = G h    (eq. 1),  with  f_o = Σ f_i  and  t_o = Σ (r_i × f_i + t_i)    (eq. 2)

    Parameters
    ----------
    grips
        ``(..., n, 2)`` planar or ``(..., n, 3)`` spatial, object frame [m].

    Returns
    -------
    ``(..., 3, 3n)`` planar or ``(..., 6, 6n)`` spatial; it acts on the effectors' wrenches
    written one after the other.

    Raises
    ------
    InvalidInput
        If ``grips`` has another shape or a non-finite element.
    """
    grips = checked_grips(grips)
    *batch, num_effectors, dimension = grips.shape
    size = wrench_size(dimension)
    matrix = np.zeros((*batch, size, num_effectors, size))
    matrix[...] = np.eye(size)[:, None, :]
    x, y = grips[..., 0], grips[..., 1]
    if dimension == 2:
        matrix[..., 2, :, 0] = -y
        matrix[..., 2, :, 1] = x
    else:
        z = grips[..., 2]
        matrix[..., 3, :, 1], matrix[..., 3, :, 2] = -z, y
        matrix[..., 4, :, 0], matrix[..., 4, :, 2] = z, -x
        matrix[..., 5, :, 0], matrix[..., 5, :, 1] = -y, x
    return matrix.reshape(*batch, size, num_effectors * size)


def object_wrench(applied: npt.ArrayLike, grips: npt.ArrayLike) -> FloatArray:
    """Resultant of all effectors at the centre of mass, h_o = G h (eq. 1).

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].

    Returns
    -------
    ``(..., 3)`` or ``(..., 6)`` [N, N·m].

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.
    """
    grips = checked_grips(grips)
    return sum_at_centre(checked_applied(applied, grips), grips)


def induced_torque(applied: npt.ArrayLike, grips: npt.ArrayLike) -> FloatArray:
    """Torque of each effector's force about the centre of mass, t_f,i = r_i × f_i (eq. 3).

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].

    Returns
    -------
    ``(..., n, 1)`` planar or ``(..., n, 3)`` spatial [N·m].

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.
    """
    grips = checked_grips(grips)
    return moment(grips, checked_applied(applied, grips))


def moment(grips: FloatArray, applied: FloatArray) -> FloatArray:
    """Return `induced_torque` of arrays that were checked before."""
    if grips.shape[-1] == 2:
        x, y = grips[..., 0], grips[..., 1]
        return (x * applied[..., 1] - y * applied[..., 0])[..., None]
    return cross(grips, applied[..., :3])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a × b ``(..., 3)``; the same bits as NumPy's, but faster."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def checked_grips(grips: npt.ArrayLike) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless one position per effector."""
    grips = finite_array(grips, "grips")
    if grips.ndim < 2 or grips.shape[-1] not in (2, 3) or grips.shape[-2] < 1:
        raise InvalidInput(
            f"grips must be of shape (..., n, 2) in the plane or (..., n, 3) in space, got "
            f"{grips.shape}; give one position in the object frame per effector [m]"
        )
    return grips


def checked_applied(applied: npt.ArrayLike, grips: FloatArray) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless it holds one wrench per grip."""
    applied = finite_array(applied, "applied")
    require_wrench_per_grip(applied, grips)
    return applied


def require_wrench_per_grip(
    applied: FloatArray, grips: FloatArray, *, name: str = "applied"
) -> None:
    """Raise `InvalidInput` unless ``applied``, called ``name``, holds one wrench per grip."""
    num_effectors, dimension = grips.shape[-2:]
    expected = (num_effectors, wrench_size(dimension))
    if applied.shape[-2:] != expected:
        raise InvalidInput(
            f"{name} must be of shape (..., {expected[0]}, {expected[1]}) for grips of shape "
            f"{grips.shape}, got {applied.shape}; give one wrench [force, torque] per grip"
        )
    require_batch(name, applied.shape[:-2], grips)


def require_batch(name: str, batch: tuple[int, ...], grips: FloatArray) -> None:
    """Raise `InvalidInput` unless a batch shape goes with that of the grips."""
    try:
        np.broadcast_shapes(batch, grips.shape[:-2])
    except ValueError as error:
        raise InvalidInput(
            f"{name} must be of a batch shape that broadcasts against that of grips "
            f"{grips.shape[:-2]}, got {batch}; give grips of shape {grips.shape[-2:]} or one set "
            "per sample"
        ) from error


def wrench_size(dimension: int) -> int:
    """Length of a wrench: 3 in the plane, 6 in space."""
    return 3 if dimension == 2 else 6


@inlined
def write_sum(applied, grips, resultant):
    """Sum one sample's wrenches at the centre of mass."""
    num_effectors, size = applied.shape
    for k in range(size):
        resultant[k] = 0.0
        for i in range(num_effectors):
            resultant[k] += applied[i, k]
    for i in range(num_effectors):
        x, y = grips[i, 0], grips[i, 1]
        if size == 3:
            resultant[2] += x * applied[i, 1] - y * applied[i, 0]
        else:
            z = grips[i, 2]
            resultant[3] += y * applied[i, 2] - z * applied[i, 1]
            resultant[4] += z * applied[i, 0] - x * applied[i, 2]
            resultant[5] += x * applied[i, 1] - y * applied[i, 0]


@gufunc("(n,k),(n,d)->(k)", "void(float64[:,:], float64[:,:], float64[:])")
def sum_at_centre(applied, grips, resultant):
    """Sum the effectors' wrenches at the centre of mass."""
    write_sum(applied, grips, resultant)
