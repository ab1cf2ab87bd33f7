"""Pseudoinverse methods: allocation by a generalised inverse of the grasp matrix."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput, UnknownName
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.grasp import (
    checked_grips,
    grasp_matrix,
    require_batch,
    sum_at_centre,
    wrench_size,
)
from coopenv.wrench.settings import Settings

ALLOCATIONS = ("moore_penrose", "nonsqueezing", "parametrized")


def allocate(
    object_wrench: npt.ArrayLike,
    grips: npt.ArrayLike,
    method: str = "moore_penrose",
    *,
    virtual_masses: npt.ArrayLike | None = None,
    virtual_inertias: npt.ArrayLike | None = None,
) -> FloatArray:
    """Share a wanted object wrench among the effectors, h = G⁺ h_o.

    - ``moore_penrose``: G† = Gᵀ(G Gᵀ)⁻¹, least squares (eq. 7)
    - ``nonsqueezing``: f_i = f_o/n, t_i = (t_o − r_i × f_o)/n (Walker et al.)
    - ``parametrized``: f_i = (m_i*/m_o*) f_o + m_i* S(r_i)ᵀ J_o*⁻¹ t_o, t_i = J_i* J_o*⁻¹ t_o,
      with m_o* = Σ m_i*, J_o* = Σ J_i* + Σ S(r_i) m_i* S(r_i)ᵀ (eqs. 30-33)

    Parameters
    ----------
    object_wrench
        ``(..., 3)`` planar or ``(..., 6)`` spatial, at the centre of mass [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].
    method
        One of the three above.
    virtual_masses, virtual_inertias
        For ``parametrized``: m_i* ``(n,)`` [kg] with Σ m_i* r_i = 0, and J_i* ``(n,)``, in space
        also ``(n, 3, 3)`` [kg m²]; all 1 by default.

    Returns
    -------
    Applied wrenches ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m] whose resultant is
    ``object_wrench``.

    Raises
    ------
    UnknownName
        If the method does not exist.
    InvalidInput
        If a shape or a number is wrong, or Σ m_i* r_i ≠ 0.

    Source: Donner, Endo & Buss 2018, eqs. 7, 30-33. Deviation: the order of factors in (30), which
    as printed fails G G⁺ = I for n > 2.
    """
    if method not in ALLOCATIONS:
        raise UnknownName("method", method, ALLOCATIONS)
    grips = checked_grips(grips)
    wanted = finite_array(object_wrench, "object_wrench")
    size = wrench_size(grips.shape[-1])
    if wanted.shape[-1:] != (size,):
        raise InvalidInput(
            f"object_wrench must be of shape (..., {size}) for grips of shape {grips.shape}, got "
            f"{wanted.shape}; give [force, torque] at the centre of mass"
        )
    require_batch("object_wrench", wanted.shape[:-1], grips)
    return _apply(_inverse(grips, method, virtual_masses, virtual_inertias), wanted, grips)


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Compute the generalised inverse once; what it allocates counts as manipulation."""
    inverse = _inverse(grips, settings.method, settings.virtual_masses, settings.virtual_inertias)

    def solve(applied: FloatArray) -> Answer:
        return Answer(_apply(inverse, sum_at_centre(applied, grips), grips))

    return Prepared("closed_form", solve)


def _apply(inverse: FloatArray, resultant: FloatArray, grips: FloatArray) -> FloatArray:
    flat = (inverse @ resultant[..., None])[..., 0]
    return flat.reshape(*flat.shape[:-1], grips.shape[-2], resultant.shape[-1])


def _inverse(grips: FloatArray, method: str, masses: Any, inertias: Any) -> FloatArray:
    """Generalised inverse ``(..., 3n, 3)`` or ``(..., 6n, 6)``."""
    num_effectors = grips.shape[-2]
    if method == "parametrized":
        return _parametrized(grips, masses, inertias)
    for name, value in (("virtual_masses", masses), ("virtual_inertias", inertias)):
        if value is not None:
            raise InvalidInput(
                f"{name} must be left out for method={method!r}, got {value!r}; "
                "it belongs to method='parametrized'"
            )
    matrix = grasp_matrix(grips)
    if method == "moore_penrose":
        return np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
    dimension = grips.shape[-1]
    blocks = _grasp_blocks(grips)
    blocks[..., dimension:, :dimension] *= -1.0
    inverse = blocks / num_effectors
    return _as_rows(inverse)


