"""Any number of effectors, in the plane or in space: the cone program through Clarabel.

Slow (about 1 ms a sample) but general, and the oracle for the special solvers. Every vector is
measured in its own length, directions that are fixed anyway are taken out of the program, and where
all forces agree the answer is written down without iterating: there the feasible set is a point,
and an interior-point method loses half its digits.

Accuracy: a ball relaxed by ε lets the cost fall by √ε where the feasible set is thin. Against the
exact answer for 60,000 pairs the cost errs by 2e-12 of J(h) in the median and at most 2e-7, always
downwards; by up to 1e-3 where the effectors' forces differ by factors of 10⁴ and more.

Source: Donner, Endo & Buss 2018, eqs. 17-21.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import SolverError
from coopenv.wrench.cone_program import Affine, ConeProgram
from coopenv.wrench.grasp import grasp_matrix, moment

if TYPE_CHECKING:
    from coopenv.wrench.methods import Solve
    from coopenv.wrench.settings import Settings

PARALLEL = 1e-12  # sine of the angle below which two vectors count as parallel
NEGLIGIBLE = 1e-12  # part of the largest force or torque below which a vector is left as applied
TOLERANCE = 1e-10  # asked of Clarabel: feasibility, and gap relative to the applied cost
ACCEPTED = 1e-5  # gap and residuals up to which an early stop still counts as an answer


def prepare(grips: FloatArray, settings: "Settings") -> "Solve":
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., n, 2)`` or ``(..., n, 3)`` [m], of any batch shape.
    settings
        Torque weight and whether induced torque is costed.
    """
    return partial(_solve_batch, grips, settings.torque_weight, settings.include_induced)


