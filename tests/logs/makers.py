"""Small files as the software of makers writes them, for the page of recipes.

Of each form the page says where it is documented or in whose source it stands. All hold the same
trial: two hands carry a body in space, 100 rows a second; hands alone where the maker sells force
sensors, the pose beside a table of hands where it sells cameras.
"""

import csv
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from coopenv.arrays import FloatArray
from tests.logs import cases, motions

RATE, ROWS = 100, 300
SIDES = ("left", "right")
NEWTON, NEWTON_METER = 1_000_000, 1_000_000  # counts of a Net F/T, as configured
FULL = np.array([200, 200, 400, 100, 100, 100])  # full scales of a JR3 [N, N·m · 10]


@cache
def trial() -> tuple[tuple[str, FloatArray], ...]:
    """Columns in SI units, object frame, without a twist."""
    columns = motions.spatial(1, rate=RATE, duration=ROWS / RATE, noise=0.0)
    return tuple((name, each) for name, each in columns.items() if name[0] not in "vor")


def read_by(hand: int) -> FloatArray:
    """Force and torque ``(T, 6)`` of a hand [N, N·m]."""
    columns = dict(trial())
    return np.stack([columns[f"{k}{hand + 1}{axis}"] for k in "ft" for axis in "xyz"], axis=-1)


def pose() -> tuple[FloatArray, FloatArray]:
    """Position ``(T, 3)`` [m], quaternion ``(T, 4)`` x, y, z, w."""
    columns = dict(trial())
    return (
        np.stack([columns[axis] for axis in "xyz"], axis=-1),
        np.stack([columns[f"q{axis}"] for axis in "xyzw"], axis=-1),
    )


def hands(folder: Path) -> None:
    """The table of hands beside which cameras record."""
    columns = {name: each for name, each in trial() if name == "time" or name[0] in "ft"}
    cases.save(columns, folder / "hands.csv")


def written(path: Path, lines: Iterable[str], rows: Iterable[Iterable[Any]], **said: Any) -> None:
    """Lines as they are, then rows through the writer of the standard library."""
    with path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in lines)
        csv.writer(file, lineterminator="\n", **said).writerows(rows)


def ati_daq(folder: Path) -> None:
    """ATI DAQ F/T .NET demo: names with units, four fields about the capture, six numbers a row."""
    units = ["N"] * 3 + ["N-m"] * 3
    names = [f"{kind} {axis}" for kind in ("Force", "Torque") for axis in "XYZ"]
    head = [f"{name} ({unit})" for name, unit in zip(names, units, strict=True)]
    head += [f"Frequency = {10 * RATE}", "Averaging Level = 10", "F/T Serial Number = FT00001"]
    head += ["Time Started = 3/15/2021 2:13:42 PM"]
    for hand, side in enumerate(SIDES):
        rows = [head, *([repr(float(each)) for each in row] for row in read_by(hand))]
        written(folder / f"{side}.csv", (), rows, quoting=csv.QUOTE_ALL)


def ati_net(folder: Path) -> None:
    """ATI Net F/T Java demo: seven lines, names, quoted counts, times to the second."""
    head = ["Start Time: 3/15/21, 2:13 PM", f"RDT Sample Rate: {RATE}", "Force Units: N"]
    head += [f"Counts per Unit Force: {NEWTON}", "Torque Units: Nm"]
    head += [f"Counts per Unit Torque: {NEWTON_METER}"]
    head += ["Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time"]
    for hand, side in enumerate(SIDES):
        counts = np.round(read_by(hand) * np.repeat([NEWTON, NEWTON_METER], 3)).astype(int)
        rows = (
            ["0x0", k + 1, 4211 + 70 * k, *row, f"Mar 15, 2021 2:13:{42 + k // RATE} PM"]
            for k, row in enumerate(counts.tolist())
        )
        written(folder / f"{side}.csv", head, rows, quoting=csv.QUOTE_ALL)


