"""Tables of a layout on calibration: checked, and what they need of a file."""

import os
from collections.abc import Mapping
from typing import Any, Protocol

from coopenv.errors import InvalidInput
from coopenv.logs.calibration.body import Body
from coopenv.logs.calibration.processing import Filters, Pose
from coopenv.logs.calibration.sensor import Sensor, Tare
from coopenv.logs.calibration.stated import stated
from coopenv.logs.columns import ORIENTATION

LARGEST = 10_000  # number of an effector
ORIENTED = (*ORIENTATION[3], *ORIENTATION[2])  # columns of an orientation


class Declared(Protocol):
    """A layout, as far as calibration goes."""

    @property
    def sensors(self) -> Mapping[int, Sensor]:
        """Of effectors by their numbers."""
        ...

    @property
    def pose(self) -> Pose:
        """How it is written, of which point, when."""
        ...

    @property
    def filters(self) -> Filters:
        """Low pass, twist from pose, resampling."""
        ...

    @property
    def body(self) -> Body:
        """The object, where it is known."""
        ...


def checked_tables(layout: Declared) -> dict[str, Any]:
    """The tables of a layout by their names, each value checked.

    Raises
    ------
    InvalidInput, UnknownName
        If a key or a value is none; the message begins with the key, as ``sensors.1.offset``.
    """
    return {
        "sensors": _checked_sensors(layout.sensors),
        "pose": stated(Pose, layout.pose, "pose").checked("pose"),
        "filters": stated(Filters, layout.filters, "filters").checked("filters"),
        "body": stated(Body, layout.body, "body").checked("body"),
    }


def require_one_orientation(pose: Pose, columns: Mapping[str, str]) -> None:
    """Raise where ``[pose]`` and ``[columns]`` say different things of the orientation.

    Raises
    ------
    InvalidInput
        If both name its columns, or one says an order of what the other says is not there.
    """
    named = [name for name in ORIENTED if name in columns]
    said = [name for name in named if columns[name]]
    if pose.columns and said:
        raise InvalidInput(
            f"pose.columns must be left out where columns say which is {said[0]}, got "
            f"{list(pose.columns)} and {columns[said[0]]!r}; name the orientation once"
        )
    missing = [name for name in named if name != "theta" and not columns[name]]
    if pose.order == "xyzw" and not pose.columns and missing:
        raise InvalidInput(
            f"pose.order must be left out where columns say that there is no {missing[0]}, got "
            f"{pose.order!r}; name the four columns in pose.columns"
        )


def needed(layout: Declared, dimension: int) -> frozenset[str]:
    """What corrections need of a file: "time", "position" and "orientation", or some of them."""
    need: set[str] = set()
    if layout.filters != Filters() or layout.pose.delay:
        need.add("time")
    if layout.filters.pose is not None or layout.filters.twist_window is not None:
        need |= {"position", "orientation"}
    if layout.pose.com or layout.pose.columns:
        need.add("orientation")
    for sensor in layout.sensors.values():
        if sensor.load is not None and layout.body.pull(dimension).any():
            need.add("orientation")
        if sensor.load is not None and sensor.load.window is not None:
            need.add("time")
        if isinstance(sensor.tare, Tare) and sensor.tare.file is None:
            need.add("time")
    return frozenset(need)


def located(content: dict[str, Any], folder: str) -> dict[str, Any]:
    """Fields of a layout, whose files are named from the folder in which the layout is."""
    sensors = content.get("sensors")
    if not isinstance(sensors, Mapping):
        return content
    made = dict(sensors)
    for number, sensor in sensors.items():
        tare = sensor.get("tare") if isinstance(sensor, Mapping) else None
        if isinstance(tare, Mapping) and isinstance(tare.get("file"), str):
            there = os.path.join(folder, tare["file"])
            made[number] = {**sensor, "tare": {**tare, "file": there}}
    return {**content, "sensors": made}


def _checked_sensors(sensors: Any) -> dict[int, Sensor]:
    if not isinstance(sensors, Mapping):
        raise InvalidInput(f"sensors must be a table, got {sensors!r}; write [sensors.1]")
    made = {}
    for name, sensor in sensors.items():
        text = str(name)
        fits = text.isascii() and text.isdecimal() and 1 <= len(text) <= 5
        if not fits or text[0] == "0" or int(text) > LARGEST:
            raise InvalidInput(
                f"sensors must be named by the number of their effector, got {text[:80]!r}; write "
                "[sensors.1]"
            )
        made[int(text)] = stated(Sensor, sensor, f"sensors.{text}").checked(f"sensors.{text}")
    return made