def _solve_batch(
    grips: FloatArray, torque_weight: float, include_induced: bool, applied: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Manipulation wrenches and gaps [N]; samples one after the other."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    wrenches = np.broadcast_to(applied, (*batch, *applied.shape[-2:]))
    all_grips = np.broadcast_to(grips, (*batch, *grips.shape[-2:]))
    manipulation = _agreeing(wrenches, grips.shape[-1])
    gap = np.zeros(batch)
    open_samples = np.argwhere(np.isnan(manipulation[..., 0, 0])).tolist()
    for index in map(tuple, open_samples):
        manipulation[index], gap[index] = _solve_sample(
            wrenches[index], all_grips[index], torque_weight, include_induced, index
        )
    return manipulation, gap


def _agreeing(applied: FloatArray, dimension: int) -> FloatArray:
    """Answers where all forces agree, NaN elsewhere.

    Then the forces are all needed and the torques are shared along their sum (eqs. 22-23); where
    they agree too, the answer is the applied wrench itself.
    """
    force, torque = applied[..., :dimension], applied[..., dimension:]
    manipulation = applied.copy()
    resultant = torque.sum(axis=-2, keepdims=True)
    along = np.maximum((torque * resultant).sum(axis=-1, keepdims=True), 0.0)
    total = along.sum(axis=-2, keepdims=True)
    shared = along / np.where(total > 0, total, 1.0) * resultant
    differ = ~_parallel(torque)
    manipulation[differ, :, dimension:] = shared[differ]
    manipulation[~_parallel(force)] = np.nan
    return manipulation


def _parallel(vectors: FloatArray) -> BoolArray:
    """Whether all vectors ``(..., n, d)`` of a sample point in the same direction, or vanish."""
    resultant = vectors.sum(axis=-2, keepdims=True)
    length = np.linalg.norm(resultant, axis=-1, keepdims=True)
    direction = resultant / np.where(length > 0, length, 1.0)
    along = (vectors * direction).sum(axis=-1, keepdims=True)
    across = np.linalg.norm(vectors - along * direction, axis=-1)
    own = np.linalg.norm(vectors, axis=-1)
    return np.asarray(((along[..., 0] >= 0.0) & (across <= PARALLEL * own)).all(axis=-1))


def _solve_sample(
    applied: FloatArray, grips: FloatArray, w: float, include_induced: bool, index: tuple[int, ...]
) -> tuple[FloatArray, float]:
    """One sample; every vector in its own unit, balance in the largest, costs in J(h)."""
    weights = (1.0 - w, include_induced * w, w)
    program, parts = _program(applied, grips, weights)
    solution = _run(program, index)
    x = np.array(solution.x)
    manipulation = np.stack([np.concatenate([f.value(x), t.value(x)]) for f, t in parts])
    gap = max(solution.obj_val - solution.obj_val_dual, 0.0) * program.cost_unit
    return _balanced(manipulation, applied, grips), gap


def _program(
    applied: FloatArray, grips: FloatArray, weights: tuple[float, float, float]
) -> tuple[ConeProgram, list[tuple[Affine, Affine]]]:
    """State eqs. 17-21 for one sample; also return force and torque of each effector in it."""
    dimension = grips.shape[-1]
    forces, torques = applied[:, :dimension], applied[:, dimension:]
    longest = np.linalg.norm(grips, axis=-1).max()  # [m]
    largest_force = np.linalg.norm(forces, axis=-1).max()  # [N]
    largest_torque = max(np.linalg.norm(torques, axis=-1).max(), longest * largest_force)  # [N·m]
    program = ConeProgram(cost_unit=_cost(applied, grips, weights))
    matrix = grasp_matrix(grips)
    blocks = np.split(matrix, len(grips), axis=1)
    parts = []
    for force, torque, grip, block in zip(forces, torques, grips, blocks, strict=True):
        cross = block[dimension:, :dimension]  # S(r_i)
        lever, induced = np.linalg.norm(grip), cross @ force
        has_lever = bool(lever > NEGLIGIBLE * longest)
        radial = bool(np.linalg.norm(induced) <= PARALLEL * np.linalg.norm(force) * lever)
        force_part = _vector(program, force, weights[0], largest_force, has_lever and radial)
        torque_part = _vector(program, torque, weights[2], largest_torque, len(torque) == 1)
        parts.append((force_part, torque_part))
        if has_lever and not radial and force_part.columns:
            _limit_induced(program, force_part.mapped(cross), induced, weights[1])
    unit = np.full(applied.shape[-1], largest_force)
    unit[dimension:] = largest_torque or 1.0
    balance = [
        _stacked(*part).mapped(block / unit[:, None])
        for part, block in zip(parts, blocks, strict=True)
    ]
    supplied = matrix @ applied.ravel() / unit
    program.zero(*balance, Affine([], np.zeros((len(unit), 0)), -supplied))
    return program, parts


def _vector(
    program: ConeProgram, vector: FloatArray, cost: float, largest: float, on_ray: bool
) -> Affine:
    """Add a force or torque: kept as applied if negligible, on its own ray, or free in its ball."""
    size = float(np.linalg.norm(vector))
    dimension = len(vector)
    if size <= NEGLIGIBLE * largest:
        return Affine([], np.zeros((dimension, 0)), vector)
    if on_ray:
        column = program.variables(1, cost * size)
        program.between(Affine(column, np.ones((1, 1)), np.zeros(1)), 1.0)
        return Affine(column, vector[:, None], np.zeros(dimension))
    unit = Affine(program.variables(dimension), np.eye(dimension), np.zeros(dimension))
    program.ball(unit, 0.5 * vector / size, 0.5)
    program.norm(unit, cost * size)
    return unit.mapped(size * np.eye(dimension))


def _limit_induced(program: ConeProgram, part: Affine, moment: FloatArray, cost: float) -> None:
    """Constrain an induced torque to its ball (20), and count it if it has a cost."""
    size = float(np.linalg.norm(moment))
    unit = part.mapped(np.eye(len(moment)) / size)
    if len(moment) == 1:
        program.between(unit, moment[0] / size)
        program.absolute(unit, moment[0] / size, cost * size)
        return
    program.ball(unit, 0.5 * moment / size, 0.5)
    if cost > 0.0:
        program.norm(unit, cost * size)


def _stacked(force: Affine, torque: Affine) -> Affine:
    """The effector's wrench as one vector."""
    rows = len(force.offset)
    block = np.zeros((rows + len(torque.offset), len(force.columns) + len(torque.columns)))
    block[:rows, : len(force.columns)] = force.block
    block[rows:, len(force.columns) :] = torque.block
    offset = np.concatenate([force.offset, torque.offset])
    return Affine([*force.columns, *torque.columns], block, offset)


def _cost(wrench: FloatArray, grips: FloatArray, weights: tuple[float, float, float]) -> float:
    """The objective (17)."""
    dimension = grips.shape[-1]
    parts = (wrench[:, :dimension], moment(grips, wrench), wrench[:, dimension:])
    lengths = [np.linalg.norm(part, axis=-1).sum() for part in parts]
    return float(np.dot(weights, lengths))


def _balanced(manipulation: FloatArray, applied: FloatArray, grips: FloatArray) -> FloatArray:
    """Remove what the solver left of G (h − h_M), from the parts in proportion to their size."""
    matrix = grasp_matrix(grips)
    dimension = grips.shape[-1]
    weight = np.empty_like(applied)
    weight[:, :dimension] = np.linalg.norm(applied[:, :dimension], axis=-1, keepdims=True)
    weight[:, dimension:] = np.linalg.norm(applied[:, dimension:], axis=-1, keepdims=True)
    weight = weight.ravel()
    missing = matrix @ (applied - manipulation).ravel()
    step = weight * np.linalg.lstsq(matrix * weight, missing)[0]
    return manipulation + step.reshape(manipulation.shape)


def _run(program: ConeProgram, index: tuple[int, ...]) -> Any:
    for equilibrate in (False, True):  # our units are better nearly always
        solution = program.solve(TOLERANCE, equilibrate)
        gap = abs(solution.obj_val - solution.obj_val_dual)
        errors = np.array([gap, solution.r_prim, solution.r_dual])
        if (errors <= ACCEPTED).all():
            return solution
    raise SolverError(
        f"Clarabel stopped with status {solution.status} at sample {index}, gap and residuals "
        f"{errors}; please report this wrench and these grips"
    )
