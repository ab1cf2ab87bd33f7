"""Wrenches of any number of effectors, from ordinary to degenerate, and grips for them."""

import numpy as np

from coopenv.arrays import FloatArray

GRIPS = ("scattered", "ring", "line", "integer", "centre")


def grips_of_kind(
    rng: np.random.Generator, kind: str, num_effectors: int, dimension: int
) -> FloatArray:
    """Positions ``(n, d)`` [m]."""
    grips = rng.normal(size=(num_effectors, dimension))
    angle = 2 * np.pi * np.arange(num_effectors) / num_effectors
    if kind == "ring":
        grips = np.zeros_like(grips)
        grips[:, 0], grips[:, 1] = np.cos(angle), np.sin(angle)
    elif kind == "line":
        grips = np.linspace(-1.0, 1.0, num_effectors)[:, None] * np.ones(dimension)
    elif kind == "integer":
        grips = rng.integers(-1, 2, size=grips.shape).astype(float)
    elif kind == "centre":
        grips = np.zeros_like(grips)
    return grips


def agreeing(
    rng: np.random.Generator, count: int, num_effectors: int, dimension: int
) -> FloatArray:
    """Wrenches ``(count, n, k)`` whose forces, and whose torques, point the same way."""
    size = (count, num_effectors, 1)
    force = rng.random(size) * rng.normal(size=(count, 1, dimension))
    torque = rng.random(size) * rng.normal(size=(count, 1, 2 * dimension - 3))
    return np.concatenate([force, torque], axis=-1)


def families(
    rng: np.random.Generator, count: int, num_effectors: int, dimension: int
) -> dict[str, FloatArray]:
    """Families of applied wrenches ``(count, n, k)``."""
    force, torque = slice(0, dimension), slice(dimension, None)
    batch = (count, num_effectors)
    normal = rng.normal(size=(*batch, 3 * dimension - 3))
    agree = agreeing(rng, count, num_effectors, dimension)
    made = {name: normal.copy() for name in ("normal", "no torque", "no force", "zero sum")}
    made["no torque"][..., torque] = 0.0
    made["no force"][..., force] = 0.0
    made["zero sum"] -= normal.mean(axis=1, keepdims=True)
    made["integer"] = rng.integers(-2, 3, size=normal.shape).astype(float)
    made["some zero"] = normal * (rng.random((*batch, 1)) < 0.6)
    made["agreeing"] = agree
    made["nearly agreeing"] = agree + 1e-9 * rng.normal(size=normal.shape)
    made["within 1e-3"] = agree + 1e-3 * rng.normal(size=normal.shape)
    made["forces agree"] = np.concatenate([agree[..., force], normal[..., torque]], axis=-1)
    line = rng.normal(size=(*batch, 1)) * rng.normal(size=(count, 1, dimension))
    made["forces on a line"] = np.concatenate([line, normal[..., torque]], axis=-1)
    made["lines"] = np.concatenate([line, agree[..., torque]], axis=-1)
    made["lines"][..., torque] *= rng.choice([-1.0, 1.0], size=(*batch, 1))
    made["uneven"] = normal * 10.0 ** rng.uniform(-6, 0, size=normal.shape)
    return made
