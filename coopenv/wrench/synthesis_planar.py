"""A wish of two planar effectors in its own units: what is plausible and has the wanted shares.

The x axis is laid along the line through the grips. F is the wanted resultant force, g the wanted
internal force on effector 1, p the manipulation force of effector 1 and F − p that of effector 2;
T(p) is the torque that is left to pure torques.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.measure_kernels import load_share_kernel

PLAUSIBLE = 1e-4  # by how much a candidate may miss plausibility: wishes are rounded
SHARED = 1e-7  # by how much a candidate may miss a share


class Wish(NamedTuple):
    """One wish in its own units, D along x: no force, no lever is much longer than 1."""

    force: FloatArray  # F (2,)
    torque: float  # t_o
    internal: FloatArray  # g (2,)
    internal_torque: FloatArray  # t_I (2,)
    force_share: float  # of effector 1, NaN where open
    torque_share: float
    grips: FloatArray  # (2, 2)
    costs: tuple[float, float, float]  # of force, torque, induced torque


def torque_left(wish: Wish, point: FloatArray) -> FloatArray:
    """T, what is left to pure torques."""
    own = wish.torque - float(cross(wish.grips[1], wish.force))
    return own - cross(wish.grips[0] - wish.grips[1], point)


def torque_share_misses(wish: Wish, point: FloatArray) -> list[FloatArray]:
    """What effector 1's torque at the centre misses of its share, with each part of T."""
    induced = cross(wish.grips[0], point + wish.internal) + wish.internal_torque[0]
    asked = np.nan_to_num(wish.torque_share) * wish.torque
    return [induced + part * torque_left(wish, point) - asked for part in parts(wish)]


def parts(wish: Wish) -> tuple[float, ...]:
    """Parts of T that effector 1 may supply: all, none, in proportion to what is internal."""
    own, other = wish.internal_torque
    return 0.0, 1.0, own / (own + other) if own * other > 0.0 else 0.5


def shared_torque(wish: Wish, point: FloatArray) -> FloatArray:
    """What effector 1's pure torque must be for the torque share."""
    asked = wish.torque_share * wish.torque - wish.internal_torque[0]
    return asked - cross(wish.grips[0], point + wish.internal)


def with_torques(wish: Wish, point: FloatArray, splits: list[FloatArray]) -> FloatArray:
    """Manipulation wrenches ``(..., split, 2, 3)`` from forces p and pure torques of effector 1."""
    own = np.stack(splits, axis=-1)
    manipulation = np.empty((*own.shape, 2, 3))
    manipulation[..., 0, :2] = point[..., None, :]
    manipulation[..., 1, :2] = wish.force - point[..., None, :]
    manipulation[..., 0, 2] = own
    manipulation[..., 1, 2] = torque_left(wish, point)[..., None] - own
    return manipulation


def is_sensible(wish: Wish, manipulation: FloatArray) -> BoolArray:
    """Whether manipulation wrenches ``(m, 2, 3)`` are plausible and have the wanted shares."""
    return _is_plausible(wish, manipulation) & _has_shares(wish, manipulation)


def _is_plausible(wish: Wish, manipulation: FloatArray) -> BoolArray:
    """Whether nothing internal exceeds what is applied (eqs. 9-11), and no pure torques cancel."""
    good = np.isfinite(manipulation).all(axis=(-1, -2))
    left = manipulation[..., 2].sum(axis=-1)
    for k, internal in enumerate((wish.internal, -wish.internal)):
        force, torque, grip = manipulation[:, k, :2], manipulation[:, k, 2], wish.grips[k]
        good &= force @ internal >= -PLAUSIBLE
        good &= cross(grip, force) * cross(grip, internal) >= -PLAUSIBLE
        good &= torque * wish.internal_torque[k] >= -PLAUSIBLE
        good &= torque * left >= -PLAUSIBLE
    return np.asarray(good)


def _has_shares(wish: Wish, manipulation: FloatArray) -> BoolArray:
    internal = np.column_stack([[wish.internal, -wish.internal], wish.internal_torque])
    applied = np.where(np.isfinite(manipulation), manipulation + internal, 0.0)
    good = np.ones(len(applied), dtype=np.bool_)
    shares = load_share_kernel(applied, wish.grips)
    for share, wanted in zip(shares, (wish.force_share, wish.torque_share), strict=True):
        good &= bool(np.isnan(wanted)) | (np.abs(share[:, 0] - wanted) <= SHARED)
    return good


def turned(vector: FloatArray) -> FloatArray:
    """By a right angle."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return one × other, the component across the plane."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
