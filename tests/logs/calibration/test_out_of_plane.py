"""Rotations in space of recordings in the plane: of sensors that are not tilted, and of cameras."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.errors import InvalidInput
from tests.logs import cases
from tests.logs.calibration.lab import seen_in

UPSIDE_DOWN = {"euler": [180.0, 0.0, 0.0], "order": "xyz"}
ABOUT_Z = {"euler": [30.0, 0.0, 0.0], "order": "ZYX"}


def six_axis(turn: Rotation, offset: tuple[float, ...] = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    """A trial in the plane whose first wrench a sensor of six axes reads, turned and beside."""
    columns = cases.planar(30)
    force = np.stack([columns["f1x"], columns["f1y"], np.zeros(30)], axis=-1)
    torque = np.stack([np.zeros(30), np.zeros(30), columns["t1z"]], axis=-1)
    force, torque = turn.inv().apply(force), turn.inv().apply(torque)
    torque = torque + np.cross(offset, force)
    columns |= {f"f1{a}": each for a, each in zip("xyz", force.T, strict=True)}
    columns |= {f"t1{a}": each for a, each in zip("xyz", torque.T, strict=True)}
    return columns


def read_in_the_plane(columns, folder, **sensor: Any) -> Any:
    said = {"grips": cases.BEAM, "space": "plane", "angle": "deg", "sensors": {"1": sensor}}
    columns = columns | {"theta": np.degrees(columns["theta"])}
    columns = {name: each for name, each in columns.items() if name[0] not in "vo"}
    return seen_in(cases.save(columns, folder / "a.npz"), **said)


@pytest.mark.parametrize("rotation", [UPSIDE_DOWN, ABOUT_Z])
def test_a_rotation_in_space_that_leaves_the_plane_in_place_is_read(rotation, tmp_path):
    turn = Rotation.from_euler(rotation["order"], rotation["euler"], degrees=True)
    columns = six_axis(turn, (0.05, 0.02, 0.0))
    seen = read_in_the_plane(columns, tmp_path, rotation=rotation, offset=[0.05, 0.02])
    np.testing.assert_allclose(seen.applied, cases.wrench(cases.planar(30)), atol=1e-12)
    matrix = read_in_the_plane(
        columns, tmp_path, rotation=turn.as_matrix().tolist(), offset=[0.05, 0.02]
    )
    np.testing.assert_allclose(matrix.applied, seen.applied, atol=1e-12)


@pytest.mark.parametrize("apart", [False, True])
def test_a_camera_whose_y_axis_is_up_is_refused_until_its_axes_are_exchanged(apart, tmp_path):
    columns = cases.planar(30)
    angle = columns["theta"]
    camera = {"time": columns["time"]}
    turned = np.stack([0 * angle, np.sin(angle / 2), 0 * angle, np.cos(angle / 2)])  # about y
    camera |= dict(zip(("qx", "qy", "qz", "qw"), turned, strict=True))
    rest = {name: columns[name] for name in columns if name[0] in "ft" and name != "theta"}
    cases.save(camera, tmp_path / "camera.npz")
    path = cases.save(rest if apart else rest | camera, tmp_path / "a.npz")
    said: dict[str, Any] = {"files": {"camera": {"path": "camera.npz"}}} if apart else {}
    said |= {"grips": cases.BEAM}
    where = "camera.npz" if apart else "a.npz"
    says = rf"{where}, row \d+, columns qx, qy, qz, qw, which make 'theta', must be a turn about z"
    with pytest.raises(InvalidInput, match=says):
        seen_in(path, **said, pose={"columns": ["qx", "qy", "qz", "qw"], "order": "xyzw"})
    exchanged = {"columns": ["qx", "-qz", "qy", "qw"], "order": "xyzw"}
    seen = seen_in(path, **said, pose=exchanged)
    np.testing.assert_allclose(np.cos(seen.orientation - angle), 1.0, atol=1e-12)
