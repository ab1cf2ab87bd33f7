"""Of devices with files of their own, the check names the one that is wrong, and its delay."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from coopenv.logs import Layout, check_file
from tests.logs import cases, motions
from tests.logs.calibration.lab import declared
from tests.logs.devices import OF_TOPICS, POSE, WRENCH

BODY = {"mass": motions.MASS, "inertia": motions.INERTIA, "drag": (2.0, 0.3)}
SIDES = {1: "/left/wrench", 2: "/right/wrench"}
SAID = "\n".join(f"{name} = {theirs!r}" for name, theirs in OF_TOPICS["columns"].items())
LAYOUT = f"""
clock = "/left/wrench"
space = "plane"
grips = {[list(grip) for grip in motions.BEAM]}
[columns]
{SAID}
[pose]
columns = ["/object/pose/orientation/{'", "/object/pose/orientation/'.join("xyzw")}"]
order = "xyzw"
[body]
mass = {BODY["mass"]}
inertia = {BODY["inertia"]}
drag = {list(BODY["drag"])}
"""
DEVICES = {
    "left": ("f1x", "f1y", "t1z"),
    "right": ("f2x", "f2y", "t2z"),
    "mocap": ("x", "y", "theta"),
}


def written(folder: Path, late: dict[str, float] | None = None, **changed: Any) -> Path:
    """A trial, its devices' files of which some are late [s]."""
    columns = motions.planar(0) | changed
    for name, theirs in DEVICES.items():
        time = columns["time"] + (late or {}).get(name, 0.0)
        made = {"time": time} | {each: columns[each] for each in theirs}
        cases.save(made, folder / f"{name}.npz")
    return folder / "left.npz"


def checked(path: Path, **delays: float) -> Any:
    files: dict[str, Any] = {name: {"path": f"{name}.npz"} for name in ("right", "mocap")}
    for name, delay in delays.items():
        files.setdefault(name, {})["delay"] = delay
    return check_file(path, layout=declared(grips=motions.BEAM, files=files, body=BODY))


def fits(told: Any) -> dict[str, float]:
    """Delay of each device that fits best, by its file."""
    found = re.findall(r"\((\w+)\.npz\) fits best ([+-][\d.]+) s late", "\n".join(told.lines()))
    return {name: float(delay) for name, delay in found}


def test_devices_that_are_on_time_are_found_so(tmp_path):
    told = checked(written(tmp_path))
    assert not told.consistency.warnings
    assert fits(told) == pytest.approx(dict.fromkeys(DEVICES, 0.0), abs=0.003)


@pytest.mark.parametrize(
    ("name", "who"),
    [
        ("mocap", "the pose (mocap.npz)"),
        ("right", "sensor 2 (right.npz)"),
        ("left", "sensor 1 (left.npz)"),
    ],
)
def test_a_late_device_is_named_with_its_file_and_what_mends_it_does(name, who, tmp_path):
    path = written(tmp_path, {name: 0.05})
    told = checked(path)
    (warning,) = told.consistency.warnings
    remedy = re.search(rf"\[files\.{name}\] delay = (0\.0\d+)", warning)
    assert f"if {who} is 0.0" in warning
    assert remedy is not None
    delay = float(remedy[1])
    assert delay == pytest.approx(0.05, abs=0.003)
    assert fits(told)[name] == pytest.approx(delay, abs=0.001)
    mended = checked(path, **{name: delay})
    assert not mended.consistency.warnings
    again = checked(path, **{name: 0.02}).consistency.warnings[0]  # not all of it
    assert re.search(rf"\[files\.{name}\] delay = 0\.0(4[789]|5[0123])", again)


def test_two_late_devices_are_named_together(tmp_path):
    told = checked(written(tmp_path, {"left": 0.06, "right": -0.04}))
    (warning,) = told.consistency.warnings
    assert "sensor 1 (left.npz) is 0.06" in warning
    assert "s late and sensor 2 (right.npz) is 0.04" in warning
    assert re.search(
        r"\[files\.left\] delay = 0\.0[56]\d+, \[files\.right\] delay = -0\.0", warning
    )


def test_a_wrong_sensor_is_named_with_its_file(tmp_path):
    columns = motions.planar(0)
    right = {name: -columns[name] for name in DEVICES["right"]}
    (warning, *_) = checked(written(tmp_path, **right)).consistency.warnings
    assert "the reaction on sensor 2 (right.npz) is recorded: [sensors.2] sign = -1" in warning


