"""The paper's optimisation problem (eqs. 17-21) for one sample, as a cone program."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.conic.bound import Duals
from coopenv.wrench.conic.cone_program import Affine, ConeProgram
from coopenv.wrench.conic.parts import NEGLIGIBLE, PARALLEL, Parts, Prices, norm
from coopenv.wrench.grasp import grasp_matrix, sum_at_centre

TURNED = 0.03  # sine of the angle to its lever up to which a force has axes along and across that


def wrench_program(
    whole: Parts, grips: FloatArray, weights: Prices, cost_unit: float, duals: Duals
) -> tuple[ConeProgram, list[tuple[Affine, Affine]]]:
    """Return the program of one sample, and force and torque of each effector in it.

    Every vector has its own length as unit, balance the largest, costs ``cost_unit`` [N]. The
    program will write its multipliers to ``duals``.

    Parameters
    ----------
    whole, duals
        Of this sample, ``(n, d)`` and ``(k,)``.
    """
    dimension = grips.shape[-1]
    levers, forces, torques, induced = (norm(part).tolist() for part in (grips, *whole))
    longest, largest_force = max(levers), max(forces)  # [m], [N]
    largest_torque = max(*torques, longest * largest_force)  # [N·m]
    program, parts = ConeProgram(cost_unit), []
    size = dimension + whole.torque.shape[-1]
    matrix = grasp_matrix(grips).reshape(size, len(grips), size)
    for i, lever in enumerate(levers):
        has_lever = lever > NEGLIGIBLE * longest
        radial = induced[i] <= PARALLEL * forces[i] * lever
        free = forces[i] > NEGLIGIBLE * largest_force

        # its force and torque
        force, torque, axes = _fixed(whole.force[i]), _fixed(whole.torque[i]), None
        if free:
            cost, zeta, on_ray = weights.force, duals.force[i], radial and has_lever
            if has_lever and not radial and induced[i] <= TURNED * forces[i] * lever:
                axes = _along_and_across(grips[i], induced[i] / (forces[i] * lever))
            force = _vector(program, whole.force[i], forces[i], cost, zeta, on_ray, axes)
        if torques[i] > NEGLIGIBLE * largest_torque:
            cost, zeta, on_ray = weights.torque, duals.torque[i], size == 3
            torque = _vector(program, whole.torque[i], torques[i], cost, zeta, on_ray)
        parts.append((force, torque))

        # the torque that its force induces
        if free and has_lever and not radial:
            unit = force.mapped(matrix[dimension:, i, :dimension] / induced[i])  # S(r_i)
            if axes is not None:
                unit.block[:, 0] = 0.0  # along the lever, but for rounding
            _limit_induced(program, unit, whole.induced[i], induced[i], weights.induced, duals, i)

    # balance
    unit = np.full(size, largest_force)
    unit[dimension:] = largest_torque or 1.0
    matrix /= unit[:, None, None]
    balance = [
        _fixed(-(sum_at_centre(np.concatenate([whole.force, whole.torque], axis=-1), grips) / unit))
    ]
    for i, (force, torque) in enumerate(parts):
        balance += [force.mapped(matrix[:, i, :dimension]), torque.mapped(matrix[:, i, dimension:])]
    program.keep(duals.balance, program.zero(*balance), 1.0 / unit)
    return program, parts


def _fixed(vector: FloatArray) -> Affine:
    """Return a constant."""
    return Affine([], np.zeros((len(vector), 0)), vector)


def _vector(
    program: ConeProgram,
    vector: FloatArray,
    size: float,
    cost: float,
    zeta: FloatArray,
    on_ray: bool,
    axes: FloatArray | None = None,
) -> Affine:
    """Add a force or torque, on its own ray or free in its ball; keep the ζ of its cost.

    The columns of ``axes`` are what units of its variables stand for, in parts of ``size``.
    """
    dimension = len(vector)
    if on_ray:
        column = program.variables(1, cost * size)
        program.between(Affine(column, np.ones((1, 1)), np.zeros(1)), 1.0)
        return Affine(column, vector[:, None], np.zeros(dimension))
    columns, identity, nothing = (
        program.variables(dimension),
        np.eye(dimension),
        np.zeros(dimension),
    )
    unit = Affine(columns, identity if axes is None else axes, nothing)
    program.ball(unit, 0.5 * vector / size, 0.5)
    program.keep(zeta, program.norm(unit, cost * size), 1.0 / size)
    return Affine(columns, size * unit.block, nothing)


def _along_and_across(grip: FloatArray, sine: float) -> FloatArray:
    """Axes of a force along its lever, and across it in units of its ``sine`` to the lever.

    A force nearly along its lever induces a torque that is tiny, and measured in itself: in other
    axes its rows would have entries of 1 / sine, at which Clarabel loses the balls. Other forces
    gain nothing by it.
    """
    along = grip / norm(grip)
    if len(grip) == 2:
        return np.stack([along, sine * np.array([-along[1], along[0]])], axis=-1)
    first = np.zeros(3)
    first[np.argmin(np.abs(along))] = 1.0
    second = np.cross(along, first)
    second /= norm(second)
    return np.stack([along, sine * second, sine * np.cross(along, second)], axis=-1)


def _limit_induced(
    program: ConeProgram,
    unit: Affine,
    moment: FloatArray,
    size: float,
    cost: float,
    duals: Duals,
    effector: int,
) -> None:
    """Constrain an induced torque to its ball (eq. 20), and add its cost if it has one."""
    of_ball, of_cost = duals.disc[effector], duals.induced[effector]
    if len(moment) == 1:
        sign = moment[0] / size
        program.keep(of_ball, program.between(unit, sign), np.array([[sign, -sign]]) / size)
        program.absolute(unit, sign, cost * size)
        of_cost[:] = -cost * sign
        return
    program.keep(of_ball, program.ball(unit, 0.5 * moment / size, 0.5), 1.0 / size)
    if cost > 0.0:
        program.keep(of_cost, program.norm(unit, cost * size), 1.0 / size)
