"""Applied wrenches and grips to try everything on, and feasible alternatives to beat."""

from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from coopenv.arrays import FloatArray

LEVERS = (  # signed distances of both grips from the centre of mass [m]
    (-0.9, 0.9),
    (-1.0, 1.0),  # costs tie at torque weight 0.5
    (-0.4, 1.3),
    (0.3, 1.1),  # both on one side
    (1.1, 0.3),
    (-0.5, 0.0),  # the walker
    (0.0, 0.7),
    (0.0, 0.0),
    (0.6, 0.6),  # at the same place
    (0.002, 5.0),
)
ANGLES = (0.0, 0.5 * np.pi, 0.7, 2.9, -1.3)  # of the line through the grips [rad]
SCALES = (1e-6, 1.0, 1e6)


class PairCase(NamedTuple):
    """A batch of wrenches at one pair of grips."""

    name: str
    applied: FloatArray  # (batch, 2, 3)
    grips: FloatArray  # (2, 2)


def grips_on_line(levers: tuple[float, float], angle: float) -> FloatArray:
    """Place two grips at signed distances along a line through the centre of mass."""
    return np.outer(levers, [np.cos(angle), np.sin(angle)])


def pair_families(rng: np.random.Generator, count: int) -> dict[str, FloatArray]:
    """Families of applied wrenches ``(count, 2, 3)``, from ordinary to degenerate."""
    normal = rng.normal(size=(count, 2, 3))
    integer = rng.integers(-3, 4, size=(count, 2, 3)).astype(float)
    opposite = normal.copy()
    opposite[:, 1, :2] = -opposite[:, 0, :2] * rng.choice([1.0, 0.5, 2.0], size=(count, 1))
    parallel = normal.copy()
    parallel[:, 1, :2] = parallel[:, 0, :2] * rng.uniform(0.1, 3.0, size=(count, 1))
    nearly = parallel.copy()
    nearly[:, 1, :2] += 1e-9 * rng.normal(size=(count, 2))
    one_sided = integer.copy()
    one_sided[:, 1, :2] = 0.0
    forces = normal.copy()
    forces[..., 2] = 0.0
    torques = normal.copy()
    torques[..., :2] = 0.0
    along = normal.copy()
    along[..., 1] = 0.0
    couple = integer.copy()
    couple[..., 0] = 0.0
    couple[:, 1, 1] = -couple[:, 0, 1]
    uneven = normal * 10.0 ** rng.uniform(-8, 0, size=(count, 2, 3))
    return {
        "normal": normal,
        "integer": integer,
        "opposite": opposite,
        "parallel": parallel,
        "nearly parallel": nearly,
        "one force": one_sided,
        "no torque": forces,
        "no force": torques,
        "along the line": along,
        "couple": couple,
        "uneven": uneven,
    }


def pair_cases(rng: np.random.Generator, count: int) -> list[PairCase]:
    """Every family at every pair of levers, each turned and scaled differently."""
    cases = []
    for levers in LEVERS:
        for name, applied in pair_families(rng, count).items():
            angle = ANGLES[len(cases) % len(ANGLES)]
            scale = SCALES[len(cases) % len(SCALES)]
            turned = rotated(applied, angle) * scale
            title = f"{name} at {levers}, {angle:.2f} rad, scale {scale:g}"
            cases.append(PairCase(title, turned, grips_on_line(levers, angle)))
    return cases


def rotated(vectors: FloatArray, angle: float) -> FloatArray:
    """Turn planar wrenches ``(..., 3)`` or positions ``(..., 2)``."""
    c, s = np.cos(angle), np.sin(angle)
    turned = vectors.copy()
    turned[..., 0] = c * vectors[..., 0] - s * vectors[..., 1]
    turned[..., 1] = s * vectors[..., 0] + c * vectors[..., 1]
    return turned


def planar_cost(
    wrench: FloatArray, grips: FloatArray, torque_weight: float, include_induced: bool
) -> FloatArray:
    """Evaluate eq. 17, written down again."""
    force = np.hypot(wrench[..., 0], wrench[..., 1])
    induced = grips[..., 0] * wrench[..., 1] - grips[..., 1] * wrench[..., 0]
    torque = np.abs(wrench[..., 2]) + include_induced * np.abs(induced)
    return ((1 - torque_weight) * force + torque_weight * torque).sum(axis=-1)


def feasible_internal(
    rng: np.random.Generator, applied: FloatArray, grips: FloatArray, count: int
) -> FloatArray:
    """Draw ``count`` plausible internal wrenches of two planar effectors per sample.

    From 0, which is plausible, go in a random direction that balances. Every constraint is a ball
    through 0, ‖x_I‖² ≤ xᵀx_I, so how far one may go is known. ``(count, batch, 2, 3)``.
    """
    size = np.abs(applied).max(axis=(-2, -1), keepdims=True)
    step = rng.normal(size=(count, *applied.shape)) * 10.0 ** rng.uniform(
        -3, 0, size=(count, *applied.shape)
    )
    towards = rng.random((count, *applied.shape[:-2], 1, 1)) < 0.5
    step = np.where(towards, np.abs(step) * np.sign(applied), step) * size
    lever = grips[0] - grips[1]
    step[..., 1, :2] = -step[..., 0, :2]
    moment = lever[0] * step[..., 0, 1] - lever[1] * step[..., 0, 0]
    step[..., 1, 2] = -step[..., 0, 2] - moment
    reach = np.full(step.shape[:-2], np.inf)
    for part in (_force, _torque, lambda h: _induced(h, grips)):
        square = (part(step) ** 2).sum(axis=-1)
        inner = (part(step) * part(applied)).sum(axis=-1)
        limit = np.where(square > 0, np.maximum(inner, 0.0) / np.where(square > 0, square, 1), 1e9)
        reach = np.minimum(reach, limit.min(axis=-1))
    part_way = rng.choice([1.0, 0.999, 0.7, 0.3], size=reach.shape)
    return (reach * part_way)[..., None, None] * step


def _force(wrench: FloatArray) -> FloatArray:
    return wrench[..., :2]


def _torque(wrench: FloatArray) -> FloatArray:
    return wrench[..., 2:]


def _induced(wrench: FloatArray, grips: FloatArray) -> FloatArray:
    return (grips[..., 0] * wrench[..., 1] - grips[..., 1] * wrench[..., 0])[..., None]


components = st.one_of(
    st.floats(-10, 10, allow_nan=False, width=32),
    st.integers(-3, 3).map(float),
    st.sampled_from([0.0, 1e-8, -1e-8, 1.0, -1.0]),
)
pair_wrenches = st.lists(components, min_size=6, max_size=6).map(
    lambda numbers: np.array(numbers).reshape(2, 3)
)
levers = st.one_of(st.sampled_from(LEVERS), st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
angles = st.floats(-np.pi, np.pi)
torque_weights = st.sampled_from([0.05, 0.3, 0.5, 0.8, 0.99])
