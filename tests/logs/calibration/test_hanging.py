"""What hangs at a sensor, as it is declared: its inertia turns with the sensor."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.logs import Layout
from coopenv.logs.corrections.mounted import Mounted

INERTIA = [0.001, 0.002, 0.003]
LOAD = {"mass": 0.3, "center": [0.0, 0.05, 0.01], "inertia": INERTIA, "window": 0.06}


def mounted(dimension: int, **said: Any) -> Any:
    layout = Layout.load(sensors={"1": said})
    (sensor,) = layout.sensors.values()
    return Mounted.of(1, sensor, layout, dimension)


def test_a_sensor_along_the_objects_axes_leaves_inertia_and_centre_as_they_are():
    hanging = mounted(3, load=LOAD).load
    np.testing.assert_array_equal(hanging.inertia, np.diag(INERTIA))
    np.testing.assert_array_equal(hanging.center, LOAD["center"])


def test_a_sensor_that_is_turned_turns_inertia_and_centre():
    turn = Rotation.from_euler("ZYX", [30, 20, -40], degrees=True).as_matrix()
    hanging = mounted(3, load=LOAD, rotation=turn.tolist()).load
    np.testing.assert_allclose(hanging.inertia, turn @ np.diag(INERTIA) @ turn.T, atol=1e-18)
    np.testing.assert_allclose(hanging.center, turn @ LOAD["center"], atol=1e-16)


def test_in_the_plane_a_turn_changes_no_inertia():
    load = {"mass": 0.3, "center": [0.0, 0.05], "inertia": 0.001, "window": 0.06}
    hanging = mounted(2, load=load, rotation=np.pi / 6).load
    assert hanging.inertia[2, 2] == pytest.approx(0.001)
    np.testing.assert_allclose(hanging.center, [-0.025, 0.05 * np.cos(np.pi / 6)], atol=1e-15)
