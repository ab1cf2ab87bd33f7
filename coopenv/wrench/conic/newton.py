"""Newton steps of `feasible`: the shortest change to balanced wrenches on their balls.

The rows of balance alone couple the effectors, so that a step comes down to one system of 3 or 6
equations.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.conic.parts import (
    NEGLIGIBLE,
    TINY,
    Flags,
    Parts,
    along_lever,
    balance_unit,
    direction,
    norm,
    parts_of,
    turned,
)
from coopenv.wrench.grasp import grasp_matrix

SOFT = 1e-14  # weight of a ball beside balance, squared; in thin sets both can hardly be met
APART = 1e-6  # sine of the angle between a force's two balls from which on both can be met


class Samples(NamedTuple):
    """Applied wrenches and what follows from them; it does not change from step to step."""

    grips: FloatArray
    whole: Parts
    unit: FloatArray  # of each row of balance (m, k)
    rays: BoolArray  # forces that must stay on their line (m, n)
    force_size: FloatArray  # what counts as a change (m, n), 0 for what stays as applied [N]
    torque_size: FloatArray  # [N·m]
    force_balance: FloatArray  # G in these sizes and units, (m, k, n, d)
    torque_balance: FloatArray  # (m, k, n, 1) or (m, k, n, 3)


def samples_of(applied: FloatArray, grips: FloatArray) -> Samples:
    """Prepare applied wrenches ``(m, n, k)`` at grips ``(m, n, d)``.

    A change counts by the geometric mean of the vector's length and the largest: by the vector's
    alone, balance could not be restored where lengths differ by 10⁸.
    """
    whole = parts_of(applied, grips)
    (count, num_effectors, size), dimension = applied.shape, grips.shape[-1]
    force, torque = norm(whole.force), norm(whole.torque)
    unit = balance_unit(whole, grips)
    force_size = np.where(force > NEGLIGIBLE * unit[:, :1], np.sqrt(force * unit[:, :1]), 0.0)
    torque_size = np.where(torque > NEGLIGIBLE * unit[:, -1:], np.sqrt(torque * unit[:, -1:]), 0.0)
    matrix = grasp_matrix(grips).reshape(count, size, num_effectors, size)
    matrix /= unit[:, :, None, None]
    return Samples(
        grips,
        whole,
        unit,
        along_lever(whole, grips),
        force_size,
        torque_size,
        matrix[..., :dimension] * force_size[:, None, :, None],
        matrix[..., dimension:] * torque_size[:, None, :, None],
    )


def newton_step(
    parts: Parts, missing: FloatArray, held: Flags, out: Parts, samples: Samples
) -> FloatArray:
    """Return the shortest change that restores balance and takes held balls to their surface.

    Parameters
    ----------
    parts
        Of the internal wrenches.
    missing
        From their balance ``(m, k)``, in ``samples.unit``.
    held, out
        Which balls to meet, and by how much they are left, ``(m, n)``.
    samples
        The wrenches' applied ones.
    """
    # constraints of each effector: a step to its balls, and a projection that keeps it there
    push, free = _force_constraints(parts, held, out, samples)
    turn, loose = _torque_constraints(parts, held, out, samples)

    # one system for the multipliers of balance
    by_force = np.einsum("mkni,mnij->mknj", samples.force_balance, free)
    by_torque = np.einsum("mkni,mnij->mknj", samples.torque_balance, loose)
    matrix = np.einsum("mkni,mlni->mkl", by_force, samples.force_balance)
    matrix += np.einsum("mkni,mlni->mkl", by_torque, samples.torque_balance)
    missing = missing - np.einsum("mkni,mni->mk", samples.force_balance, push)
    missing -= np.einsum("mkni,mni->mk", samples.torque_balance, turn)
    inverse = np.linalg.pinv(matrix, rcond=1e-15, hermitian=True)
    multipliers = np.einsum("mkl,ml->mk", inverse, missing)

    # the step of each effector
    push = push + np.einsum("mkni,mk->mni", by_force, multipliers)
    turn = turn + np.einsum("mkni,mk->mni", by_torque, multipliers)
    sizes = samples.force_size[..., None], samples.torque_size[..., None]
    return np.concatenate([push * sizes[0], turn * sizes[1]], axis=-1)


def _torque_constraints(
    parts: Parts, held: Flags, out: Parts, samples: Samples
) -> tuple[FloatArray, FloatArray]:
    """Step ``(m, n, d)`` to the surface of held balls, and the projection that stays there."""
    normal = direction(parts.torque - 0.5 * samples.whole.torque) * held.torque[..., None]
    depth = out.torque / np.maximum(samples.torque_size, TINY)
    return -depth[..., None] * normal, np.eye(normal.shape[-1]) - _outer(normal)


def _force_constraints(
    parts: Parts, held: Flags, out: Parts, samples: Samples
) -> tuple[FloatArray, FloatArray]:
    """Do the same for forces, which are held by two balls, or by a line and a ball."""
    whole, size = samples.whole, np.maximum(samples.force_size, TINY)
    normal = direction(parts.force - 0.5 * whole.force) * held.force[..., None]
    wanted = -out.force / size * held.force
    free = np.broadcast_to(np.eye(normal.shape[-1]), (*size.shape, *[normal.shape[-1]] * 2))
    if samples.rays.any():
        rays, line = samples.rays[..., None], direction(whole.force)
        normal = np.where(rays, np.sign((normal * line).sum(-1, keepdims=True)) * line, normal)
        free = np.where(rays[..., None], line[..., :, None] * line[..., None, :], free)
    step = wanted[..., None] * normal
    free = free - _outer(normal)
    twisted = held.induced & ~samples.rays
    if twisted.any():
        row = turned(direction(parts.induced - 0.5 * whole.induced), samples.grips)  # its normal
        lever = np.maximum(norm(row), TINY)
        row = row / lever[..., None]
        shadow = (row * normal).sum(axis=-1)
        second = row - shadow[..., None] * normal
        own = norm(second)
        apart = twisted & (own > APART)
        second = second * (apart / np.maximum(own, TINY))[..., None]
        further = -out.induced / np.maximum(lever * size, TINY) - shadow * wanted
        step = step + (np.where(apart, further, 0.0) / np.maximum(own, TINY))[..., None] * second
        free = free - _outer(second)
    return step, free


def _outer(normal: FloatArray) -> FloatArray:
    """Return (1 − `SOFT`) n nᵀ."""
    return (1.0 - SOFT) * normal[..., :, None] * normal[..., None, :]
