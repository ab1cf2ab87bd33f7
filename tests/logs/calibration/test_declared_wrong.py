"""A wrong frame, exchanged sensors or grips, and wrong units of lengths are named with a remedy.

The sensors of these laboratories are turned, sit beside the grips and have biases, which the layout
declares: a mistake is found in spite of what is taken off and turned back, and nothing is named
where all is right.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.logs import Layout, check_file
from tests.logs import cases, motions
from tests.logs.calibration.lab import declared

TURNS = (Rotation.from_euler("z", 40, degrees=True), Rotation.from_euler("z", -70, degrees=True))
OFFSETS = np.array([[0.04, 0.01, 0.0], [-0.02, 0.05, 0.0]])  # [m], the sensor's axes
BIASES = np.array([[3.0, -2.0, 1.0, 0.3, -0.2, 0.1], [-1.0, 2.0, 4.0, 0.2, 0.5, -0.3]])
BODIES: dict[int, dict[str, Any]] = {
    2: {"mass": motions.MASS, "inertia": motions.INERTIA, "drag": (2.0, 0.3)},
    3: {"mass": motions.MASS, "inertia": (0.3, 2.0, 2.2), "gravity": (0.0, 0.0, -9.81)},
}
GRIPS = {2: motions.BEAM, 3: ((-0.9, 0.1, 0.0), (0.9, -0.2, 0.1))}
AXES = {2: (0, 1, 5), 3: (0, 1, 2, 3, 4, 5)}


def recorded(dimension: int, seed: int = 0, frame: str = "object") -> dict[str, Any]:
    """What two turned sensors read of a noisy trial, in the frame of the object or the world."""
    columns = motions.planar(seed) if dimension == 2 else motions.spatial(seed)
    columns = {name: each for name, each in columns.items() if name[0] not in "vor"}
    nothing = np.zeros_like(columns["time"])
    turn = Rotation.from_rotvec(np.stack([nothing, nothing, columns.get("theta", nothing)], -1))
    if dimension == 3:
        turn = Rotation.from_quat(np.stack([columns[f"q{axis}"] for axis in "xyzw"], axis=-1))
    for i, (mounted, offset, bias) in enumerate(zip(TURNS, OFFSETS, BIASES, strict=True)):
        names = [f"{kind}{i + 1}{axis}" for kind in "ft" for axis in "xyz"]
        wrench = np.stack([columns.get(name, nothing) for name in names], axis=-1)
        force, torque = (mounted.inv().apply(each) for each in np.split(wrench, 2, axis=-1))
        torque = torque + np.cross(offset, force)
        force, torque = force + bias[:3], torque + bias[3:]
        if frame == "world":
            force, torque = turn.apply(force), turn.apply(torque)
        read = np.hstack([force, torque]).T
        columns |= {names[j]: read[j] for j in AXES[dimension]}
    return columns


def right(dimension: int) -> Layout:
    sensors = {
        f"{i + 1}": {
            "rotation": mounted.as_matrix()[:dimension, :dimension].tolist(),
            "offset": OFFSETS[i, :dimension].tolist(),
            "tare": BIASES[i, list(AXES[dimension])].tolist(),
        }
        for i, mounted in enumerate(TURNS)
    }
    return declared(grips=GRIPS[dimension], sensors=sensors, body=BODIES[dimension])


def in_columns(dimension: int, columns: dict[str, Any]) -> tuple[dict[str, Any], Layout]:
    """The same where columns say the grips."""
    made = dict(columns)
    for i, grip in enumerate(GRIPS[dimension]):
        for axis, place in zip("xyz", grip, strict=False):
            made[f"r{i + 1}{axis}"] = np.full_like(columns["time"], place)
    return made, replace(right(dimension), grips=None)


def times(columns: dict[str, Any], names: str, factor: float) -> dict[str, Any]:
    """Positions (x), grips (r) or both so many times as large."""
    chosen = [n for n in columns if (n in "xyz" and "x" in names) or (n[0] == "r" and "r" in names)]
    assert chosen
    return columns | {name: factor * columns[name] for name in chosen}


def exchanged(columns: dict[str, Any], kinds: str) -> dict[str, Any]:
    """Columns of both effectors exchanged."""
    other = {"1": "2", "2": "1"}
    return {
        f"{n[0]}{other[n[1]]}{n[2:]}" if n[0] in kinds and n[1:2] in other else n: each
        for n, each in columns.items()
    }


def told(columns: dict[str, Any], layout: Layout, folder: Path) -> Any:
    return check_file(cases.save(columns, folder / "a.npz"), layout=layout).consistency


def scaled(layout: Layout, factor: float, **said: Any) -> Layout:
    """With lengths of the layout so many times as large, but for what is said."""
    sensors = {
        i: replace(each, offset=tuple(factor * np.array(each.offset)))
        for i, each in layout.sensors.items()
    }
    grips = tuple(map(tuple, factor * np.array(layout.grips)))
    return replace(layout, **{"sensors": sensors, "grips": grips} | said)


WRONG = {
    "said in the world": (
        lambda d: (recorded(d), replace(right(d), frame="world", twist_frame="world")),
        "forces and torques are in the object frame: --frame object",
    ),
    "in the world": (
        lambda d: (recorded(d, frame="world"), right(d)),
        "forces and torques are in the world frame: --frame world",
    ),
    "devices": (
        lambda d: (exchanged(recorded(d), "ft"), right(d)),
        "sensors 1 and 2 are taken one for the other: exchange their columns, --map f1x=f2x … f2x",
    ),
    "grips": (
        lambda d: (recorded(d), replace(right(d), grips=GRIPS[d][::-1])),
        "the grips of effectors 1 and 2 are exchanged: exchange them, grips = [[-0.9, 0.1",
    ),
    "columns of grips": (
        lambda d: (exchanged(in_columns(d, recorded(d))[0], "r"), in_columns(d, recorded(d))[1]),
        "the grips of effectors 1 and 2 are exchanged: exchange them, --map r1x=r2x … r2x=r1x",
    ),
    "mm of positions": (
        lambda d: (times(recorded(d), "x", 1e3), right(d)),
        "positions of the file are in mm: --length mm, and lengths of the layout in mm too",
    ),
    "mm of all columns": (
        lambda d: (times(in_columns(d, recorded(d))[0], "xr", 1e3), in_columns(d, recorded(d))[1]),
        "positions of the file are in mm: --length mm, and lengths of the layout in mm too",
    ),
    "mm of grips": (
        lambda d: (recorded(d), scaled(right(d), 1e3, sensors=right(d).sensors)),
        "grips are in mm: grips = [[-0.9, 0.1",
    ),
    "mm of columns of grips": (
        lambda d: (times(in_columns(d, recorded(d))[0], "r", 1e3), in_columns(d, recorded(d))[1]),
        "grips are in mm: bring all lengths into one unit",
    ),
    "mm of the layout": (
        lambda d: (recorded(d), scaled(right(d), 1e3)),
        "lengths of the layout are in mm: write them in m",
    ),
    "mm of all": (
        lambda d: (times(recorded(d), "x", 1e3), scaled(right(d), 1e3)),
        "lengths are in mm: --length mm",
    ),
    "m taken for mm": (
        lambda d: (recorded(d), scaled(right(d), 1e3, length="mm")),
        "positions of the file are in m: --length m, and lengths of the layout in m too",
    ),
    "inches": (
        lambda d: (times(recorded(d), "x", 1 / 0.0254), right(d)),
        "positions of the file are in in: --length in",
    ),
}


@pytest.mark.parametrize("dimension", [2, 3], ids=["plane", "space"])
@pytest.mark.parametrize("mistake", WRONG)
def test_what_is_declared_wrong_is_named_first(mistake, dimension, tmp_path):
    made, says = WRONG[mistake]
    said = told(*made(dimension), tmp_path)
    assert f"moves as the wrenches say if {says}" in said.warnings[0]
    assert said.balance.explanations[0].left < 0.002
    assert len(said.warnings) == 1  # what laws without the mass guess is not told beside it


@pytest.mark.parametrize("dimension", [2, 3], ids=["plane", "space"])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_named_where_all_is_right(seed, dimension, tmp_path):
    columns = recorded(dimension, seed)
    for made in ((columns, right(dimension)), in_columns(dimension, columns)):
        said = told(*made, tmp_path)
        assert not said.warnings
        assert not said.balance.explanations
    rough = {
        name: each + 0.5 * np.std(each) * np.random.default_rng(seed).normal(size=len(each))
        if name[:2] in ("f1", "f2", "t1", "t2")
        else each
        for name, each in columns.items()
    }
    assert not told(rough, right(dimension), tmp_path).balance.explanations


def test_a_body_that_lies_still_is_not_said_to_move_in_another_unit(tmp_path):
    columns = recorded(2)
    rng = np.random.default_rng(0)
    for name in ("x", "y", "theta"):
        columns[name] = 1e-4 * rng.normal(size=len(columns["time"]))
    said = told(columns, right(2), tmp_path)
    assert said.balance.unchecked == "it hardly moves"


def test_devices_of_files_are_named_by_the_columns_to_exchange(tmp_path):
    columns = recorded(2)
    for name, i in (("left", 2), ("right", 1)):  # the wrong way round
        own = {n: columns[n.replace("_", f"{i}")] for n in ("f_x", "f_y", "t_z")}
        cases.save({"time": columns["time"]} | own, tmp_path / f"{name}.npz")
    pose = {name: columns[name] for name in ("time", "x", "y", "theta")}
    names = {f"{k}{i}{a}": f"{side}/{k}_{a}" for i, side in ((1, "left"), (2, "right"))
             for k, a in (("f", "x"), ("f", "y"), ("t", "z"))}  # fmt: skip
    files = {"left": {"path": "left.npz"}, "right": {"path": "right.npz"}}
    layout = replace(right(2), columns=names, files=files)
    said = told(pose, layout, tmp_path).warnings[0]
    assert "exchange their columns, --map f1x=right/f_x … f2x=left/f_x …" in said
