"""Any number of effectors, in the plane or in space: the cone program through Clarabel.

Slow (about 0.5 ms a sample) but general, and the oracle for the special solvers. Each sample is
brought to unit scale, directions that are fixed anyway are taken out of the program, and where all
forces agree the answer is written down without iterating: there the feasible set has no interior,
and an interior-point method would lose half its digits.

Source: Donner, Endo & Buss 2018, eqs. 17-21.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

import clarabel
import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import SolverError
from coopenv.wrench.cone_program import Affine, ConeProgram
from coopenv.wrench.grasp import grasp_matrix

if TYPE_CHECKING:
    from coopenv.wrench.methods import Solve
    from coopenv.wrench.settings import Settings

PARALLEL = 1e-12  # sine of the angle below which two vectors count as parallel
NEGLIGIBLE = 1e-12  # part of the largest force or torque below which a vector is left as applied
TOLERANCE = 1e-10  # asked of Clarabel: feasibility, and gap relative to the applied cost
ACCEPTED = 1e-6  # gap and infeasibility up to which an early stop still counts as an answer


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
    for index in map(tuple, np.argwhere(np.isnan(manipulation[..., 0, 0]))):
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
    """One sample at unit scale: lengths by the longest lever, wrenches by the largest."""
    dimension = grips.shape[-1]
    length = np.linalg.norm(grips, axis=-1).max() or 1.0  # [m]
    scale = max(  # [N]
        np.linalg.norm(applied[:, :dimension], axis=-1).max(),
        np.linalg.norm(applied[:, dimension:], axis=-1).max() / length,
    )
    units = np.full(applied.shape[-1], scale)
    units[dimension:] *= length
    weights = (1.0 - w, include_induced * w * length, w * length)
    program, parts = _program(applied / units, grips / length, weights)
    solution = _run(program, index)
    x = np.array(solution.x)
    manipulation = np.stack([np.concatenate([f.value(x), t.value(x)]) for f, t in parts])
    manipulation = _balanced(manipulation, applied / units, grips / length)
    gap = max(solution.obj_val - solution.obj_val_dual, 0.0)
    return manipulation * units, gap * scale


def _program(
    applied: FloatArray, grips: FloatArray, weights: tuple[float, float, float]
) -> tuple[ConeProgram, list[tuple[Affine, Affine]]]:
    """State eqs. 17-21 for one sample; also return force and torque of each effector in it."""
    dimension = grips.shape[-1]
    force_cost, induced_cost, torque_cost = weights
    program = ConeProgram()
    parts = []
    for wrench, grip in zip(applied, grips, strict=True):
        cross = grasp_matrix(grip[None])[dimension:, :dimension]  # S(r_i)
        force, torque = wrench[:dimension], wrench[dimension:]
        lever, moment = np.linalg.norm(grip), cross @ force
        radial = np.linalg.norm(moment) <= PARALLEL * np.linalg.norm(force) * lever
        on_lever = bool(lever > NEGLIGIBLE and radial)
        force_part = _add_vector(program, force, force_cost, ray=on_lever)
        parts.append((force_part, _add_vector(program, torque, torque_cost)))
        if lever > NEGLIGIBLE and not radial and force_part.columns:
            _add_induced(program, force_part.mapped(cross), moment, induced_cost)
    matrix = grasp_matrix(grips)
    blocks = np.split(matrix, len(grips), axis=1)
    whole = [_stacked(force, torque) for force, torque in parts]
    balance = [part.mapped(block) for part, block in zip(whole, blocks, strict=True)]
    program.zero(*balance, Affine([], np.zeros((len(matrix), 0)), -matrix @ applied.ravel()))
    return program, parts


def _add_vector(program: ConeProgram, vector: FloatArray, cost: float, ray: bool = False) -> Affine:
    """Add a force or torque: kept as applied if negligible, on its own ray, or free in its ball."""
    size = float(np.linalg.norm(vector))
    dimension = len(vector)
    if size <= NEGLIGIBLE:
        return Affine([], np.zeros((dimension, 0)), vector)
    if ray or dimension == 1:
        column = program.variables(1, cost)
        program.between(Affine(column, np.ones((1, 1)), np.zeros(1)), size)
        return Affine(column, vector[:, None] / size, np.zeros(dimension))
    part = Affine(program.variables(dimension), np.eye(dimension), np.zeros(dimension))
    program.ball(part, 0.5 * vector, 0.5 * size)
    program.norm(part, cost)
    return part


def _add_induced(program: ConeProgram, part: Affine, moment: FloatArray, cost: float) -> None:
    """Constrain an induced torque to its ball (20), and count it if it has a cost."""
    if len(moment) == 1:
        program.between(part, moment[0])
        program.absolute(part, np.sign(moment[0]), cost)
        return
    program.ball(part, 0.5 * moment, 0.5 * float(np.linalg.norm(moment)))
    if cost > 0.0:
        program.norm(part, cost)


def _stacked(force: Affine, torque: Affine) -> Affine:
    """The effector's wrench as one vector."""
    rows = len(force.offset)
    block = np.zeros((rows + len(torque.offset), len(force.columns) + len(torque.columns)))
    block[:rows, : len(force.columns)] = force.block
    block[rows:, len(force.columns) :] = torque.block
    offset = np.concatenate([force.offset, torque.offset])
    return Affine([*force.columns, *torque.columns], block, offset)


def _balanced(manipulation: FloatArray, applied: FloatArray, grips: FloatArray) -> FloatArray:
    """Remove what the solver left of G (h − h_M), from the parts in proportion to their size."""
    matrix = grasp_matrix(grips)
    weight = np.abs(applied).ravel()
    missing = matrix @ (applied - manipulation).ravel()
    step = weight * np.linalg.lstsq(matrix * weight, missing)[0]
    return manipulation + step.reshape(manipulation.shape)


def _run(program: ConeProgram, index: tuple[int, ...]) -> Any:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = ACCEPTED
    settings.reduced_tol_feas = ACCEPTED
    settings.max_threads = 1
    solution = program.solve(settings)
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        raise SolverError(
            f"Clarabel stopped with status {solution.status} at sample {index} after "
            f"{solution.iterations} iterations; please report this wrench and these grips"
        )
    return solution
