"""Recordings of several devices, for tests: files beside each other, ROS bags, C3D."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

START = 1_700_000_000_000_000_000  # [ns]
WRENCH = "geometry_msgs/msg/WrenchStamped"
POSE = "geometry_msgs/msg/PoseStamped"
OF_TOPICS: dict[str, Any] = {
    "clock": "/left/wrench",
    "space": "plane",
    "columns": {
        f"{kind}{i}{axis}": f"/{side}/wrench/wrench/{what}/{axis}"
        for i, side in ((1, "left"), (2, "right"))
        for kind, what, axis in (("f", "force", "x"), ("f", "force", "y"), ("t", "torque", "z"))
    }
    | {"x": "/object/pose/position/x", "y": "/object/pose/position/y"},
}


def sampled(
    columns: dict[str, Any],
    names: Iterable[str],
    *,
    every: float = 0.01,
    begin: float = 0.0,
    shift: float = 0.0,
    unit: float = 1.0,
    timed: bool = True,
) -> dict[str, Any]:
    """Columns that change evenly, at other times [s].

    ``shift`` is how much later the stamps are, ``unit`` that of the stamps [s].
    """
    time = columns["time"]
    rows = round((time[-1] - begin) / every) + 1 + (every < 0.01)
    at = np.arange(rows) * every + begin
    made = {"time": (at + shift) / unit} if timed else {}
    for name in names:
        slope = (columns[name][-1] - columns[name][0]) / (time[-1] - time[0])
        made[name] = columns[name][0] + slope * (at - time[0])
    return made


def rosbag2(columns: dict[str, Any], folder: Path, storage: str) -> Path:
    """The file in a bag of two force sensors and a pose at half their rate."""
    bag = rosbag2_folder(columns, folder, storage)
    return next(each for each in bag.iterdir() if each.suffix != ".yaml")


def rosbag2_folder(
    columns: dict[str, Any], folder: Path, storage: str, *, compressed: str = "", name: str = "bag"
) -> Path:
    """That bag as ROS 2 writes it: a folder; ``compressed`` by FILE or MESSAGE."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    made = Writer(folder / name, version=9, storage_plugin=StoragePlugin[storage])
    if compressed:
        made.set_compression(CompressionMode[compressed], CompressionFormat.ZSTD)
    with made as bag:
        _write(bag, store, columns, lambda *each: bytes(store.serialize_cdr(*each)))
    return folder / name


def rosbag1(columns: dict[str, Any], folder: Path) -> Path:
    """The same as ROS 1 wrote it."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(folder / "trial.bag") as bag:
        _write(bag, store, columns, lambda *each: bytes(store.serialize_ros1(*each)))
    return folder / "trial.bag"


def _write(bag: Any, store: Any, columns: dict[str, Any], serialize: Any) -> None:
    of = store.types
    topics = {"/left/wrench": WRENCH, "/right/wrench": WRENCH, "/object": POSE}
    to = {name: bag.add_connection(name, kind, typestore=store) for name, kind in topics.items()}
    vector, number = of["geometry_msgs/msg/Vector3"], [0]

    def send(topic: str, stamp: int, content: Any) -> None:
        time = of["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        first = (number[0],) if "seq" in of["std_msgs/msg/Header"].__annotations__ else ()
        message = of[topics[topic]](of["std_msgs/msg/Header"](*first, time, "world"), content)
        bag.write(to[topic], stamp, serialize(message, topics[topic]))
        number[0] += 1

    for k, second in enumerate(columns["time"]):
        stamp = START + round(1e9 * second)
        for topic, i in (("/left/wrench", 1), ("/right/wrench", 2)):
            force = vector(float(columns[f"f{i}x"][k]), float(columns[f"f{i}y"][k]), 0.0)
            torque = vector(0.0, 0.0, float(columns[f"t{i}z"][k]))
            send(topic, stamp, of["geometry_msgs/msg/Wrench"](force, torque))
        if k % 2 == 0 or k == len(columns["time"]) - 1:
            at = of["geometry_msgs/msg/Point"](float(second), 0.0, 0.0)
            turned = of["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            send("/object", stamp, of["geometry_msgs/msg/Pose"](at, turned))


def c3d_file(columns: dict[str, Any], folder: Path) -> Path:
    """A file of six analog channels, and of a marker at half their rate."""
    import c3d

    names = list(columns)[1:]
    made = c3d.Writer(point_rate=50, analog_rate=100)
    made.set_point_labels(["object"])
    made.set_analog_labels(names)
    analog = np.stack([columns[name] for name in names]).astype(np.float32)
    for first in range(0, analog.shape[1], 2):
        points = np.zeros((1, 5), np.float32)
        points[0, 0] = first
        made.add_frames([(points, analog[:, first : first + 2])])
    path = folder / "trial.c3d"
    with path.open("wb") as file:
        made.write(file)
    return path