def jr3(folder: Path) -> None:
    """A JR3 by a log of one's own: time and six numbers, of which 16384 are the full scale."""
    for hand, side in enumerate(SIDES):
        counts = np.round(read_by(hand) / (FULL / [1, 1, 1, 10, 10, 10]) * 16384).astype(int)
        rows = (["%.3f" % (k / RATE), *row] for k, row in enumerate(counts.tolist()))
        written(folder / f"{side}.txt", (), rows, delimiter=" ")


def onrobot(folder: Path) -> None:
    """An OnRobot HEX by a log of its datagrams: sequence, counter, status, counts."""
    head = ["sequence;counter;status;Fx;Fy;Fz;Tx;Ty;Tz"]
    for hand, side in enumerate(SIDES):
        counts = np.round(read_by(hand) * np.repeat([1e4, 1e5], 3)).astype(int)
        rows = ([k + 1, 10 * k, 0, *row] for k, row in enumerate(counts.tolist()))
        written(folder / f"{side}.csv", head, rows, delimiter=";")


def optitrack(folder: Path) -> None:
    """Motive's CSV of a rigid body, format 1.23: y up, quaternion x y z w, a frame not seen."""
    hands(folder)
    meta = "Format Version,1.23,Take Name,carry,Take Notes,,Capture Frame Rate,100.000000,"
    meta += "Export Frame Rate,100.000000,Capture Start Time,2021-03-15 02.13.42.000 PM,"
    meta += f"Capture Start Frame,0,Total Frames in Take,{ROWS},Total Exported Frames,{ROWS},"
    meta += "Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global"
    kinds = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]
    head = [meta, "", f",Type{',Rigid Body' * 8}", f",Name{',table' * 8}"]
    head += [f",ID{',90A1DB54' * 8}", f",,{','.join(kinds)}"]
    head += ["Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,"]
    position, quaternion = y_up()
    rows = [
        [k, f"{k / RATE:.6f}", *(f"{each:.6f}" for each in (*quaternion[k], *position[k], 3e-4))]
        for k in range(ROWS)
    ]
    rows[150][2:] = [""] * 8
    written(folder / "take.csv", head, rows)


def y_up() -> tuple[FloatArray, FloatArray]:
    """The pose in a room whose y axis points up."""
    position, quaternion = pose()
    turn = Rotation.from_euler("x", -90, degrees=True)
    return turn.apply(position), (turn * Rotation.from_quat(quaternion)).as_quat()


