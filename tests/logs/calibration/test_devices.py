"""Devices with files of their own, of which sensors and pose are as laboratories have them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from coopenv.errors import InvalidInput
from coopenv.logs import Layout, analyse, check_file, read
from tests.logs import cases
from tests.logs.calibration import files, lab
from tests.logs.calibration.lab import declared, seen_in

MEASURES = ("internal_force_level", "internal_torque_level", "relative_cost")
POSE = files.POSE


def layout_file(folder: Path, **said: Any) -> Layout:
    (folder / "lab.json").write_text(json.dumps(said))
    return Layout.load(folder / "lab.json")


def as_it_was(seen: Any, columns: dict, folder: Path, **said: Any) -> Any:
    """The rows of the trial itself at the times of what was seen."""
    truth = seen_in(cases.save(columns, folder / "truth.npz"), **said)
    return truth.take(np.searchsorted(truth.time, seen.time - 1e-6))


def measures(seen: Any, truth: Any, every: int) -> dict[str, tuple[Any, Any]]:
    """F_I, T_I and γ of every so many rows, as they were found and as they are."""
    got, right = (analyse(each.take(slice(0, None, every))) for each in (seen, truth))
    return {name: (got[name], right[name]) for name in MEASURES}


@pytest.mark.parametrize("trial", [files.plane, files.space], ids=["plane", "space"])
def test_one_layout_gives_the_measures_of_sensors_and_a_slow_late_camera(trial, tmp_path):
    made = trial(tmp_path)
    seen: Any = read(made.path, layout_file(tmp_path, **made.said))
    truth = as_it_was(seen, made.columns, tmp_path, **made.truth)
    assert seen.good.all()
    assert len(seen) == made.rows  # up to the last picture
    np.testing.assert_allclose(seen.position, truth.position, atol=2e-4)
    if seen.orientation.ndim == 1:
        np.testing.assert_allclose(seen.orientation, truth.orientation, atol=1e-4)
    else:
        apart = (seen.orientation * truth.orientation).sum(axis=-1)
        np.testing.assert_allclose(np.abs(apart), 1.0, atol=1e-7)
    for name, (got, right) in measures(seen, truth, made.every).items():
        size = np.abs(right).max()
        assert size > 0.05
        np.testing.assert_allclose(got, right, atol=0.01 * size, err_msg=name)


@pytest.mark.parametrize("trial", [files.plane, files.space], ids=["plane", "space"])
def test_with_noise_on_every_file_the_measures_are_right_to_a_hundredth(trial, tmp_path):
    """In root mean square over the trial; of single samples nineteen in twenty, of the largest."""
    made = trial(tmp_path, noise=True)
    filters = {"wrench": 8.0, "pose": 6.0, "rate": 50.0}
    seen: Any = read(made.path, layout_file(tmp_path, **made.said, filters=filters))
    assert len(seen) == 300
    seen = seen.take(slice(10, -10))  # of the ends a filter knows one side
    truth = as_it_was(seen, made.columns, tmp_path, **made.truth)
    for name, (got, right) in measures(seen, truth, 1 if made.every < 100 else 5).items():
        wrong = np.abs(got - right)
        assert np.sqrt((wrong**2).mean() / (right**2).mean()) < 0.01, name
        assert np.percentile(wrong, 95) < 0.01 * right.max(), name


def beside(folder: Path, pose: dict, rows: int = 200, **columns: Any) -> Path:
    """A trial in the plane at 100 Hz, and a file of its pose beside it."""
    made = {n: each for n, each in cases.planar(rows).items() if n[0] in "ft"}
    del made["theta"]
    cases.save(pose, folder / "camera.csv")
    return cases.save(made | columns, folder / "forces.csv")


def test_angles_of_a_slow_camera_turn_the_shorter_way_between_its_pictures(tmp_path):
    """Of three Euler angles, two jump to the other side where one passes a right angle."""
    at = np.arange(41) * 0.05
    turn = Rotation.from_euler("z", 71 + 40 * at[:, None], degrees=True)
    angles = dict(zip("abc", turn.as_euler("XZY", degrees=True).T, strict=True))
    zero = {"x": 0 * at, "y": 0 * at}
    path = beside(tmp_path, {"time": at, **zero, **angles})
    pose = {"orientation": "euler", "columns": ["camera/a", "camera/b", "camera/c"]}
    seen = seen_in(
        path,
        grips=cases.BEAM,
        files={"camera": {"path": "camera.csv"}},
        pose=pose | {"order": "XZY"},
        angle="deg",
        frame="world",
    )
    wanted = np.radians(71 + 40 * seen.time)
    np.testing.assert_allclose(np.cos(seen.orientation - wanted), 1.0, atol=1e-12)
    assert len(seen) == 200


def test_gaps_in_an_orientation_that_is_written_otherwise_are_filled_evenly(tmp_path):
    columns = cases.spatial(101)
    turn = Rotation.from_rotvec(np.outer(columns["time"], [0.4, 1.0, -0.7]))
    for name in ("qw", "qx", "qy", "qz"):
        del columns[name]
    columns |= dict(zip(("a", "b", "c", "d"), turn.as_quat().T, strict=True))
    for name in "abc":
        columns[name][1::2] = np.nan
    pose = {"columns": list("abcd"), "order": "xyzw"}
    seen = seen_in(cases.save(columns, tmp_path / "a.npz"), pose=pose, fill="linear", frame="world")
    apart = (seen.orientation[:, [1, 2, 3, 0]] * turn.as_quat()).sum(axis=-1)
    np.testing.assert_allclose(apart, 1.0, atol=1e-12)
    assert seen.good.all()


def test_a_rest_at_the_beginning_is_found_on_the_clock_that_the_layout_names(tmp_path):
    """Though time has another name and unit, and a device beside it too."""
    at = np.arange(41) * 0.05
    ms = 1000 * (np.arange(200) * 0.01)
    path = beside(tmp_path, {"t": 1000 * at, "x": at, "y": at, "theta": at}, t=ms)
    text = path.read_text().replace("time,", "stamp,", 1)
    path.write_text(text)
    said: dict[str, Any] = {
        "grips": cases.BEAM,
        "columns": {"time": "t"},
        "time": "ms",
        "files": {"camera": {"path": "camera.csv"}},
    }
    bare = seen_in(path, **said)
    seen = seen_in(path, **said, sensors={"1": {"tare": {"first": 0.5}}})
    mean = bare.applied[:51, 0].mean(axis=0)
    np.testing.assert_allclose(seen.applied[:, 0], bare.applied[:, 0] - mean, atol=1e-12)
    np.testing.assert_array_equal(seen.applied[:, 1], bare.applied[:, 1])


def test_a_file_of_rest_is_not_joined_with_the_devices_of_the_trial(tmp_path):
    at = np.arange(41) * 0.05
    path = beside(tmp_path, {"time": at, "x": at, "y": at, "theta": at})
    rest = cases.planar(50, seed=1)
    zero = {name: rest[name] for name in ("time", "f1x", "f1y", "t1z", "f2x", "f2y", "t2z")}
    cases.save(zero, tmp_path / "zero.csv")
    said: dict[str, Any] = {"grips": cases.BEAM, "files": {"camera": {"path": "camera.csv"}}}
    tare = {"1": {"tare": {"file": str(tmp_path / "zero.csv")}}}
    with pytest.raises(InvalidInput, match=r"sensors\.1\.tare\.file must lie beside files of its"):
        seen_in(path, **said, sensors=tare)
    (tmp_path / "rest").mkdir()
    for name in ("zero.csv", "camera.csv"):
        (tmp_path / name).rename(tmp_path / "rest" / name)
    cases.save({"time": at, "x": at, "y": at, "theta": at}, tmp_path / "camera.csv")
    tare = {"1": {"tare": {"file": str(tmp_path / "rest" / "zero.csv")}}}
    bare, seen = seen_in(path, **said), seen_in(path, **said, sensors=tare)
    mean = [zero[name].mean() for name in ("f1x", "f1y", "t1z")]
    np.testing.assert_allclose(seen.applied[:, 0], bare.applied[:, 0] - mean, atol=1e-12)


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        (
            ["q0", "q1", "q2", "q9"],
            "pose.columns must be columns of one device, got q0, q1, q2, q9",
        ),
        (["q0", "q1", "q2", "q3"], "of forces and camera; write forces/q0 …"),
    ],
)
def test_columns_of_an_orientation_are_those_of_one_device(columns, says, tmp_path):
    at = np.arange(41) * 0.05
    both = {f"q{j}": 0 * at + (j == 3) for j in range(4)}
    more: dict[str, Any] = {name: np.resize(each, 200) for name, each in both.items()}
    path = beside(tmp_path, {"time": at, **both}, **more)
    pose = {"columns": columns, "order": "xyzw"}
    said = {"grips": cases.BEAM, "files": {"camera": {"path": "camera.csv"}}}
    with pytest.raises(InvalidInput, match=says):
        seen_in(path, **said, pose=pose)


def test_of_a_device_a_damaged_row_is_told_with_its_file_and_columns(tmp_path):
    at = np.arange(41) * 0.05
    quaternion = {f"q{j}": 0 * at + (j == 3) for j in range(4)}
    path = beside(tmp_path, {"time": at, **quaternion})
    said: dict[str, Any] = {"grips": cases.BEAM, "files": {"camera": {"path": "camera.csv"}}}
    said |= {"pose": {"columns": list(quaternion), "order": "xyzw"}, "frame": "world"}
    lines = (tmp_path / "camera.csv").read_text().splitlines()
    lines[7] = lines[7].replace(",1.0", ",up")
    (tmp_path / "camera.csv").write_text("\n".join(lines))
    says = r"camera\.csv, line 8, columns q0, q1, q2, q3, which make 'q?\w+', must be .* 0\.0, up'"
    with pytest.raises(InvalidInput, match=says):
        seen_in(path, **said)
    text = path.read_text().splitlines()
    path.write_text("\n".join([*text[:5], text[5] + ",7", *text[6:]]))
    said["files"] = {}
    with pytest.raises(InvalidInput, match=r"line 6 must have 7 fields like the header, got 8"):
        seen_in(path, grips=cases.BEAM)
    lines[7] = lines[6]
    (tmp_path / "camera.csv").write_text("\n".join(lines))
    said["files"] = {"camera": {"path": "camera.csv"}}
    with pytest.raises(InvalidInput, match=r"line 6 must have 7 fields like the header, got 8"):
        seen_in(path, **said)


def test_rows_with_the_time_of_the_row_before_are_shifted_and_checked_too(tmp_path):
    columns = dict(lab.spatial(2.0))
    for name in ("time", "qw", "qx", "qy", "qz", "x", "y", "z"):
        columns[name] = np.repeat(columns[name][::2], 2)  # each picture twice, the last one too
    path = cases.save(columns, tmp_path / "a.npz")
    with pytest.warns(UserWarning, match="1,000 rows of"):
        seen = seen_in(path, pose={"delay": 0.02})
    inside = seen.time < seen.time[-1] - 0.02 - 1e-9
    assert np.isfinite(seen.orientation[inside]).all()
    assert seen.good[inside].all()
    body = {"mass": 7.7, "inertia": [0.3, 2.0, 2.2]}
    checked = check_file(path, layout=declared(body=body))
    assert "1,000 rows of" in checked.lines()[1]
    assert checked.consistency.balance is not None


def test_a_late_pose_is_put_right_by_its_device_or_after_joining_and_by_both_in_turn(tmp_path):
    at = np.arange(41) * 0.05
    path = beside(tmp_path, {"time": at, "x": 3 * at, "y": -at, "theta": 0.5 * at})

    def position(device: float, pose: float) -> Any:
        files = {"camera": {"path": "camera.csv", "delay": device}}
        seen = seen_in(path, grips=cases.BEAM, files=files, pose={"delay": pose})
        return seen.time[seen.good], seen.position[seen.good][:, 0]

    for device, pose in ((0.04, 0.0), (0.0, 0.04), (0.03, 0.01)):
        time, x = position(device, pose)
        np.testing.assert_allclose(x, 3 * (time + 0.04), atol=1e-12)
        assert len(time) >= 195
    files = {"camera": {"path": "camera.csv", "delay": 0.04}}
    said: dict[str, Any] = {"grips": cases.BEAM, "frame": "world", "files": files}
    turned = seen_in(path, **said)
    np.testing.assert_allclose(turned.orientation, 0.5 * (turned.time + 0.04), atol=1e-12)
    told = check_file(path, layout=declared(**said)).lines()
    assert "delay: times of camera taken 0.04 s earlier" in told


def test_how_much_is_read_at_once_matters_to_joined_and_corrected_rows_no_more(
    tmp_path, monkeypatch
):
    at = np.arange(41) * 0.05
    turn = Rotation.from_euler("z", 2 * at[:, None])
    camera = {"time": at, "x": np.sin(3 * at), "y": np.cos(2 * at)}
    camera |= dict(zip(("q0", "q1", "q2", "q3"), turn.as_quat().T, strict=True))
    path = beside(tmp_path, camera)
    load = {"mass": 0.3, "center": [0.0, 0.05], "window": 0.06}
    said: dict[str, Any] = {
        "grips": cases.BEAM,
        "files": {"camera": {"path": "camera.csv", "delay": 0.02}},
        "pose": POSE | {"delay": 0.015},
        "sensors": {"1": {"rotation": 0.4, "load": load, "tare": {"first": 0.3}}},
        "filters": {"wrench": 12.0, "rate": 37.0},
        "body": {"gravity": [0.0, -9.81]},
    }
    whole = seen_in(path, **said)
    cases.set_chunk(13, monkeypatch)
    parts = seen_in(path, **said)
    for name in ("time", "applied", "position", "orientation", "good"):
        one, other = getattr(parts, name), getattr(whole, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9, err_msg=name)
