"""The paper's program (eqs. 17-21) for one sample, stated for Clarabel."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.cone_program import Affine, ConeProgram
from coopenv.wrench.conic_bound import Duals
from coopenv.wrench.conic_parts import NEGLIGIBLE, PARALLEL, Parts
from coopenv.wrench.grasp import grasp_matrix


def wrench_program(
    applied: FloatArray, grips: FloatArray, weights: Parts, cost_unit: float, duals: Duals
) -> tuple[ConeProgram, list[tuple[Affine, Affine]]]:
    """State eqs. 17-21 for one sample; also return force and torque of each effector in it.

    Every vector is in its own unit, balance in the largest, costs in ``cost_unit`` [N]. The
    program's multipliers will be written to this sample's ``duals``.
    """
    dimension = grips.shape[-1]
    forces, torques = applied[:, :dimension], applied[:, dimension:]
    longest = np.linalg.norm(grips, axis=-1).max()  # [m]
    largest_force = np.linalg.norm(forces, axis=-1).max()  # [N]
    largest_torque = max(np.linalg.norm(torques, axis=-1).max(), longest * largest_force)  # [N·m]
    program = ConeProgram(cost_unit)
    matrix = grasp_matrix(grips)
    blocks = np.split(matrix, len(grips), axis=1)
    parts = []
    for i, (force, torque, grip, block) in enumerate(
        zip(forces, torques, grips, blocks, strict=True)
    ):
        cross = block[dimension:, :dimension]  # S(r_i)
        lever, induced = np.linalg.norm(grip), cross @ force
        has_lever = bool(lever > NEGLIGIBLE * longest)
        radial = bool(np.linalg.norm(induced) <= PARALLEL * np.linalg.norm(force) * lever)
        on_ray = has_lever and radial
        force_part = _vector(program, force, weights.force, largest_force, on_ray, duals.force[i])
        on_ray = len(torque) == 1
        torque_part = _vector(
            program, torque, weights.torque, largest_torque, on_ray, duals.torque[i]
        )
        parts.append((force_part, torque_part))
        if has_lever and not radial and force_part.columns:
            about = force_part.mapped(cross)
            _limit_induced(
                program, about, induced, weights.induced, duals.disc[i], duals.induced[i]
            )
    unit = np.full(applied.shape[-1], largest_force)
    unit[dimension:] = largest_torque or 1.0
    balance = [
        _stacked(*part).mapped(block / unit[:, None])
        for part, block in zip(parts, blocks, strict=True)
    ]
    supplied = matrix @ applied.ravel() / unit
    rows = program.zero(*balance, Affine([], np.zeros((len(unit), 0)), -supplied))
    program.keep(duals.balance, rows, 1.0 / unit)
    return program, parts


def _vector(
    program: ConeProgram,
    vector: FloatArray,
    cost: float,
    largest: float,
    on_ray: bool,
    zeta: FloatArray,
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
    program.keep(zeta, program.norm(unit, cost * size), 1.0 / size)
    return unit.mapped(size * np.eye(dimension))


def _limit_induced(
    program: ConeProgram,
    part: Affine,
    moment: FloatArray,
    cost: float,
    of_ball: FloatArray,
    of_cost: FloatArray,
) -> None:
    """Constrain an induced torque to its ball (20), and count it if it has a cost."""
    size = float(np.linalg.norm(moment))
    unit = part.mapped(np.eye(len(moment)) / size)
    if len(moment) == 1:
        sign = moment[0] / size
        rows = program.between(unit, sign)
        program.keep(of_ball, rows, np.array([[sign, -sign]]) / size)
        of_cost[:] = -cost * sign
        program.absolute(unit, sign, cost * size)
        return
    program.keep(of_ball, program.ball(unit, 0.5 * moment / size, 0.5), 1.0 / size)
    if cost > 0.0:
        program.keep(of_cost, program.norm(unit, cost * size), 1.0 / size)


def _stacked(force: Affine, torque: Affine) -> Affine:
    """The effector's wrench as one vector."""
    rows = len(force.offset)
    block = np.zeros((rows + len(torque.offset), len(force.columns) + len(torque.columns)))
    block[:rows, : len(force.columns)] = force.block
    block[rows:, len(force.columns) :] = torque.block
    offset = np.concatenate([force.offset, torque.offset])
    return Affine([*force.columns, *torque.columns], block, offset)
