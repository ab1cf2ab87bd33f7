"""Sensors that are tilted, or corrected as all six axes are, in recordings in the plane."""

import re
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.errors import InvalidInput
from coopenv.logs import check_file
from tests.logs import cases, motions
from tests.logs.calibration.lab import declared, seen_in

TILTED = {"euler": [25.0, -40.0, 110.0], "order": "ZYX"}
OFFSET = [0.05, 0.02, -0.03]  # [m], the sensor's axes
TARE = [3.0, -2.0, 1.0, 0.3, -0.2, 0.1]
CROSS_TALK = np.eye(6) + 0.05 * np.random.default_rng(5).normal(size=(6, 6))
BEYOND = 4.0  # [N] and [N m] out of the plane
GRAVITY = -9.81
HANDLE, HUNG = 0.4, np.array([0.02, 0.01, 0.06])  # [kg], [m] from the sensor, its axes
BODY = {"mass": motions.MASS, "inertia": motions.INERTIA, "drag": (2.0, 0.3)}


def six_axis(columns: dict[str, Any], turn: Rotation, *habits: str) -> dict[str, Any]:
    """The columns, where the first wrench is read by a sensor of six axes, turned and beside."""
    rows = len(columns["time"])
    beyond = BEYOND * np.sin(np.arange(rows)[:, None] + np.arange(3))
    force = np.stack([columns["f1x"], columns["f1y"], beyond[:, 0]], axis=-1)
    torque = np.stack([beyond[:, 1], beyond[:, 2], columns["t1z"]], axis=-1)
    torque = torque + np.cross(turn.apply(OFFSET), force)
    if "world" in habits:
        about_z = Rotation.from_euler("z", columns["theta"][:, None])
        force, torque = about_z.apply(force), about_z.apply(torque)
    read = np.hstack([turn.inv().apply(force), turn.inv().apply(torque)])
    if "load" in habits:
        down = Rotation.from_euler("z", -columns["theta"][:, None]).apply([0.0, GRAVITY, 0.0])
        weight = HANDLE * turn.inv().apply(down)
        read += np.hstack([weight, np.cross(HUNG, weight)])
    if "cross-talk" in habits:
        read = read @ np.linalg.inv(CROSS_TALK).T
    read = -read if "sign" in habits else read
    read = read + TARE if "tare" in habits else read
    names: list[str] = ["f1x", "f1y", "f1z", "t1x", "t1y", "t1z"]
    return columns | dict(zip(names, read.T, strict=True))


def read_in_the_plane(columns: dict, folder, sensor: dict, **said: Any) -> Any:
    columns = columns | {"theta": np.degrees(columns["theta"])}
    columns = {name: each for name, each in columns.items() if name[0] not in "vo"}
    said = {"grips": cases.BEAM, "space": "plane", "angle": "deg"} | said
    return seen_in(cases.save(columns, folder / "a.npz"), **said, sensors={"1": sensor})


def turned(rotation: dict) -> Rotation:
    return Rotation.from_euler(rotation["order"], rotation["euler"], degrees=True)


@pytest.mark.parametrize("habits", [(), ("tare",), ("sign", "tare"), ("load", "tare")])
def test_a_tilted_sensor_is_turned_in_full_and_its_planar_wrench_taken(habits, tmp_path):
    columns = cases.planar(30)
    sensor: dict[str, Any] = {"rotation": TILTED, "offset": OFFSET}
    sensor |= {"tare": TARE} if "tare" in habits else {}
    sensor |= {"sign": -1} if "sign" in habits else {}
    sensor |= {"load": {"mass": HANDLE, "center": HUNG.tolist()}} if "load" in habits else {}
    seen = read_in_the_plane(
        six_axis(columns, turned(TILTED), *habits), tmp_path, sensor, body={"gravity": [0, GRAVITY]}
    )
    np.testing.assert_allclose(seen.applied, cases.wrench(columns), atol=1e-12)
    assert seen.out_of_plane is None  # of what was corrected


def test_the_inertial_force_of_what_a_tilted_sensor_carries_is_taken_off(tmp_path):
    columns = {name: each[:300] for name, each in motions.planar(1, noise=0.0).items()}
    plain = {"load": {"mass": HANDLE, "center": [0.02, 0.01], "window": 0.1}}
    wanted = read_in_the_plane(columns, tmp_path, plain)
    axes = Rotation.from_euler("x", 90, degrees=True)
    read = six_axis(columns, axes)  # read about the grip, whatever the offset is
    center = axes.inv().apply([0.02, 0.01, 0.0]) + np.array(OFFSET)
    load = plain["load"] | {"center": center.tolist()}
    sensor = {"rotation": axes.as_matrix().tolist(), "offset": OFFSET, "load": load}
    seen = read_in_the_plane(read, tmp_path, sensor)
    assert np.abs(wanted.applied[:, 0] - cases.wrench(columns)[:, 0]).max() > 0.1
    np.testing.assert_allclose(seen.applied, wanted.applied, atol=1e-9)


