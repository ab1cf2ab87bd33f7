"""Constraint violation method: what keeps the effectors from accelerating as desired is internal.

It is no method of `decompose`, as it does not ask what the effectors applied.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_grips, grasp_matrix, require_batch, wrench_size


def constraint_violation(
    desired_acceleration: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    masses: npt.ArrayLike,
    inertias: npt.ArrayLike,
    angular_velocity: npt.ArrayLike | None = None,
) -> FloatArray:
    """Internal wrench of effectors whose desired accelerations a rigid object cannot follow.

    A rigid object constrains the effectors' accelerations, A ẍ = b. Violating the constraint by
    ẍᵈ costs the wrench Aᵀ Λ (b − A ẍᵈ) on the effectors, Λ = (A M⁻¹ Aᵀ)⁻¹; on the object it is

        h_I = −Aᵀ Λ (b − A ẍᵈ) = M (ẍᵈ − ẍ)

    where ẍ is the rigid motion nearest to ẍᵈ in the metric M (Gauss's principle), which is how it
    is computed. It balances, G h_I = 0, but does not depend on what was applied and can exceed it
    (footnote 2 of Donner, Endo & Buss 2018).

    Parameters
    ----------
    desired_acceleration
        ẍᵈ, ``(..., n, 3)`` planar [ax, ay, α] or ``(..., n, 6)`` spatial, of the effectors at
        their grips, object frame [m/s², rad/s²].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it, object frame [m].
    masses
        Apparent masses of the effectors, ``(n,)`` [kg].
    inertias
        Apparent inertias, ``(n,)``, in space also ``(n, 3, 3)`` [kg m²].
    angular_velocity
        ω of the object, ``(...)`` planar or ``(..., 3)`` spatial [rad/s]; 0 if left out.

    Returns
    -------
    h_I ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m].

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong, or a mass or inertia is not positive.

    Source: Erhart & Hirche 2015, as quoted in Donner, Endo & Buss 2018; the original's formula was
    not re-read.
    """
    grips = checked_grips(grips)
    num_effectors, dimension = grips.shape[-2:]
    size = wrench_size(dimension)
    desired = finite_array(desired_acceleration, "desired_acceleration")
    if desired.shape[-2:] != (num_effectors, size):
        raise InvalidInput(
            f"desired_acceleration must be of shape (..., {num_effectors}, {size}) for grips of "
            f"shape {grips.shape}, got {desired.shape}; give [linear, angular] per grip"
        )
    require_batch("desired_acceleration", desired.shape[:-2], grips)
    inertia = _inertia_matrix(masses, inertias, num_effectors, dimension)
    blocks = np.swapaxes(grasp_matrix(grips), -1, -2)
    motion = blocks.reshape(*grips.shape[:-2], num_effectors, size, size)  # G_iᵀ: rigid motions
    turning = _centripetal(angular_velocity, grips, size)
    if turning.ndim > 2:
        require_batch("angular_velocity", turning.shape[:-2], desired)
    wanted = desired - turning
    weighted = inertia @ motion
    metric = np.einsum("...nij,...nik->...jk", motion, weighted)  # G M Gᵀ
    demand = np.einsum("...nij,...ni->...j", weighted, wanted)  # G M ẍᵈ
    nearest = np.linalg.solve(metric, demand[..., None])[..., 0]
    missed = wanted - np.einsum("...nij,...j->...ni", motion, nearest)
    return np.einsum("nij,...nj->...ni", inertia, missed)


def _inertia_matrix(masses: Any, inertias: Any, num_effectors: int, dimension: int) -> FloatArray:
    """M, block by block ``(n, 3, 3)`` or ``(n, 6, 6)`` [kg, kg m²]."""
    mass = finite_array(masses, "masses")
    if mass.shape != (num_effectors,) or not (mass > 0).all():
        raise InvalidInput(
            f"masses must be {num_effectors} positive numbers, got {masses!r}; "
            "give one per grip [kg]"
        )
    angular = wrench_size(dimension) - dimension
    inertia = finite_array(inertias, "inertias")
    if inertia.shape == (num_effectors,):
        inertia = inertia[:, None, None] * np.eye(angular)
    allowed = inertia.shape == (num_effectors, angular, angular)
    if not allowed or not (np.linalg.eigvalsh(inertia) > 0).all():
        raise InvalidInput(
            f"inertias must be {num_effectors} positive numbers"
            f"{' or positive definite 3×3 matrices' if angular == 3 else ''}, got {inertias!r}; "
            "give one per grip [kg m²]"
        )
    matrix = np.zeros((num_effectors, dimension + angular, dimension + angular))
    matrix[:, :dimension, :dimension] = mass[:, None, None] * np.eye(dimension)
    matrix[:, dimension:, dimension:] = inertia
    return matrix


def _centripetal(angular_velocity: Any, grips: FloatArray, size: int) -> FloatArray:
    """What turning alone asks of the grips, ω × (ω × r_i), with no angular part."""
    if angular_velocity is None:
        return np.zeros(size)
    dimension = grips.shape[-1]
    omega = finite_array(angular_velocity, "angular_velocity")
    if dimension == 3 and omega.shape[-1:] != (3,):
        raise InvalidInput(
            f"angular_velocity must be of shape (..., 3) for grips in space, got {omega.shape}; "
            "give it in the object frame [rad/s]"
        )
    batch = omega.shape if dimension == 2 else omega.shape[:-1]
    require_batch("angular_velocity", batch, grips)
    if dimension == 2:
        linear = -(omega**2)[..., None, None] * grips
    else:
        linear = np.cross(omega[..., None, :], np.cross(omega[..., None, :], grips))
    return np.concatenate([linear, np.zeros((*linear.shape[:-1], size - dimension))], axis=-1)