def vicon_csv(folder: Path) -> None:
    """Nexus' ASCII of devices and of segments, each exported by itself; rotations are vectors."""
    names = [f"{axis}" for axis in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    units = ["N"] * 3 + ["N.mm"] * 3
    parts = [f"{side.capitalize()} - {kind}" for side in SIDES for kind in ("Force", "Moment")]
    head = ["Devices", f"{RATE}", f",,{',,,'.join(parts)},,"]
    head += ["Frame,Sub Frame," + ",".join(2 * names), ",," + ",".join(2 * units)]
    both = np.hstack([read_by(hand) * np.repeat([1, 1000], 3) for hand in (0, 1)])
    rows = ([k + 1, 0, *(f"{each:.6g}" for each in row)] for k, row in enumerate(both))
    written(folder / "devices.csv", head, rows)
    position, quaternion = pose()
    turned = Rotation.from_quat(quaternion).as_rotvec(degrees=True)
    head = ["Segments", f"{RATE}", ",,table:table,,,,,", "Frame,Sub Frame,RX,RY,RZ,TX,TY,TZ"]
    head += [",,deg,deg,deg,mm,mm,mm"]
    both = np.hstack([turned, 1000 * position])
    rows = ([k + 1, 0, *(f"{each:.6g}" for each in row)] for k, row in enumerate(both))
    written(folder / "segments.csv", head, rows)


def vicon_c3d(folder: Path) -> None:
    """Nexus' C3D: analog channels of two devices in N and Nmm, beside the markers of an object."""
    import c3d

    made = c3d.Writer(point_rate=RATE / 2, analog_rate=RATE)
    made.set_point_labels([f"table{k}" for k in range(1, 4)])
    labels = [
        f"{kind}.{kind[0]}{axis}{k}"
        for k in (1, 2)
        for kind in ("Force", "Moment")
        for axis in "xyz"
    ]
    made.set_analog_labels(labels)
    both = np.hstack([read_by(hand) * np.repeat([1, 1000], 3) for hand in (0, 1)])
    analog = both.T.astype(np.float32)
    for first in range(0, ROWS, 2):
        made.add_frames([(np.zeros((3, 5), np.float32), analog[:, first : first + 2])])
    with (folder / "trial.c3d").open("wb") as file:
        made.write(file)


def ros(folder: Path) -> None:
    """A rosbag2 of two ``WrenchStamped`` and a ``PoseStamped`` at half their rate."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    of, place = store.types, "geometry_msgs/msg/"
    kinds = {"/left/wrench": "WrenchStamped", "/right/wrench": "WrenchStamped"}
    kinds["/table/pose"] = "PoseStamped"
    vector = of[f"{place}Vector3"]
    position, quaternion = pose()
    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        to = {
            topic: bag.add_connection(topic, place + kind, typestore=store)
            for topic, kind in kinds.items()
        }

        def send(topic: str, k: int, content: Any) -> None:
            stamp = 1_700_000_000_000_000_000 + k * 10**9 // RATE
            time = of["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
            kind = place + kinds[topic]
            message = of[kind](of["std_msgs/msg/Header"](time, "table"), content)
            bag.write(to[topic], stamp, bytes(store.serialize_cdr(message, kind)))

        for k in range(ROWS):
            for hand, side in enumerate(SIDES):
                force, torque = np.split(read_by(hand)[k], 2)
                wrench = of[f"{place}Wrench"](vector(*force), vector(*torque))
                send(f"/{side}/wrench", k, wrench)
            if k % 2 == 0 or k == ROWS - 1:
                at = of[f"{place}Point"](*position[k])
                send("/table/pose", k, of[f"{place}Pose"](at, _turned(of, quaternion[k])))


def _turned(of: Any, quaternion: FloatArray) -> Any:
    return of["geometry_msgs/msg/Quaternion"](*quaternion)


def structure() -> dict[str, Any]:
    """Fields of a MATLAB structure: a column a sample, as signals are logged."""
    position, quaternion = pose()
    return {
        "t": dict(trial())["time"],
        "left": read_by(0).T,
        "right": read_by(1).T,
        "pose": np.hstack([position, quaternion]).T,
    }


def matlab(folder: Path) -> None:
    """A ``.mat`` of version 7, which ``save`` writes by default."""
    from scipy.io import savemat

    savemat(folder / "trial.mat", {"trial": structure()}, do_compression=True)


def matlab73(folder: Path) -> None:
    """A ``.mat`` of version 7.3, as ``save -v7.3``: HDF5, whose axes are in reverse order."""
    import h5py

    path = folder / "trial73.mat"
    with h5py.File(path, "w", userblock_size=512) as made:
        for name, values in structure().items():
            made.create_dataset(f"trial/{name}", data=np.atleast_2d(values).T)
    with path.open("r+b") as begin:
        begin.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")


MAKERS: dict[str, Callable[[Path], None]] = {  # by the layout of the page that reads them
    "ati_daq": ati_daq,
    "ati_net": ati_net,
    "jr3": jr3,
    "onrobot": onrobot,
    "optitrack": optitrack,
    "vicon": vicon_csv,
    "vicon_c3d": vicon_c3d,
    "ros": ros,
    "matlab": matlab,
    "matlab73": matlab73,
}
