"""Decomposition of agents and surroundings: one effector more where something is touched."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.answer import Answer
from coopenv.wrench.decomposition import Decomposer, Decomposition, Surrounded
from coopenv.wrench.settings import Settings


def with_surroundings(
    agents: Decomposer,
    settings: Settings,
    applied: FloatArray,
    given: FloatArray,
    place: FloatArray,
) -> Decomposition:
    """Decompose what agents apply and surroundings give together.

    Where the surroundings give nothing the answer is that of the agents alone, to the bit, with a
    row of zeros.

    Parameters
    ----------
    agents
        Of the agents' grips, under the same settings without surroundings.
    settings
        With surroundings.
    applied
        ``(world, n, 3)`` [N, N·m], object frame, as all here.
    given, place
        What the surroundings give ``(world, 3)``, and where it acts ``(world, 2)`` [m].

    Returns
    -------
    A decomposition of ``(world, n + 1, 3)``, the surroundings last. Its solver is that of the
    worlds where something is touched, if there are any.
    """
    together = np.concatenate([applied, given[:, None]], axis=1)
    batch = (len(applied), *agents.grips.shape[-2:])
    grips = np.concatenate([np.broadcast_to(agents.grips, batch), place[:, None]], axis=1)
    touched = np.asarray(given.any(axis=-1))
    if not touched.any():
        alone, solver = agents.answer(applied), agents.solver
        manipulation = np.zeros(together.shape)
        manipulation[:, :-1] = alone.manipulation
        answer = alone._replace(manipulation=manipulation)
    else:
        answer, solver = _parted(agents, touched, applied, together, grips)
    return Decomposition(
        together, answer, Surrounded(grips, settings, solver, agents.level_parameters)
    )


def _parted(
    agents: Decomposer,
    touched: BoolArray,
    applied: FloatArray,
    together: FloatArray,
    grips: FloatArray,
) -> tuple[Answer, str]:
    """Answer of agents and surroundings where something is touched, of agents alone elsewhere."""
    beside = Decomposer(grips[touched], agents.settings)
    parts = [(touched, beside.answer(together[touched]), together.shape[1])]
    if not touched.all():
        alone = agents.of_worlds(~touched)
        parts.append((~touched, alone.answer(applied[~touched]), applied.shape[1]))
    gap, fell_back = np.zeros(len(applied)), np.zeros(len(applied), dtype=np.bool_)
    manipulation = np.zeros(together.shape)
    for worlds, part, num_effectors in parts:
        manipulation[worlds, :num_effectors] = part.manipulation
        if part.gap is not None:
            gap[worlds] = part.gap
        if part.fell_back is not None:
            fell_back[worlds] = part.fell_back
    return Answer(manipulation, gap, fell_back), beside.solver
