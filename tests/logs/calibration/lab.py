"""A simulated laboratory: trials as they were, and as its sensors and cameras write them down.

The corruptions are written here anew, sample by sample, not as the inverse of what corrects them.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import coopenv
from coopenv.arrays import FloatArray
from coopenv.logs import Layout, read
from tests.logs import motions

RATE = 1000  # [Hz]
POUND = 4.4482216152605  # [N]
ANGLE = np.radians(30.0)
OFFSET = 0.05  # [m] from the sensor to the grip, along its x axis
HANDLE = 0.4  # [kg]
HUNG = np.array([0.01, 0.0, 0.06])  # centre of the handle from the sensor's origin, its axes [m]
GRAVITY = 9.80665
BIAS = (np.array([4.0, -3.0, 0.5]), np.array([-2.0, 5.0, -0.4]))  # in the plane
BIAS_SPACE = (
    np.array([4.0, -3.0, 2.0, 0.5, -0.3, 0.2]),
    np.array([-2.0, 5.0, -3.0, -0.4, 0.2, 0.6]),
)
DELAY = 0.04  # [s]


def declared(**said: Any) -> Layout:
    """A layout, whose tables may be as files have them."""
    return Layout(**said)


def seen_in(path: Path, **said: Any) -> Any:
    """The recording of a file."""
    return read(path, declared(**said))


@cache
def planar(duration: float = 6.0) -> tuple[tuple[tuple[str, FloatArray], ...], tuple]:
    """An episode of the transport environment at 1 kHz: columns in SI units, and the grips."""
    core = coopenv.Transport(num_worlds=1, dt=1 / RATE, substeps=1, horizon=10**6)
    core.reset(seed=3)
    rows, grips = [], ()
    phase = np.random.default_rng(0).uniform(0, 6, (2, 3))
    for k in range(int(duration * RATE)):
        slow = np.sin(2 * np.pi * np.array([0.31, 0.43, 0.37]) * k / RATE + phase)
        core.step(0.8 * slow[None])
        step = core.transition
        assert step is not None
        state = step.state
        rows.append([state.time[0], *step.applied[0].ravel(), *state.pose[0]])
        grips = tuple(map(tuple, step.team.grips.reshape(-1, 2).tolist()))
    names = ("time", "f1x", "f1y", "t1z", "f2x", "f2y", "t2z", "x", "y", "theta")
    return tuple(zip(names, np.array(rows).T, strict=True)), grips


@cache
def spatial(duration: float = 6.0) -> tuple[tuple[str, FloatArray], ...]:
    """A rigid body in space, moved by two: columns in SI units, object frame."""
    columns = motions.spatial(4, rate=RATE, duration=duration, noise=0.0)
    return tuple((name, each) for name, each in columns.items() if name[0] not in "vo")


def written_in_the_plane() -> dict[str, Any]:
    """The planar episode as the laboratory writes it."""
    episode, _ = planar()
    columns = dict(episode)
    time = columns["time"]
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    for i in (1, 2):
        fx, fy, t = (columns[name] for name in (f"f{i}x", f"f{i}y", f"t{i}z"))
        fx, fy = c * fx + s * fy, c * fy - s * fx  # along the sensor's axes
        read = -np.stack([fx, fy, t + OFFSET * fy])  # the reaction, at the end of an arm
        read += BIAS[i - 1][:, None]
        read /= np.array([[POUND], [POUND], [POUND * 0.0254]])
        columns |= dict(zip((f"f{i}x", f"f{i}y", f"t{i}z"), read, strict=True))
    for name in ("x", "y", "theta"):
        columns[name] = np.interp(time - DELAY, time, columns[name])
    columns["theta"] = np.degrees(columns["theta"])
    return columns


def layout_in_the_plane(without: str = "") -> dict[str, Any]:
    """What that laboratory declares, ``without`` one thing."""
    unit = np.array([POUND, POUND, POUND * 0.0254])
    sensors: dict[str, dict] = {
        str(i): {
            "sign": -1,
            "rotation": 30.0,
            "offset": [OFFSET, 0.0],
            "tare": (BIAS[i - 1] / unit).tolist(),
        }
        for i in (1, 2)
    }
    said: dict[str, Any] = {"angle": "deg", "force": "lbf", "torque": "lbf*in"}
    said |= {"sensors": sensors, "pose": {"delay": DELAY}, "grips": planar()[1]}
    for sensor in sensors.values():
        sensor.pop(without, None)
    for name in {"delay": ("pose",), "units": ("force", "torque")}.get(without, ()):
        del said[name]
    if without == "degrees":
        del said["angle"]
        for sensor in sensors.values():
            sensor["rotation"] = float(ANGLE)
    if without == "grips":
        said["grips"] = said["grips"][::-1]
    return said


def written_in_space(*habits: str) -> dict[str, Any]:
    """The spatial trial as a laboratory with some of the habits writes it."""
    columns = dict(spatial())
    time = columns["time"]
    turn = Rotation.from_quat(np.stack([columns[f"q{a}"] for a in "xyzw"], axis=-1))
    mounted = Rotation.from_euler("ZYX", [30, 20, -50], degrees=True)
    down = turn.inv().apply([0.0, 0.0, -GRAVITY])  # in the object's axes
    for i in (1, 2):
        names = [f"{kind}{i}{axis}" for kind in "ft" for axis in "xyz"]
        read = np.stack([columns[name] for name in names], axis=-1)
        force, torque = read[:, :3], read[:, 3:]
        axes = mounted if "rotation" in habits else Rotation.identity()
        force, torque, pull = (axes.inv().apply(each) for each in (force, torque, down))
        if "offset" in habits:
            torque = torque + np.cross([OFFSET, 0, 0], force)
        if "handle" in habits:  # the sensor carries it, and the hand less of the object
            force = force + HANDLE * pull
            torque = torque + np.cross(HUNG, HANDLE * pull)
        read = np.concatenate([force, torque], axis=-1)
        if "bias" in habits:
            read = read + BIAS_SPACE[i - 1]
        if "units" in habits:
            read = read / np.repeat([POUND, POUND * 0.0254], 3)
        columns |= dict(zip(names, read.T, strict=True))
    if "delay" in habits:
        late = np.maximum(time - DELAY, 0.0)
        for name in ("x", "y", "z", "qw", "qx", "qy", "qz"):
            columns[name] = np.interp(late, time, columns[name])
    if "order" in habits:  # w last
        moved = {f"q{j}": columns.pop(f"q{axis}") for j, axis in enumerate("xyzw")}
        columns |= moved
    return columns


def layout_in_space(*habits: str) -> dict[str, Any]:
    """What that laboratory declares."""
    sensors: dict[str, dict] = {"1": {}, "2": {}}
    said: dict[str, Any] = {}
    for i in (1, 2):
        sensor = sensors[str(i)]
        if "rotation" in habits:
            sensor["rotation"] = {"euler": [30.0, 20.0, -50.0], "order": "ZYX"}
        if "offset" in habits:
            sensor["offset"] = [OFFSET, 0.0, 0.0]
        if "handle" in habits:
            sensor["load"] = {"mass": HANDLE, "center": HUNG.tolist()}
        if "bias" in habits:
            unit = np.repeat([POUND, POUND * 0.0254], 3) if "units" in habits else 1.0
            sensor["tare"] = (BIAS_SPACE[i - 1] / unit).tolist()
    if "rotation" in habits:
        said["angle"] = "deg"
    if "units" in habits:
        said |= {"force": "lbf", "torque": "lbf*in"}
    pose: dict[str, Any] = {"delay": DELAY} if "delay" in habits else {}
    if "order" in habits:
        pose |= {"columns": ["q0", "q1", "q2", "q3"], "order": "xyzw"}
    return said | {"sensors": sensors, "pose": pose}
