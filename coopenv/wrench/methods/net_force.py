"""Net force method: whatever points along the resultant force counts as manipulation."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.methods.forces_only import forces_of, without_torque
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import UNDEFINED


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Split every force along and across the resultant.

    f_M,i = (f_i · f_o/‖f_o‖) f_o/‖f_o‖,  f_I,i = f_i − f_M,i

    An effector that pulls against the resultant does so as "manipulation"; and the parts across
    add up to no force, yet in general to a torque: like the virtual linkage, the method need not
    balance. Where the resultant vanishes (1e-9 of its parts) all force is internal. Raises
    `InvalidInput` where a torque is applied.

    Source: Shaw et al. 2024 (arXiv 2408.01543). Deviation: the resultant that vanishes.
    """

    def solve(applied: FloatArray) -> Answer:
        force = forces_of(applied, grips, "net_force")
        resultant = force.sum(axis=-2, keepdims=True)
        length = np.linalg.norm(resultant, axis=-1, keepdims=True)
        magnitude = np.linalg.norm(force, axis=-1, keepdims=True).sum(axis=-2, keepdims=True)
        defined = length > UNDEFINED * magnitude
        direction = np.where(defined, resultant, 0.0) / np.where(defined, length, 1.0)
        along = (force * direction).sum(axis=-1, keepdims=True) * direction
        return Answer(without_torque(along, applied))

    return Prepared("closed_form", solve)
