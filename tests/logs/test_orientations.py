"""Orientations written in another order, by columns of other names, are read once and rightly."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from coopenv.errors import InvalidInput
from coopenv.logs import Layout, read
from tests.logs import cases, motions

ROTATED = ("qw", "qx", "qy", "qz")
LAST = ("qx", "qy", "qz", "qw")  # the order of ROS and of SciPy


def orientation(path: Path, layout: Layout) -> Any:
    """Quaternions w, x, y, z of a file."""
    return read(path, layout).orientation


def laid(**said: Any) -> Layout:
    return Layout(**said)


@pytest.fixture(scope="module")
def trial():
    columns = motions.spatial(1, rate=50, duration=2, noise=0)
    return {name: each for name, each in columns.items() if name[0] not in "vo"}


def called(trial, names) -> dict[str, Any]:
    """The trial with x y z w under these names."""
    rest = {name: each for name, each in trial.items() if name not in ROTATED}
    return rest | {name: trial[own] for name, own in zip(names, LAST, strict=True)}


NUMBERED = {name: f"q{k}" for k, name in enumerate(ROTATED)}  # which by themselves say w x y z


def test_an_order_is_that_of_the_columns_that_are_mapped(trial, tmp_path):
    path = cases.save(called(trial, [f"q{k}" for k in range(4)]), tmp_path / "a.npz")
    found = orientation(path, laid(columns=NUMBERED, pose={"order": "xyzw"}))
    np.testing.assert_allclose(found[:, 0], trial["qw"])
    same = orientation(path, laid(pose={"columns": ["q0", "q1", "q2", "q3"], "order": "xyzw"}))
    np.testing.assert_array_equal(found, same)


def test_an_order_is_that_of_documented_names_if_none_are_mapped(trial, tmp_path):
    path = cases.save(called(trial, ROTATED), tmp_path / "a.npz")
    found = orientation(path, laid(pose={"order": "xyzw"}))
    np.testing.assert_allclose(found[:, 3], trial["qz"])


def test_a_column_that_is_not_mapped_does_not_take_its_place(trial, tmp_path):
    columns = called(trial, [f"q{k}" for k in range(4)]) | {"qw": np.full(100, 7.0)}
    found = orientation(
        cases.save(columns, tmp_path / "a.npz"), laid(columns=NUMBERED, pose={"order": "xyzw"})
    )
    np.testing.assert_allclose(found[:, 0], trial["qw"])


def test_columns_of_the_pose_take_the_place_of_documented_ones(trial, tmp_path):
    columns = called(trial, [f"q{k}" for k in range(4)])
    columns |= {name: np.full(100, 0.5) for name in ROTATED}
    pose = {"columns": ["q0", "q1", "q2", "q3"], "order": "xyzw"}
    path = cases.save(columns, tmp_path / "a.npz")
    for left_out in ({}, {"qw": ""}):
        found = orientation(path, laid(columns=left_out, pose=pose))
        np.testing.assert_allclose(found[:, 0], trial["qw"])


def test_a_minus_turns_the_sign_of_a_part(trial, tmp_path):
    columns = called(trial, [f"q{k}" for k in range(4)])
    columns["q2"] = -columns["q2"]
    path = cases.save(columns, tmp_path / "a.npz")
    found = orientation(path, laid(columns={**NUMBERED, "qy": "-q2"}, pose={"order": "xyzw"}))
    np.testing.assert_allclose(found, np.stack([trial[n] for n in ROTATED], -1))


def test_mapped_columns_of_a_device_have_their_order_too(trial, tmp_path):
    motion = called({n: trial[n] for n in ("time", *ROTATED)}, [f"q{k}" for k in range(4)])
    cases.save(motion, tmp_path / "mocap.npz")
    rest = {name: each for name, each in trial.items() if name not in ROTATED}
    path = cases.save(rest | {"q0": np.zeros(100)}, tmp_path / "sensors.npz")
    names = {name: f"mocap/{theirs}" for name, theirs in NUMBERED.items()}
    said = {"files": {"mocap": {"path": "mocap.npz"}}, "pose": {"order": "xyzw"}}
    found = orientation(path, laid(columns=names, **said))
    np.testing.assert_allclose(found[:, 0], trial["qw"])
    turned = {**names, "qy": "-mocap/q2"}
    found = orientation(path, laid(columns=turned, **said))
    np.testing.assert_allclose(found[:, 3], -trial["qz"])
    with pytest.raises(InvalidInput, match=r"pose.order is, must be columns of one device, got"):
        read(path, laid(columns={**names, "qw": "q9"}, **said))


@pytest.mark.parametrize(
    ("said", "says"),
    [
        (
            {"columns": NUMBERED, "pose": {"columns": list("abcd")}},
            r"pose.columns must be left out where columns say which is qw, got .* and 'q0'; name",
        ),
        (
            {"columns": {"theta": "yaw"}, "pose": {"columns": list("abcd")}},
            r"columns say which is theta, got .* and 'yaw'",
        ),
        (
            {"columns": {"qw": ""}, "pose": {"order": "xyzw"}},
            r"pose.order must be left out where columns say that there is no qw, got 'xyzw'; name",
        ),
    ],
)
def test_an_orientation_is_said_once(said, says):
    with pytest.raises(InvalidInput, match=says):
        laid(**said)


@pytest.mark.parametrize("apart", [False, True], ids=["one file", "of a device"])
def test_a_column_of_the_pose_that_is_mapped_too_is_told_so(apart, trial, tmp_path):
    columns = called(trial, [f"q{k}" for k in range(4)])
    said: dict[str, Any] = {"pose": {"columns": ["q0", "q1", "q2", "q3"], "order": "xyzw"}}
    if apart:
        moved = {name: columns.pop(name) for name in ("q0", "q1", "q2", "q3", "x", "y", "z")}
        cases.save({"time": columns["time"]} | moved, tmp_path / "camera.npz")
        said |= {"files": {"camera": {"path": "camera.npz"}}}
        said["pose"]["columns"] = [f"camera/q{k}" for k in range(4)]
    path = cases.save(columns, tmp_path / "a.npz")
    says = (
        r"a.npz: z must be mapped to a column that \[pose\] columns do not name, got 'q2', of which"
    )
    with pytest.raises(InvalidInput, match=says):
        read(path, laid(**said, columns={"z": "q2"}))


def test_an_order_of_columns_that_are_not_there_is_refused(tmp_path):
    path = cases.save(cases.planar(3), tmp_path / "a.npz")
    with pytest.raises(InvalidInput, match=r"qw, qx, qy and qz, of which pose.order is, must be"):
        read(path, laid(grips=cases.BEAM, pose={"order": "xyzw"}))


@pytest.mark.parametrize("lost", [0.0, 3.0])
def test_an_orientation_that_is_none_is_a_bad_row_in_the_plane_too(lost, tmp_path):
    columns = dict(cases.planar(6))
    turn = columns.pop("theta")
    names = ("a", "b", "c", "d")
    quaternion = np.stack([np.cos(turn / 2), 0 * turn, 0 * turn, np.sin(turn / 2)])
    quaternion[:, 2] = [lost, 0.0, 0.0, 0.0]
    path = cases.save(columns | dict(zip(names, quaternion, strict=True)), tmp_path / "a.csv")
    said: Any = {"grips": cases.BEAM, "pose": {"columns": list(names)}, "frame": "world"}
    with pytest.raises(InvalidInput, match=r"line 4.* must be a quaternion of unit length"):
        read(path, Layout(**said))
    found = read(path, Layout(**said), bad_rows="skip")
    assert found.good.tolist() == [True, True, False, True, True, True]
