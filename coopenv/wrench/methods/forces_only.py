"""Forces of wrenches without torque, for methods that split forces only."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput


def forces_of(applied: FloatArray, grips: FloatArray, method: str) -> FloatArray:
    """Return the forces ``(..., n, 2)`` or ``(..., n, 3)`` [N] of wrenches without torque.

    The batch shapes of wrenches and grips are broadcast together.

    Raises
    ------
    InvalidInput
        If any effector applies a torque.
    """
    dimension = grips.shape[-1]
    torque = applied[..., dimension:]
    if torque.any():
        where = tuple(int(i) for i in np.argwhere(torque)[0])
        raise InvalidInput(
            f"applied must be without torque for method={method!r}, which splits forces only, got "
            f"{torque[where]} N·m at index {where}; take method='optimal', or set the torques to 0 "
            "to see the forces alone"
        )
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    force = applied[..., :dimension]
    return np.broadcast_to(force, (*batch, *force.shape[-2:]))


def without_torque(force: FloatArray, applied: FloatArray) -> FloatArray:
    """Put forces into wrenches whose torques are 0, ``(..., n, 3)`` or ``(..., n, 6)``."""
    wrench = np.zeros((*force.shape[:-1], applied.shape[-1]))
    wrench[..., : force.shape[-1]] = force
    return wrench
