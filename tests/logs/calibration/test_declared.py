"""A layout's tables on sensors, pose, filters and body: wrong keys and values are named."""

import json
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pyarrow")

from coopenv import cli
from coopenv.errors import CoopenvError
from coopenv.logs import Layout, decompose_file, read
from tests.logs import cases
from tests.logs.calibration.lab import declared

BEAM = [-0.9, 0.1, 0.9, -0.2]


def _read(*path: Any, **said: Any) -> Any:
    return read(*path, **said)


@pytest.mark.parametrize(
    ("toml", "says"),
    [
        ("[sensors.1]\nrotatoin = 30", "key of sensors.1 must be one of the known names"),
        ("[sensors.0]\nsign = -1", "sensors must be named by the number of their effector"),
        ("[sensors.left]\nsign = -1", "got 'left'; write [sensors.1]"),
        ("[sensors.3]\nsign = -1", "must be those of the 2 effectors, got sensors.3"),
        ("[sensors]\n1 = 30", "sensors.1 must be a table, got 30"),
        ("[sensors.1]\nsign = 2", "sensors.1.sign must be 1 or -1, got 2"),
        ('[sensors.1]\nrotation = "30"', "sensors.1.rotation must be a number, got '30'"),
        ("[sensors.1]\nrotation = [[1, 0], [0, -1]]", "sensors.1.rotation must be right-handed"),
        ("[sensors.1]\nrotation = [[1, 1], [0, -1]]", "sensors.1.rotation must be a rotation"),
        ("[sensors.1.rotation]\neuler = [0, 0, 30]", "sensors.1.rotation.order must be three axes"),
        ('[sensors.1.rotation]\neuler = [0, 0, 3]\norder = "ZZX"', "order must be three axes"),
        ("[sensors.1.rotation]\nquaternion = [0.8, 0.6, 0, 0]", "sensors.1.rotation is of all six"),
        ("[sensors.1.rotation]\nquaternion = [1, 1, 0, 0]", "quaternion must be of unit length"),
        ("[sensors.1]\noffset = 0.05", "sensors.1.offset must be 2 or 3 numbers, got 0.05"),
        ("[sensors.1]\noffset = [0, 0, 1]", "sensors.1.offset must be 2 numbers here, got 3"),
        ("[sensors.1]\noffset = [nan, 1]", "sensors.1.offset must be finite"),
        ("[sensors.1]\ntare = [1, 2, 3, 4, 5, 6]", "sensors.1.tare is of all six axes, which are"),
        ("[sensors.1.tare]\nfirst = 1\nfile = 'a.npz'", "tare must have one of first, rests and"),
        ("[sensors.1.tare]\nfirst = -1", "sensors.1.tare.first must be positive, got -1"),
        ("[sensors.1.tare]\nrests = [[1, 0]]", "sensors.1.tare.rests must be one or two rests"),
        ("[sensors.1.tare]\nrests = [[0, 1], [0.5, 2]]", "tare.rests must be one or two rests"),
        ("[sensors.1.tare]\nrests = [[50, 60]]", "sensors.1.tare must be a rest with good rows"),
        ("[sensors.1.tare]\nfile = 'no.npz'", "no.npz"),
        ("[sensors.1]\ncross_talk = [[1, 0], [0, 1]]", "cross_talk must be a matrix of 3 by 3 or"),
        ("[sensors.1.load]\ncenter = [0, 0]", "sensors.1.load must have its keys, got center"),
        ("[sensors.1.load]\nmass = -1", "sensors.1.load.mass must be zero or positive, got -1"),
        ("[sensors.1.load]\nmass = 1\ninertia = 0.1", "load.window must be said where"),
        ('[sensors.1.load]\nmass = 1\nside = "arm"', "load.side must be one of the known"),
        ('[pose]\norientation = "matrix"', "pose.columns must name the 9 columns of a matrix"),
        ('[pose]\norientation = "euler"\ncolumns = ["a"]', "pose.order must be three axes"),
        ('[pose]\ncolumns = ["a", "b", "c", "d"]', "pose.columns must be columns of the file"),
        ("[pose]\ncom = [0, 0, 1]", "pose.com must be 2 numbers here, got 3"),
        ("[pose]\ndelay = 20", "pose.delay must be at most 10"),
        ('frame = "world"\n[pose]\ndelay = 0.1', "pose.delay must be left out where something is"),
        ("[filters]\nwrench = 0", "filters.wrench must be positive, got 0"),
        ("[filters]\nwrench = 60", "cutoff must be below half the rate of 100 Hz, got 60 Hz"),
        ("[filters]\norder = 1.5", "filters.order must be a whole number"),
        ("[filters]\ntwist_window = 0.1", "filters.twist_window must be left out where"),
        ("[body]\nmass = 3", "body must have both mass and inertia or none of them"),
        ("[body]\nmass = 3\ninertia = [1, 2]", "body.inertia must be a number in the plane"),
        ("[body]\nmass = 3\ninertia = [1, 2, 3]", "body.inertia must be a number in the plane"),
        ("[body]\ngravity = [0, 0, -9.8]", "body.gravity must be 2 numbers here, got 3"),
        ("[body]\nmass = 3\ninertia = 1\ndrag = [-1, 0]", "body.drag must not be negative"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_table_is_said_in_one_line_with_its_key(toml, says, tmp_path, capsys):
    path = cases.save(cases.planar(60), tmp_path / "trial.npz")
    top, bracket, rest = toml.partition("[")
    (tmp_path / "lab.toml").write_text(f"grips = {BEAM}\n{top}\n{bracket}{rest}\n")
    there = sorted(each.name for each in tmp_path.iterdir())
    assert cli.main(["decompose", str(path), "--layout", str(tmp_path / "lab.toml")]) == 1
    printed = capsys.readouterr().err
    assert says in printed
    assert printed.count("\n") == 1
    assert sorted(each.name for each in tmp_path.iterdir()) == there


def test_a_wrong_value_names_the_file_too(tmp_path):
    (tmp_path / "lab.toml").write_text("[sensors.2]\nsign = 0\n")
    with pytest.raises(CoopenvError, match=r"lab.toml: sensors.2.sign must be 1 or -1"):
        Layout.load(tmp_path / "lab.toml")


def test_a_correction_without_its_columns_asks_for_them(tmp_path):
    bare = {name: each for name, each in cases.planar().items() if name[0] in "ft"}
    bare.pop("theta")
    path = cases.save(bare | {"time": np.arange(40.0)}, tmp_path / "a.npz")
    for said, column in (
        ({"sensors": {1: {"load": {"mass": 1.0}}}, "body": {"gravity": [0, -9.8]}}, "theta"),
        ({"filters": {"pose": 0.1}}, "x"),
        ({"pose": {"delay": 0.1}}, "pose.delay must be left out"),
    ):
        with pytest.raises(CoopenvError, match=f"column {column} must be there|{column}"):
            _read(path, declared(grips=BEAM, **said))
    path = cases.save({n: bare[n] for n in bare if n != "time"}, tmp_path / "b.npz")
    with pytest.raises(CoopenvError, match="column time must be there"):
        _read(path, declared(grips=BEAM, filters={"wrench": 5.0}))


ORIENTED = ("quaternion", "matrix", "euler", "rotation_vector")


@pytest.mark.parametrize("kind", ORIENTED)
@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_orientations_are_read_from_columns_of_any_convention(kind, suffix, tmp_path):
    columns = cases.spatial()
    wanted = _read(cases.save(columns, tmp_path / f"a{suffix}"), declared(frame="world"))
    xyzw = np.stack([columns.pop(f"q{axis}") for axis in "xyzw"], axis=-1)
    turn = Rotation.from_quat(xyzw)
    values, order = {
        "quaternion": (xyzw, "xyzw"),
        "matrix": (turn.as_matrix().reshape(-1, 9), "rows"),
        "euler": (turn.as_euler("ZYX", degrees=True), "ZYX"),
        "rotation_vector": (turn.as_rotvec(degrees=True), None),
    }[kind]
    names = [f"o{j}" for j in range(values.shape[1])]
    columns |= dict(zip(names, values.T, strict=True))
    said = {"frame": "world", "angle": "deg", "angular_velocity": "rad/s"}
    pose = {"orientation": kind, "columns": names} | ({"order": order} if order else {})
    path = cases.save(columns, tmp_path / f"b{suffix}")
    seen = _read(path, declared(**said, pose=pose))
    np.testing.assert_allclose(seen.applied, wanted.applied, rtol=0, atol=1e-12)
    assert not seen.carried
    columns["o1"] = columns["o1"].copy()
    columns["o1"][2] = np.nan
    path = cases.save(columns, tmp_path / f"c{suffix}")
    with pytest.raises(CoopenvError, match=r"(line 4|row 3), columns o0, o1, .*make 'q[wy]', must"):
        _read(path, declared(**said, pose=pose))


def test_a_block_of_poses_may_have_w_last(tmp_path):
    columns = cases.spatial()
    wanted = _read(cases.save(columns, tmp_path / "a.npz"), declared(frame="world"))
    names = ("x", "y", "z", "qx", "qy", "qz", "qw")
    rest = {name: each for name, each in columns.items() if name not in names}
    pose = np.stack([columns[name] for name in names], axis=-1)
    np.savez(tmp_path / "b.npz", pose=pose, **rest)
    seen = _read(tmp_path / "b.npz", declared(frame="world", pose={"order": "xyzw"}))
    np.testing.assert_allclose(seen.applied, wanted.applied, rtol=0, atol=1e-12)


def test_a_spatial_orientation_serves_a_planar_task(tmp_path):
    columns = cases.planar()
    wanted = _read(cases.save(columns, tmp_path / "a.npz"), declared(frame="world", grips=BEAM))
    theta = columns.pop("theta")
    turned = Rotation.from_euler("z", theta[:, None]).as_quat()
    columns |= dict(zip(("a", "b", "c", "d"), turned.T, strict=True))
    pose = {"columns": ["a", "b", "c", "d"], "order": "xyzw"}
    path = cases.save(columns, tmp_path / "b.npz")
    seen = _read(path, declared(frame="world", grips=BEAM, pose=pose))
    np.testing.assert_allclose(seen.applied, wanted.applied, rtol=0, atol=1e-12)


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_the_table_and_its_summary_say_what_was_done(suffix, tmp_path):
    path = cases.save(cases.planar(), tmp_path / f"a{suffix}")
    out = tmp_path / f"out{suffix}"
    layout = declared(grips=BEAM, sensors={1: {"sign": -1}}, filters={"wrench": 20.0})
    summary = decompose_file(path, out, layout=layout, picture=False)
    assert summary.done[0] == "sensor 1: sign turned"
    assert "Butterworth of order 2 at 20 Hz" in summary.done[1]
    assert json.loads(summary.written.read_text())["done"] == list(summary.done)
    said = None
    if suffix == ".npz":
        with np.load(out) as table:
            said = json.loads(str(table["corrections"]))
    if suffix == ".parquet":
        from pyarrow import parquet

        said = json.loads(parquet.read_metadata(out).metadata[b"corrections"])
    assert said in (None, list(summary.done))
    assert (said is None) == (suffix == ".csv")
    again = _read(out, declared())  # a table is a recording
    np.testing.assert_array_equal(again.applied[:, 1], _read(path, layout).applied[:, 1])


def test_what_is_not_asked_for_changes_nothing(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.npz")
    seen = _read(path, declared(grips=BEAM))
    assert seen.done == ()
    np.testing.assert_array_equal(seen.applied, cases.wrench(cases.planar()))
    summary = decompose_file(path, layout=declared(grips=BEAM), picture=False)
    with np.load(summary.table) as table:
        assert "corrections" not in table
