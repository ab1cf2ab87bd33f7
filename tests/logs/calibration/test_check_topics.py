"""A late topic of a bag of which nothing was declared is named with lines that keep the others."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from coopenv.logs import Layout, check_file
from tests.logs import motions
from tests.logs.calibration.test_check_joined import BODY
from tests.logs.devices import OF_TOPICS, POSE, WRENCH

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
