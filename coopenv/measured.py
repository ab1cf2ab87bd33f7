"""Measures of a step's wrenches in one pass: costs and internal levels, and load shares."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import compiled, inlined
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.wrench import Decomposer, Decomposition
from coopenv.wrench.answer import Answer
from coopenv.wrench.measures import NUM_LEVELS, write_levels
from coopenv.wrench.pair.on_axis import OnAxis, split
from coopenv.wrench.shares import write_share_or_even

SHARES = NUM_LEVELS  # where they begin in a row: those of force, then those of torque


def split_and_measured(
    decomposer: Decomposer, applied: FloatArray, grips: FloatArray
) -> tuple[Decomposition, tuple[FloatArray, BoolArray] | None]:
    """The decomposition of agents' wrenches, and what `measured` gives if it comes with that.

    For two agents that hold on a line through the centre of mass each world is split and measured
    at once, to the bits of one after the other.

    Parameters
    ----------
    decomposer
        Of ``applied``, without surroundings.
    applied
        ``(world, agent, 3)`` [N, N·m].
    grips
        ``(world, agent, 2)`` [m].
    """
    solve = decomposer.solve
    if not isinstance(solve, OnAxis):
        return decomposer(applied), None
    manipulation = np.empty(applied.shape)
    rows, defined = _room(applied)
    _split(
        *sharing_rows(len(applied)), applied, solve.axes, solve.weights, grips,
        decomposer.level_parameters, manipulation, rows, defined,
    )  # fmt: skip
    decomposition = Decomposition(applied, Answer(manipulation), decomposer)
    return decomposition, (rows, defined)


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
    applied, manipulation = decomposition.applied, np.ascontiguousarray(decomposition.manipulation)
    rows, defined = _room(applied[:, :num_agents])
    _write(
        *sharing_rows(len(grips)), applied, manipulation, grips, num_agents,
        decomposition.level_parameters, rows, defined,
    )  # fmt: skip
    return rows, defined


def _room(applied: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Memory for what is measured of agents' wrenches."""
    num_worlds, num_agents, _ = applied.shape
    rows = np.empty((num_worlds, SHARES + 2 * num_agents))
    return rows, np.empty((num_worlds, 2), dtype=np.bool_)


@inlined
def _measure(k, applied, manipulation, grips, num_agents, parameters, rows, defined):
    """Write what `measured` returns of world ``k``."""
    row = rows[k]
    write_levels(applied[k], manipulation[k], grips[k], parameters, row[:SHARES], None)
    force, torque = row[SHARES : SHARES + num_agents], row[SHARES + num_agents :]
    defined[k, 0], defined[k, 1] = write_share_or_even(
        applied[k, :num_agents], grips[k, :num_agents], force, torque, None
    )


@compiled
def _write_part(start, stop, applied, manipulation, grips, num_agents, parameters, rows, defined):
    for k in range(start, stop):
        _measure(k, applied, manipulation, grips, num_agents, parameters, rows, defined)


@compiled
def _write(board, parts, applied, manipulation, grips, num_agents, parameters, rows, defined):
    """Write what `measured` returns."""
    arguments = (applied, manipulation, grips, num_agents, parameters, rows, defined)
    spread(board, parts, len(applied), _write_part, arguments)


@compiled
def _split_part(
    start, stop, applied, axes, weights, grips, parameters, manipulation, rows, defined
):
    num_agents = applied.shape[1]
    for k in range(start, stop):
        split(applied, k, axes, weights, manipulation)
        _measure(k, applied, manipulation, grips, num_agents, parameters, rows, defined)


@compiled
def _split(board, parts, applied, axes, weights, grips, parameters, manipulation, rows, defined):
    """Write the manipulation wrenches, and what `measured` returns."""
    arguments = (applied, axes, weights, grips, parameters, manipulation, rows, defined)
    spread(board, parts, len(applied), _split_part, arguments)
