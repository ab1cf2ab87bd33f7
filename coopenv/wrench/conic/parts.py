"""Parts of wrenches with constraints of their own: forces, torques and induced torques."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import TINY
from coopenv.wrench.grasp import cross, moment

PARALLEL = 1e-12  # sine of the angle below which two vectors count as parallel
NEGLIGIBLE = 1e-12  # part of the largest force or torque below which a vector is left as applied


class Parts(NamedTuple):
    """An array for each of forces, torques and induced torques."""

    force: FloatArray
    torque: FloatArray
    induced: FloatArray


class Prices(NamedTuple):
    """Cost of forces [1], torques and induced torques [1/m]."""

    force: float
    torque: float
    induced: float


class Flags(NamedTuple):
    """Whether something holds for each of forces, torques and induced torques ``(m, n)``."""

    force: BoolArray
    torque: BoolArray
    induced: BoolArray


def parts_of(wrench: FloatArray, grips: FloatArray) -> Parts:
    """Return forces ``(m, n, d)`` [N], torques and induced torques [N·m]."""
    dimension = grips.shape[-1]
    return Parts(wrench[..., :dimension], wrench[..., dimension:], moment(grips, wrench))


def turned(torque: FloatArray, grips: FloatArray) -> FloatArray:
    """Return S(r)ᵀ τ, the multiplier of a force f for a multiplier τ of the torque r × f."""
    if grips.shape[-1] == 2:
        return torque * np.stack([-grips[..., 1], grips[..., 0]], axis=-1)
    return cross(torque, grips)


def balance_unit(whole: Parts, grips: FloatArray) -> FloatArray:
    """Return the largest force or torque that is balanced in each row of balance ``(m, k)``."""
    force = norm(whole.force).max(axis=-1, keepdims=True)
    torque = np.maximum(
        norm(whole.torque).max(axis=-1, keepdims=True),
        norm(grips).max(axis=-1, keepdims=True) * force,
    )
    rows = [whole.force.shape[-1], whole.torque.shape[-1]]
    return np.maximum(np.repeat(np.concatenate([force, torque], axis=-1), rows, axis=-1), TINY)


def along_lever(whole: Parts, grips: FloatArray) -> BoolArray:
    """Whether a force points along its lever, so that its manipulation part must, too."""
    reach = norm(whole.force) * norm(grips)
    return np.asarray((reach > 0.0) & (norm(whole.induced) <= PARALLEL * reach))


def cost_of(whole: Parts, weights: Prices) -> FloatArray:
    """The objective (17), ``(m)`` [N]."""
    return sum_over(weights, Parts(*map(norm, whole)))


def saving_of(internal: Parts, whole: Parts, weights: Prices) -> FloatArray:
    """J(h) − J(h − h_I), ``(m)`` [N], accurate where h_I is small."""
    saved = []
    for g, v in zip(internal, whole, strict=True):
        lengths = np.maximum(norm(v) + norm(v - g), TINY)
        saved.append((g * ((v - g) + v)).sum(axis=-1) / lengths)
    return sum_over(weights, Parts(*saved))


def sum_over(weights: Prices | Parts, values: Parts) -> FloatArray:
    """Weighted sum of ``(m, n)`` values over parts and effectors."""
    force, torque, induced = (w * v for w, v in zip(weights, values, strict=True))
    return (force + torque + induced).sum(axis=-1)


def norm(vectors: FloatArray) -> FloatArray:
    """Return lengths along the last axis."""
    return np.sqrt((vectors * vectors).sum(axis=-1))


def direction(vectors: FloatArray) -> FloatArray:
    """Return unit vectors, 0 for 0."""
    return vectors / np.maximum(norm(vectors), TINY)[..., None]
