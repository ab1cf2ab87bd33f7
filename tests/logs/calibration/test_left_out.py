"""What is left out of the layout of a laboratory in space is named, with tares that were found.

The laboratory is that of the guide, whose sensors are turned, carry handles and were tared at rest.
"""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.recordings import PAGE
from coopenv.logs import Layout, check_file
from examples import record_laboratory
from tests.docs.snippets import snippets

LAYOUT = next(each.code for each in snippets(PAGE) if each.file == "laboratory.toml")


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    pytest.importorskip("pyarrow")
    folder = tmp_path_factory.mktemp("laboratory")
    record_laboratory.main(folder, np.random.default_rng(0))
    (folder / "laboratory.toml").write_text(LAYOUT, encoding="utf-8")
    return folder / "mocap.csv", Layout.load(folder / "laboratory.toml")


def sensors(layout: Layout, which=(1, 2), **changed: Any) -> Layout:
    """The layout with something else said of some sensors."""
    said = {
        i: replace(each, **changed) if i in which else each for i, each in layout.sensors.items()
    }
    return replace(layout, sensors=said)


def mapped(layout: Layout, **columns: str) -> Layout:
    return replace(layout, columns={**layout.columns, **columns})


def exchanged(layout: Layout) -> Layout:
    """The layout with the columns of both devices exchanged."""
    other = {"left": "right", "right": "left"}
    apart = {name: theirs.split("/") for name, theirs in layout.columns.items()}
    return mapped(layout, **{n: f"{other[device]}/{own}" for n, (device, own) in apart.items()})


def grips(layout: Layout, factor: float) -> Layout:
    return replace(layout, grips=tuple(map(tuple, factor * np.array(layout.grips))))


WRONG = {
    "frame": (
        lambda right: replace(right, frame="world", twist_frame="world"),
        "forces and torques are in the object frame: --frame object",
    ),
    "devices": (
        exchanged,
        "sensors 1 and 2 are taken one for the other: exchange their columns, --map f1x=left/Fx",
    ),
    "grips": (
        lambda right: replace(right, grips=right.grips[::-1]),
        "the grips of effectors 1 and 2 are exchanged: exchange them, grips = [[-900.0, 0.0, 0.0]",
    ),
    "metres of grips": (
        lambda right: grips(right, 1e-3),
        "grips are in m: grips = [[-900.0, 0.0, 0.0]",
    ),
    "lengths": (lambda right: replace(right, length="m"), "lengths are in mm: --length mm"),
    "reaction": (
        lambda right: sensors(right, sign=-1),
        "the reaction on sensors 1 and 2 is recorded: each sensor's table sign = 1",
    ),
    "one sign": (
        lambda right: mapped(right, f1y="-left/Fy_lbf"),
        "fy of sensor 1 has the other sign: turn it, --map fy=-fy",
    ),
    "axes": (
        lambda right: mapped(right, f1y="left/Fz_lbf", f1z="left/Fy_lbf"),
        "axes of forces of sensor 1 are exchanged (x is x, y is z, z is y of the file)",
    ),
    "rotation": (lambda right: sensors(right, rotation=None), "sensors 1 and 2 are turned by 30"),
    "offset": (
        lambda right: sensors(right, (1,), offset=()),
        "sensor 1 is beside the grip, which is [0.04",
    ),
    "tare": (
        lambda right: sensors(right, (1,), tare=None),
        "sensors have a bias, together of [4.9",
    ),
    "loads": (lambda right: sensors(right, load=None), "carry 0.40"),
    "load": (lambda right: sensors(right, (1,), load=None), "sensor 1 carries 0.4"),
    "units": (
        lambda right: replace(right, force="N", torque="N*m"),
        "forces are in lbf and torques are in lbf*in: --force lbf, --torque lbf*in",
    ),
    "force": (lambda right: replace(right, force="N"), "forces are in lbf: --force lbf"),
    "center": (lambda right: replace(right, pose=replace(right.pose, com=())), "com = [20, -29.9"),
    "order": (
        lambda right: replace(right, pose=replace(right.pose, order="wxyz")),
        'quaternions are x y z w: [pose] order = "xyzw"',
    ),
    "delay": (
        lambda right: replace(right, files={**right.files, "mocap": {}}),
        "late: [files.mocap] delay = 0.03",  # of 0.04: weights were taken off as late as the pose
    ),
}


def test_nothing_is_named_where_all_is_declared(laboratory):
    path, right = laboratory
    seen = check_file(path, layout=right).consistency
    assert not seen.warnings
    assert seen.balance is not None
    assert seen.balance.left < 1e-4


@pytest.mark.parametrize("left_out", WRONG)
def test_what_is_left_out_is_named(left_out, laboratory):
    path, right = laboratory
    wrong, says = WRONG[left_out]
    said = check_file(path, layout=wrong(right)).consistency.warnings[0]
    assert says in re.sub(r" \((left|right|mocap)\.csv\)", "", said)