def test_in_the_world_frame_all_six_axes_are_turned_with_the_object(tmp_path):
    columns = cases.planar(30)
    turn = turned(TILTED)
    made = six_axis(columns, turn)
    about_z = Rotation.from_euler("z", columns["theta"][:, None])
    for kinds in (("f1x", "f1y", "f1z"), ("t1x", "t1y", "t1z")):
        vectors = about_z.apply(np.stack([made[name] for name in kinds], axis=-1))
        made |= dict(zip(kinds, vectors.T, strict=True))
    second = about_z.apply(np.stack([made["f2x"], made["f2y"], 0 * made["f2x"]], axis=-1))
    made |= {"f2x": second[:, 0], "f2y": second[:, 1]}
    sensor = {"rotation": TILTED, "offset": OFFSET}
    seen = read_in_the_plane(made, tmp_path, sensor, frame="world")
    np.testing.assert_allclose(seen.applied, cases.wrench(columns), atol=1e-12)


def test_with_y_down_it_is_the_same_sensor_turned_about_x(tmp_path):
    columns = cases.planar(30)
    read = six_axis(columns, turned(TILTED), "tare")
    wanted = read_in_the_plane(read, tmp_path, {"rotation": TILTED, "offset": OFFSET, "tare": TARE})
    over = Rotation.from_euler("x", 180, degrees=True)
    down = dict(read)
    for name in ("f1y", "f1z", "t1y", "t1z", "f2y", "t2z", "y", "theta"):
        down[name] = -down[name]  # the same vectors in axes that are turned over
    matrix = (over * turned(TILTED) * over).as_matrix()
    flips = np.array([1, -1, -1, 1, -1, -1])
    sensor = {
        "rotation": matrix.tolist(),
        "offset": (flips[:3] * OFFSET).tolist(),
        "tare": (flips * TARE).tolist(),
    }
    seen = read_in_the_plane(down, tmp_path, sensor, y="down")
    np.testing.assert_allclose(seen.applied, wanted.applied, atol=1e-12)


def test_cross_talk_and_tare_of_six_axes_go_for_a_sensor_that_is_not_tilted(tmp_path):
    columns = cases.planar(30)
    read = six_axis(columns, Rotation.from_euler("z", 0), "cross-talk", "tare")
    sensor = {"cross_talk": CROSS_TALK.tolist(), "tare": TARE, "offset": OFFSET[:2]}
    seen = read_in_the_plane(read, tmp_path, sensor | {"rotation": 0.0})
    along = seen.applied[:, 0] - cases.wrench(columns)[:, 0]
    np.testing.assert_allclose(along, 0.0, atol=1e-12)  # an offset along z turns nothing about z
    planar = {"cross_talk": np.array(CROSS_TALK)[:3, :3].tolist(), "tare": TARE}
    with pytest.raises(InvalidInput, match=r"sensors.1.cross_talk must be of 6 .* six axes are"):
        read_in_the_plane(read, tmp_path, planar)


def test_what_is_left_out_is_told_in_numbers(tmp_path):
    columns = cases.planar(30)
    seen = read_in_the_plane(
        six_axis(columns, turned(TILTED)), tmp_path, {"rotation": TILTED, "offset": OFFSET}
    )
    told = seen.done[-1]
    found = re.fullmatch(
        r"sensor 1: ([\d.]+) N and ([\d.]+) N·m out of the plane left out, beside ([\d.]+) N and "
        r"([\d.]+) N·m in it \(root mean squares\)", told
    )  # fmt: skip
    assert found is not None, told
    beyond = BEYOND * np.sin(np.arange(30)[:, None] + np.arange(3))
    planar = cases.wrench(columns)[:, 0]
    wanted = [beyond[:, :1], beyond[:, 1:], planar[:, :2], planar[:, 2:]]
    sizes = [float(np.sqrt((each**2).sum(axis=-1).mean())) for each in wanted]
    np.testing.assert_allclose([float(each) for each in found.groups()], sizes, rtol=0.005)


def test_a_tilted_sensor_without_its_other_axes_is_refused_by_their_names(tmp_path):
    columns = six_axis(cases.planar(30), turned(TILTED))
    del columns["t1x"]
    says = r"a.npz: column t1x must be there.*sensors.1.rotation is of all six axes"
    with pytest.raises(InvalidInput, match=says):
        read_in_the_plane(columns, tmp_path, {"rotation": TILTED})
    columns = six_axis(cases.planar(30), turned(TILTED))
    with pytest.raises(InvalidInput, match=r"sensors.1.offset must be 3 numbers here, got 2"):
        read_in_the_plane(columns, tmp_path, {"rotation": TILTED, "offset": [0.1, 0.0]})


@pytest.mark.parametrize("by", [0.0, 30.0])
def test_the_check_finds_how_much_more_a_tilted_sensor_is_turned(by, tmp_path):
    columns = motions.planar(0)
    columns = {name: each for name, each in columns.items() if name[0] not in "vo"}
    right = turned(TILTED)
    read = six_axis(columns, Rotation.from_euler("z", by, degrees=True) * right)
    layout = declared(
        grips=motions.BEAM,
        space="plane",
        body=BODY,
        angle="rad",
        sensors={"1": {"rotation": {"quaternion": right.as_quat().tolist(), "order": "xyzw"},
                       "offset": OFFSET}},
    )  # fmt: skip
    said = check_file(cases.save(read, tmp_path / "a.npz"), layout=layout).consistency
    if not by:
        assert not said.warnings
        return
    quaternion = (Rotation.from_euler("z", by, degrees=True) * right).as_quat()[[3, 0, 1, 2]]
    found = re.search(r"rotation = \{ quaternion = \[(.*?)\]", said.warnings[0])
    assert found is not None, said.warnings
    numbers = np.array([float(each) for each in found[1].split(",")])
    assert abs(numbers @ quaternion) > 0.999