def test_a_wrong_pose_is_named_with_its_file(tmp_path):
    theta = motions.planar(0)["theta"] * 57.29577951308232
    (warning, *_) = checked(written(tmp_path, theta=theta)).consistency.warnings
    assert "theta (mocap.npz) is in deg: --angle deg" in warning


def test_of_two_clocks_only_the_difference_is_told(tmp_path):
    columns = motions.planar(0)
    forces = {name: columns[name] for name in columns if name[0] in "tf" and name != "theta"}
    cases.save({"time": columns["time"] + 0.05} | {n: columns[n] for n in DEVICES["mocap"]},
               tmp_path / "mocap.npz")  # fmt: skip
    path = cases.save(forces, tmp_path / "forces.npz")
    layout = declared(grips=motions.BEAM, join=(str(tmp_path / "mocap.npz"),), body=BODY)
    told = check_file(path, layout=layout)
    assert list(fits(told)) == ["mocap"]
    assert "if the pose (mocap.npz) is 0.0" in told.consistency.warnings[0]
    layout = declared(grips=motions.BEAM, twist_frame="world", body=BODY)
    alone = check_file(cases.save(columns, tmp_path / "all.npz"), layout=layout)
    assert not fits(alone)


def bag_of(columns: dict[str, Any], late: dict[str, float], folder: Path) -> Path:
    """A bag of two wrenches and a pose, whose stamps are so late [s]."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    of = store.types
    kinds = dict.fromkeys(SIDES.values(), WRENCH) | {"/object": POSE}
    vector = of["geometry_msgs/msg/Vector3"]
    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        to = {name: bag.add_connection(name, kind, typestore=store) for name, kind in kinds.items()}
        for k, second in enumerate(columns["time"]):
            row = {name: float(each[k]) for name, each in columns.items()}
            for topic, kind in kinds.items():
                stamp = 10**18 + round(1e9 * (second + late.get(topic, 0.0)))
                if kind == POSE:
                    turn = (0.0, 0.0, np.sin(row["theta"] / 2), np.cos(row["theta"] / 2))
                    content = of["geometry_msgs/msg/Pose"](
                        of["geometry_msgs/msg/Point"](row["x"], row["y"], 0.0),
                        of["geometry_msgs/msg/Quaternion"](*turn),
                    )
                else:
                    i = next(i for i, side in SIDES.items() if side == topic)
                    content = of["geometry_msgs/msg/Wrench"](
                        vector(row[f"f{i}x"], row[f"f{i}y"], 0.0), vector(0.0, 0.0, row[f"t{i}z"])
                    )
                time = of["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
                message = of[kind](of["std_msgs/msg/Header"](time, "world"), content)
                bag.write(to[topic], stamp, bytes(store.serialize_cdr(message, kind)))
    return folder / "bag"


@pytest.mark.parametrize(
    "late", [{"/object": 0.05}, {SIDES[1]: 0.06, SIDES[2]: -0.04}], ids=["pose", "both sensors"]
)
def test_lines_that_are_advised_for_a_late_topic_mend_it_once_pasted(late, tmp_path):
    pytest.importorskip("rosbags")
    path = bag_of(motions.planar(0, duration=8.0), late, tmp_path)
    (tmp_path / "lab.toml").write_text(LAYOUT)
    first = check_file(path, layout=Layout.load(tmp_path / "lab.toml")).consistency
    (warning,) = first.warnings
    advised = re.findall(r'(\[files\."[^"]+"\]) (part = "[^"]+")(?: (delay = -?[\d.]+))?', warning)
    assert len(advised) == 3
    pasted = "\n".join(line for each in advised for line in each)
    (tmp_path / "pasted.toml").write_text(LAYOUT + pasted)
    layout = Layout.load(tmp_path / "pasted.toml")
    said = {name: each.get("delay") for name, each in layout.files.items()}
    assert said == {
        topic: pytest.approx(late[topic], abs=0.004) if topic in late else None
        for topic in (*SIDES.values(), "/object")
    }
    again = check_file(path, layout=layout).consistency
    assert not again.warnings
    assert again.balance is not None
    assert again.balance.left < 0.001
