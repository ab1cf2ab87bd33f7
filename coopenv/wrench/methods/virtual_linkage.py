"""Virtual linkage: internal is what the lines between the effectors could carry."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.settings import Settings


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Project forces on the lines between effectors; every pure torque counts as internal.

    f_I = E E⁺ f, with one column of E per pair of effectors: the unit vector between them on one,
    its opposite on the other; t_I,i = t_i. The internal wrench need not balance.

    Source: Williams & Khatib 1993, as compared in Donner, Endo & Buss 2018. Deviation: effectors
    at the same place have no line between them.
    """
    projection = _projection(grips)
    num_effectors, dimension = grips.shape[-2:]

    def solve(applied: FloatArray) -> Answer:
        force = applied[..., :dimension]
        flat = force.reshape(*force.shape[:-2], num_effectors * dimension)
        internal = (projection @ flat[..., None])[..., 0]
        shape = (*internal.shape[:-1], num_effectors, dimension)
        manipulation = np.zeros((*shape[:-1], applied.shape[-1]))
        manipulation[..., :dimension] = force - internal.reshape(shape)
        return Answer(manipulation)

    return Prepared("closed_form", solve)


def _projection(grips: FloatArray) -> FloatArray:
    """E E⁺, ``(..., n·d, n·d)``."""
    num_effectors, dimension = grips.shape[-2:]
    first, second = np.triu_indices(num_effectors, k=1)
    line = grips[..., second, :] - grips[..., first, :]
    length = np.linalg.norm(line, axis=-1, keepdims=True)
    line = line / np.where(length > 0, length, 1.0)
    columns = np.zeros((*grips.shape[:-2], len(first), num_effectors, dimension))
    index = np.arange(len(first))
    columns[..., index, first, :] = line
    columns[..., index, second, :] = -line
    shape = (*grips.shape[:-2], len(first), num_effectors * dimension)
    matrix = np.swapaxes(columns.reshape(shape), -1, -2)
    return matrix @ np.linalg.pinv(matrix)
