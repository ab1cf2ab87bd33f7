"""With a known body, what was left out of the layout of a laboratory is named."""

import json
from typing import Any

import numpy as np
import pytest

from coopenv import cli
from coopenv.logs import check_file
from tests.logs import cases, motions
from tests.logs.calibration import lab

PLANE = {"mass": 7.7, "inertia": 2.5730833333333334, "drag": (8.0, 8.0)}  # the environment's
SPACE = {"mass": motions.MASS, "inertia": (0.3, 2.0, 2.2), "gravity": (0.0, 0.0, -9.81)}
SPATIAL = ("rotation", "offset", "bias", "handle", "order", "units", "delay")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("known")
    plane = cases.save(lab.written_in_the_plane(), folder / "plane.npz")
    space = cases.save(lab.written_in_space(*SPATIAL), folder / "space.npz")
    return plane, space


def balance(path, body, said) -> Any:
    return check_file(path, layout=lab.declared(**said, body=body)).consistency


def test_a_laboratory_that_declares_everything_is_found_right(files):
    plane = balance(files[0], PLANE, lab.layout_in_the_plane())
    space = balance(files[1], SPACE, lab.layout_in_space(*SPATIAL))
    for seen, names in ((plane, "fx fy tz"), (space, "fx fy fz tx ty tz")):
        assert seen.balance.left < 1e-4
        assert not seen.balance.explanations
        assert not seen.warnings
        assert abs(seen.balance.delay) < 0.002
        assert " ".join(axis.name for axis in seen.balance.axes) == names
        for axis in seen.balance.axes:
            assert axis.r2 > 0.999
            assert abs(axis.gain - 1) < 0.01
            assert abs(axis.bias) < 0.01 * axis.size


@pytest.mark.parametrize(
    ("without", "kind", "says"),
    [
        ("sign", "sign", "the reaction on sensors 1 and 2 is recorded: each sensor's table sign"),
        ("rotation", "rotation", "turned by 30° and 30°: [sensors.1] rotation = 30"),
        ("offset", "offset", "[sensors.1] offset = [0.05"),
        ("tare", "bias", "take it off, [sensors.1] tare"),
        ("delay", "delay", "[pose] delay = 0.04"),
        ("units", "units", "forces are in lbf and torques are in lbf*in: --force lbf"),
        ("degrees", "angle", "theta is in deg: --angle deg"),
        ("grips", "grips", "the grips of effectors 1 and 2 are exchanged"),
    ],
)
def test_what_is_left_out_in_the_plane_is_named(without, kind, says, files):
    seen = balance(files[0], PLANE, lab.layout_in_the_plane(without))
    assert seen.balance.explanations[0].kind == kind
    assert says in seen.warnings[0]
    assert seen.balance.explanations[0].left < 0.25 * seen.balance.left


@pytest.mark.parametrize(
    ("without", "kind", "says"),
    [
        ("rotation", "rotation", "are turned by 6"),
        ("offset", "offset", "[sensors.1] offset = [0.0499, "),
        ("bias", "bias", "together of [0.724, 1.02, -2.73] N"),
        ("handle", "load", "carry together 0.8 kg on the hand's side"),
        ("order", "order", 'quaternions are x y z w: [pose] order = "xyzw"'),
        ("units", "units", "--force lbf, --torque lbf*in"),
        ("delay", "delay", "[pose] delay = 0.038"),
    ],
)
def test_what_is_left_out_in_space_is_named(without, kind, says, files):
    said = lab.layout_in_space(*(habit for habit in SPATIAL if habit != without))
    if without == "rotation":
        said["angle"] = "deg"
    if without == "order":  # by name, as of a file whose columns are called so
        said["columns"] = {f"q{axis}": f"q{j}" for j, axis in enumerate("wxyz")}
    if without == "units":  # the numbers of the bias are the file's
        unit = np.repeat([lab.POUND, lab.POUND * 0.0254], 3)
        for i, sensor in enumerate(said["sensors"].values()):
            sensor["tare"] = (lab.BIAS_SPACE[i] / unit).tolist()
    seen = balance(files[1], SPACE, said)
    assert seen.balance.explanations[0].kind == kind
    assert says in seen.warnings[0]


@pytest.mark.parametrize("seed", range(2))
def test_a_wrong_sign_and_exchanged_axes_of_one_sensor_are_named_in_spite_of_noise(seed, tmp_path):
    body = {"mass": motions.MASS, "inertia": motions.INERTIA, "drag": (2.0, 0.3)}
    columns = motions.planar(seed)
    right = balance(cases.save(columns, tmp_path / "a.npz"), body, {"grips": motions.BEAM,
                    "twist_frame": "world"})  # fmt: skip
    assert not right.balance.explanations
    assert right.balance.left < 0.002
    turned = columns | {"f2y": -columns["f2y"]}
    seen = balance(cases.save(turned, tmp_path / "b.npz"), body, {"grips": motions.BEAM,
                   "twist_frame": "world"})  # fmt: skip
    assert "fy of sensor 2 has the other sign" in seen.warnings[0]
    columns = motions.spatial(seed)
    columns["f1y"], columns["f1z"] = columns["f1z"], columns["f1y"]
    seen = balance(cases.save(columns, tmp_path / "c.npz"), SPACE, {})
    assert "axes of forces of sensor 1 are exchanged (x is x, y is z, z is y" in seen.warnings[0]


def test_what_no_usual_mistake_explains_is_said_so(tmp_path):
    body = {"mass": motions.MASS, "inertia": motions.INERTIA}
    another = motions.planar(1)
    columns = motions.planar(0) | {name: another[name] for name in ("x", "y", "theta")}
    columns = {name: each for name, each in columns.items() if name[0] not in "vo"}
    seen = balance(cases.save(columns, tmp_path / "a.npz"), body, {"grips": motions.BEAM})
    assert "none of the usual mistakes alone would do so" in seen.warnings[0]


def test_a_body_that_does_not_move_tells_nothing(tmp_path):
    columns = cases.planar(1000)
    columns |= {name: np.zeros(1000) for name in ("x", "y", "theta")}
    seen = balance(cases.save(columns, tmp_path / "a.npz"), PLANE, {"grips": cases.BEAM})
    assert seen.balance.unchecked == "it hardly moves"


def test_check_only_compares_and_writes_nothing(files, tmp_path, capsys):
    pytest.importorskip("tyro")
    said = lab.layout_in_the_plane("rotation") | {"body": PLANE}
    (tmp_path / "lab.json").write_text(json.dumps(said))
    path = files[0]
    before = sorted(each.name for each in path.parent.iterdir())
    assert (
        cli.main(["decompose", str(path), "--check", "--layout", str(tmp_path / "lab.json")]) == 0
    )
    printed = " ".join(capsys.readouterr().out.split())
    for words in ("6,000 rows", "assumed grips", "corrected delay",
                  "for 40 rows at ends of trials no pose came", "known body, fx: r² 0.",
                  "turned by 30° and 30°"):  # fmt: skip
        assert words in printed
    assert sorted(each.name for each in path.parent.iterdir()) == before
