"""Measures of a step's wrenches in one pass: costs and internal levels, and load shares."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import compiled
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.wrench import Decomposition
from coopenv.wrench.measures import NUM_LEVELS, write_levels
from coopenv.wrench.shares import write_share_or_even

SHARES = NUM_LEVELS  # where they begin in a row: those of force, then those of torque


def measured(
    decomposition: Decomposition, grips: FloatArray, num_agents: int
) -> tuple[FloatArray, BoolArray]:
    """Levels of all effectors, and the shares of the agents among them, which are the first.

    Parameters
    ----------
    decomposition
        Of ``(world, effector, 3)``.
    grips
        Of its effectors in every world, ``(world, effector, 2)`` [m].
    num_agents
        Effectors that are agents.

    Returns
    -------
    ``(world, 6 + 2 agents)``: the columns of `coopenv.wrench.measures`, from `SHARES` on shares of
    force and of torque, 1/n where undefined; and ``(world, 2)``: whether these are defined.
    """
    num_worlds = len(grips)
    rows = np.empty((num_worlds, SHARES + 2 * num_agents))
    defined = np.empty((num_worlds, 2), dtype=np.bool_)
    manipulation = np.ascontiguousarray(decomposition.manipulation)
    parameters = decomposition.level_parameters
    _write(
        *sharing_rows(num_worlds), decomposition.applied, manipulation, grips, num_agents,
        parameters, rows, defined,
    )  # fmt: skip
    return rows, defined


@compiled
def _write_part(start, stop, applied, manipulation, grips, num_agents, parameters, rows, defined):
    for k in range(start, stop):
        row = rows[k]
        write_levels(applied[k], manipulation[k], grips[k], parameters, row[:SHARES])
        force, torque = row[SHARES : SHARES + num_agents], row[SHARES + num_agents :]
        defined[k, 0], defined[k, 1] = write_share_or_even(
            applied[k, :num_agents], grips[k, :num_agents], force, torque
        )


@compiled
def _write(board, parts, applied, manipulation, grips, num_agents, parameters, rows, defined):
    """Write what `measured` returns."""
    arguments = (applied, manipulation, grips, num_agents, parameters, rows, defined)
    spread(board, parts, len(applied), _write_part, arguments)
