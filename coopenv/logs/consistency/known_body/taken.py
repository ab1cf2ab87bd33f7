"""What a layout has taken off readings, as columns that may be fitted anew: tares and loads."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.sensor import Tare
from coopenv.logs.consistency.known_body.corrected import Corrected, Key
from coopenv.logs.layout import Layout


def weights(sums: Corrected) -> list[Key]:
    """Columns of the weight of loads."""
    return [("weight",), *(("weight moment", a) for a in sums.force_axes)]


def constants(sums: Corrected, layout: Layout) -> list[Key]:
    """Columns of what is taken off as the mean of a rest, if the layout says so of a sensor."""
    if not any(isinstance(sensor.tare, Tare) for sensor in layout.sensors.values()):
        return []
    forces = [("bias force", a) for a in sums.force_axes]
    return [*forces, *(("bias torque", a) for a in sums.torque_axes)]


def loads(sums: Corrected, layout: Layout) -> list[Key]:
    """Columns of what is taken off for loads, as the layout declares them."""
    carrying = {number - 1: each.load for number, each in layout.sensors.items()}
    made = []
    for i, load in carrying.items():
        if load is not None and load.window is not None:
            made += [("mass", i), *(("moment", i, a) for a in sums.force_axes)]
    still = any(load is not None and load.window is None for load in carrying.values())
    return made + (weights(sums) if still else [])


def mounting(i: int, layout: Layout) -> FloatArray:
    """The declared axes ``(3, 3)`` of a sensor, seen from the object."""
    sensor = layout.sensors.get(i + 1)
    return np.eye(3) if sensor is None else sensor.axes(layout.factor("angle"))