def _grasp_blocks(grips: FloatArray) -> FloatArray:
    """G_i of each effector, ``(..., n, k, k)``."""
    matrix = grasp_matrix(grips)
    *batch, size, _ = matrix.shape
    return np.moveaxis(matrix.reshape(*batch, size, grips.shape[-2], size), -2, -3).copy()


def _parametrized(grips: FloatArray, masses: Any, inertias: Any) -> FloatArray:
    """G_M⁺ (eqs. 30-33)."""
    num_effectors, dimension = grips.shape[-2:]
    mass = _virtual_masses(masses, grips)
    inertia = _virtual_inertias(inertias, num_effectors, dimension)
    blocks = _grasp_blocks(grips)
    cross = blocks[..., dimension:, :dimension]  # S(r_i), (..., n, kt, d)
    weighted = mass[:, None, None] * np.swapaxes(cross, -1, -2)
    object_inertia = inertia.sum(axis=0) + (cross @ weighted).sum(axis=-3)
    angular = np.linalg.inv(object_inertia)[..., None, :, :]
    inverse: FloatArray = np.zeros_like(blocks)
    inverse[..., :dimension, :dimension] = mass[:, None, None] / mass.sum() * np.eye(dimension)
    inverse[..., :dimension, dimension:] = weighted @ angular
    inverse[..., dimension:, dimension:] = inertia @ angular
    return _as_rows(inverse)


def _as_rows(inverse: FloatArray) -> FloatArray:
    """Blocks ``(..., n, k, k)`` beneath one another, ``(..., n·k, k)``."""
    *batch, num_effectors, size, _ = inverse.shape
    return inverse.reshape(*batch, num_effectors * size, size)


def _virtual_masses(masses: Any, grips: FloatArray) -> FloatArray:
    num_effectors = grips.shape[-2]
    mass = np.ones(num_effectors) if masses is None else finite_array(masses, "virtual_masses")
    if mass.shape != (num_effectors,) or not (mass > 0).all():
        raise InvalidInput(
            f"virtual_masses must be {num_effectors} positive numbers, so that m_o* = Σ m_i* "
            f"(eq. 31) is positive, got {mass}; give one per grip [kg]"
        )
    offset = np.abs((mass[:, None] * grips).sum(axis=-2)).max(initial=0.0)
    if offset > 1e-9 * (mass[:, None] * np.abs(grips)).sum(axis=-2).max(initial=0.0):
        raise InvalidInput(
            f"virtual_masses must have their centre at the object's, Σ m_i* r_i = 0 (eq. 33), got "
            f"{mass} at grips {np.array2string(grips, threshold=8)}; choose masses that balance "
            "these grips"
        )
    return mass


def _virtual_inertias(inertias: Any, num_effectors: int, dimension: int) -> FloatArray:
    """J_i* as matrices ``(n, 1, 1)`` or ``(n, 3, 3)``."""
    size = 1 if dimension == 2 else 3
    if inertias is None:
        inertias = np.ones(num_effectors)
    inertia = finite_array(inertias, "virtual_inertias")
    if inertia.shape == (num_effectors,):
        inertia = inertia[:, None, None] * np.eye(size)
    allowed = inertia.shape == (num_effectors, size, size)
    if not allowed or not (np.linalg.eigvalsh(inertia) > 0).all():
        raise InvalidInput(
            f"virtual_inertias must be {num_effectors} positive numbers"
            f"{' or positive definite 3×3 matrices' if size == 3 else ''}, so that J_o* (eq. 32) "
            f"is positive, got {inertias!r}; give one per grip [kg m²]"
        )
    return inertia
