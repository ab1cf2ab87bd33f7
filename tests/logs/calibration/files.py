"""The simulated laboratory's trials as several files, each device with a clock of its own."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tests.logs import cases
from tests.logs.calibration import lab

CAMERA = {"path": "camera.csv", "time": "stamp", "unit": "ms", "delay": lab.DELAY}
POSE = {"columns": ["q0", "q1", "q2", "q3"], "order": "xyzw"}
READING = 0.02  # noise of a sensor [lbf, lbf in]: 0.09 N and 2.3 mN m
PICTURE = 2e-4  # noise of a camera [m], of parts of a quaternion


class Trial(NamedTuple):
    """Files of a trial, the layout for them, and what really happened."""

    path: Path  # of the recording
    said: dict[str, Any]  # the layout
    columns: dict[str, Any]  # truth
    truth: dict[str, Any]  # layout of that
    rows: int  # that all devices have
    every: int  # rows of which one is decomposed


def plane(folder: Path, *, noise: bool = False) -> Trial:
    """Two sensors in one file, with handles that hang on them, and a camera in another."""
    episode, grips = lab.planar()
    columns = dict(episode)
    turn = Rotation.from_euler("z", columns["theta"][:, None])
    forces = {n: each for n, each in lab.written_in_the_plane().items() if n[0] in "ft"}
    del forces["theta"]
    down = turn.inv().apply([0.0, -lab.GRAVITY, 0.0])  # the object's axes
    weight = lab.HANDLE * Rotation.from_euler("z", -lab.ANGLE).apply(down)
    moment = lab.HUNG[0] * weight[:, 1] - 0.06 * weight[:, 0]
    for i in (1, 2):  # a handle at (0.01, 0.06) hangs on each sensor, which says the reaction
        forces[f"f{i}x"] = forces[f"f{i}x"] - weight[:, 0] / lab.POUND
        forces[f"f{i}y"] = forces[f"f{i}y"] - weight[:, 1] / lab.POUND
        forces[f"t{i}z"] = forces[f"t{i}z"] - moment / (lab.POUND * 0.0254)
    rng = np.random.default_rng(1)
    cases.save(camera(columns, turn, rng if noise else None), folder / "camera.csv")
    said = lab.layout_in_the_plane() | {"files": {"camera": CAMERA}, "pose": POSE}
    said["body"] = {"gravity": [0.0, -lab.GRAVITY]}
    for sensor in said["sensors"].values():
        sensor["load"] = {"mass": lab.HANDLE, "center": [0.01, 0.06]}
    path = cases.save(read_by(forces, rng if noise else None), folder / "forces.csv")
    return Trial(path, said, columns, {"grips": grips}, 5991, 7)


def space(folder: Path, *, noise: bool = False) -> Trial:
    """A file a sensor, of which the second begins later and counts milliseconds, and a camera."""
    columns = dict(lab.spatial())
    turn = Rotation.from_quat(np.stack([columns[f"q{axis}"] for axis in "xyzw"], axis=-1))
    habits = ("rotation", "offset", "handle", "bias", "units")
    written = lab.written_in_space(*habits)
    rng = np.random.default_rng(2)
    for i in (1, 2):
        each = {n: written[n] for n in written if n[0] in "ftr" and n[1] == str(i)}
        time = {"time": columns["time"]} if i == 1 else {"ms": 1000 * columns["time"]}
        made = read_by(time | each, rng if noise else None)
        cases.save({n: v[3 * (i - 1) :] for n, v in made.items()}, folder / f"{i}.csv")
    cases.save(camera(columns, turn, rng if noise else None), folder / "camera.csv")
    said = lab.layout_in_space(*habits) | {"pose": POSE}
    second = {"path": "2.csv", "time": "ms", "unit": "ms"}
    said["files"] = {"camera": CAMERA, "second": second}
    return Trial(folder / "1.csv", said, columns, {}, 5988, 250)


def camera(
    columns: dict, turn: Rotation, rng: np.random.Generator | None = None, every: int = 10
) -> dict[str, Any]:
    """What a camera says of a pose: w last, at a tenth of the rate, stamped late [ms]."""
    made = {"stamp": 1000 * (columns["time"] + lab.DELAY)}
    made |= {name: columns[name] for name in "xyz" if name in columns}
    made |= {f"q{j}": each for j, each in enumerate(turn.as_quat().T)}
    made = {name: each[::every] for name, each in made.items()}
    if rng is None:
        return made
    rows = len(made["stamp"])
    return {n: v if n == "stamp" else v + PICTURE * rng.normal(size=rows) for n, v in made.items()}


def read_by(columns: dict[str, Any], rng: np.random.Generator | None) -> dict[str, Any]:
    """Wrenches with the noise of sensors."""
    if rng is None:
        return columns
    return {
        name: each + READING * rng.normal(size=len(each)) if name[0] in "ft" and name[1:2].isdigit()
        else each
        for name, each in columns.items()
    }  # fmt: skip
