"""Files of several devices become one recording on time, and gaps between samples are filled."""

import tracemalloc
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation, Slerp

pytest.importorskip("pyarrow")

from coopenv.errors import CoopenvError, InvalidInput
from coopenv.logs import Layout, decompose_file, formats, read
from coopenv.logs.joining.between import interpolated, neighbours, slerped
from coopenv.logs.recording import Reader
from tests.logs import cases
from tests.logs.kinds import recorded, text

ONE = (0.0, 0.0)
NAN = np.nan


def save(path, content):
    path.write_text(content)
    return path


def devices(folder, left=None, right=None, motion=None):
    """Files of a motion and two sensors, each of time stamps."""
    columns = recorded()
    for name, given, names in (
        ("left", left, ("f1x", "f1y", "t1z")),
        ("right", right, ("f2x", "f2y", "t2z")),
    ):
        time = columns["time"] if given is None else np.array(given)
        save(folder / f"{name}.csv", text({"time": time} | {n: 100 * time for n in names}))
    time = columns["time"] if motion is None else np.array(motion)
    return save(folder / "motion.csv", text({"time": time, "mark": np.arange(len(time))}))


def seconds(recording):
    """Times of a recording that has them."""
    assert recording.time is not None
    return recording.time


def joined(path, *, bad_rows="error", left=None, right=None, **said: Any):
    files = {
        "left": {"path": "left.csv", **(left or {})},
        "right": {"path": "right.csv", **(right or {})},
    }
    return read(path, Layout(grips=cases.BEAM, files=files, **said), bad_rows=bad_rows)


@pytest.mark.parametrize(
    ("method", "at", "wanted"),
    [
        ("linear", [0.0, 0.25, 1.0, 1.5, 4.0, -0.1, 4.1], [0, 2.5, 10, NAN, 40, NAN, NAN]),
        ("nearest", [0.4, 0.6, 1.9, 2.6, 4.4, -0.4, 5.1], [0, 10, 10, 40, 40, 0, NAN]),
        ("previous", [0.9, 1.0, 1.9, 2.1, 4.9, -0.1], [0, 10, 10, NAN, 40, NAN]),
    ],
)
def test_between_samples_the_method_says_what_is_there_up_to_the_gap(method, at, wanted):
    time, values = np.array([0.0, 1.0, 4.0]), np.array([0.0, 10.0, 40.0])
    gap = 1.5 if method == "nearest" else 1.0
    if method == "nearest":
        wanted[-1] = 40.0
    found = interpolated(time, values, np.array(at), method, gap)
    np.testing.assert_allclose(found, wanted)


def test_a_sample_that_says_nothing_is_none():
    time, values = np.arange(4.0), np.array([0.0, NAN, 20.0, 30.0])
    assert interpolated(time, values, np.array([1.0]), "linear", 2.0) == [10.0]
    assert np.isnan(interpolated(time, values, np.array([1.0]), "linear", 1.0))
    assert np.isnan(interpolated(time[:0], values[:0], np.array([1.0]), "linear", 1.0)).all()
    assert not neighbours(time[:0], time, "nearest", 1.0).near.any()


def test_angles_go_the_shorter_way_round():
    time, angle = np.array([0.0, 1.0]), np.array([3.0, -3.0])
    found = interpolated(time, angle, np.array([0.5]), "linear", 1.0, period=2 * np.pi)
    assert found == pytest.approx([np.pi])
    degrees = interpolated(time, np.array([170.0, -170.0]), np.array([0.25]), "linear", 1.0, 360.0)
    assert degrees == pytest.approx([175.0])


def test_quaternions_turn_as_slerp_does():
    rng = np.random.default_rng(0)
    time, at = np.arange(6.0), np.linspace(0.0, 5.0, 23)
    rotations = Rotation.from_quat(rng.normal(size=(6, 4)))
    quaternions = rotations.as_quat()[:, [3, 0, 1, 2]]
    quaternions[::2] *= -1  # the same orientations
    found = slerped(time, quaternions, at, "linear", 1.0)
    wanted = Slerp(time, rotations)(at)
    turned = Rotation.from_quat(found[:, [1, 2, 3, 0]])
    assert (turned * wanted.inv()).magnitude().max() < 1e-7
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)
    same = slerped(time[:2], quaternions[[0, 0]], np.array([0.3]), "linear", 1.0)
    np.testing.assert_allclose(same, quaternions[:1])


def test_units_that_the_file_of_one_device_says_are_of_its_columns_alone(tmp_path):
    path = devices(tmp_path)
    head, *rows = (tmp_path / "left.csv").read_text().splitlines()
    save(tmp_path / "left.csv", "\n".join([head, "s,kN,kN,N-mm", *rows]))
    found = joined(path, left={"units_row": True})
    for own, scale in ((0, [1e5, 1e5, 0.1]), (1, [100.0, 100.0, 100.0])):
        np.testing.assert_allclose(found.applied[:, own], np.outer(seconds(found), scale))


def test_rows_are_those_of_the_clock_where_all_have_samples(tmp_path):
    path = devices(tmp_path, left=np.arange(20) / 250, right=np.arange(-4, 12) / 200)
    found = joined(path)
    assert found.carried["mark"].tolist() == [0, 1, 2, 3, 4, 5]  # right ends at 0.055 s
    np.testing.assert_allclose(found.applied[:, 0, 0], 100 * seconds(found))
    np.testing.assert_allclose(found.applied[:, 1, 2], 100 * seconds(found))
    on_right = joined(path, clock="right")
    np.testing.assert_allclose(seconds(on_right), np.arange(12) / 200)
    at_rate = joined(path, join_rate=1000.0)
    np.testing.assert_allclose(seconds(at_rate), np.arange(56) / 1000)
    np.testing.assert_allclose(at_rate.applied[:, 1, 0], 100 * seconds(at_rate))


def test_what_a_device_stamps_late_is_taken_back(tmp_path):
    path = devices(tmp_path, right=0.5 + np.arange(8) / 100)
    found = joined(path, right={"delay": 0.5})
    np.testing.assert_allclose(found.applied[:, 1, 0], 50 + found.applied[:, 0, 0])


def test_a_gap_beyond_the_longest_is_a_bad_row(tmp_path):
    time = np.delete(np.arange(8) / 100, [3, 4])
    path = devices(tmp_path, left=time)
    assert joined(path, longest_gap=0.031).good.all()
    with pytest.raises(InvalidInput, match=r"line 5, column 'f1x' .* got 'no sample of left that"):
        joined(path, longest_gap=0.02)
    found = joined(path, longest_gap=0.02, bad_rows="skip")
    assert found.good.tolist() == [True] * 3 + [False] * 2 + [True] * 3


def test_however_many_rows_are_read_at_once_the_same_comes_of_it(tmp_path, monkeypatch):
    rng = np.random.default_rng(3)
    left, right = (np.sort(rng.uniform(-0.1, 1.1, 400)).round(4) for _ in range(2))
    path = devices(
        tmp_path, left=np.unique(left), right=np.unique(right), motion=np.arange(100) / 100
    )
    ways: tuple[dict[str, Any], ...] = (
        {},
        {"join_rate": 333.0},
        {"clock": "left", "join_method": "nearest"},
    )
    for said in ways:
        whole = joined(path, **said)
        with monkeypatch.context() as patch:
            patch.setattr("coopenv.logs.formats.text.BLOCK", 200)
            patch.setattr("coopenv.logs.joining.source.CHUNK_ROWS", 7)
            pieces = joined(path, **said)
        np.testing.assert_array_equal(pieces.time, whole.time)
        np.testing.assert_array_equal(pieces.applied, whole.applied)
        np.testing.assert_array_equal(pieces.carried["mark"], whole.carried["mark"])


def test_memory_does_not_grow_with_the_rows_that_are_joined(tmp_path):
    peaks = []
    for rows in (60_000, 180_000):
        time = np.arange(rows) / 1000
        np.savez(tmp_path / "left.npz", time=time, f1x=time, f1y=time, t1z=time)
        np.savez(tmp_path / "motion.npz", time=time + 1e-4, mark=time)
        layout = Layout(grips=ONE, files={"left": {"path": "left.npz"}})
        tracemalloc.start()
        assert sum(len(part) for part in Reader(tmp_path / "motion.npz", layout)) == rows - 1
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


@pytest.mark.parametrize(
    ("said", "says"),
    [
        ({"clock": "up"}, "clock of .* must be one of the known names, got 'up'"),
        ({"clock": "left", "join_rate": 10.0}, "join_rate must be said alone"),
        ({"left": {"time": "t"}}, "time of left must be one of its columns, got 't'; has: time"),
        (
            {"left": {"unit": "h"}},
            "line 3, column 'f1x' must be .* got 'no sample of left that",
        ),
        (
            {"left": {"delay": 1e3}},
            "samples at the same time, got left -1000 s to -999.9",
        ),
        ({"left": {"rate": 100}}, "sample_rate must be left out where there is a column of time"),
        ({"left": {"part": "a"}}, "part must be left out of such files, which have none, got 'a'"),
        ({"left": {"path": "none.csv"}}, "file must exist, got '.*none.csv'"),
    ],
)
def test_what_cannot_be_joined_is_explained(said, says, tmp_path):
    with pytest.raises(CoopenvError, match=says):
        joined(devices(tmp_path), **said)


def test_a_part_that_two_devices_have_is_not_guessed(tmp_path):
    time = np.arange(8) / 100
    for name in ("left", "right"):
        np.savez(tmp_path / f"{name}.npz", time=time, F=np.ones((8, 3)))
    path = save(tmp_path / "motion.csv", text({"time": time}))
    files = {name: {"path": f"{name}.npz"} for name in ("left", "right")}
    columns = {"f1x": "F:0", "f1y": "left/F:1", "t1z": "-left/F:2"}
    with pytest.raises(InvalidInput, match=r"motion\.csv: F:0 must be .* write left/F:0"):
        read(path, Layout(grips=ONE, files=files, columns=columns))
    columns["f1x"] = "right/F:0"
    found = read(path, Layout(grips=ONE, files=files, columns=columns))
    assert found.applied[3, 0].tolist() == [1.0, 1.0, -1.0]


def test_a_rate_that_makes_more_rows_than_the_limit_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="at join_rate must have at most 1,000 rows, got"):
        joined(devices(tmp_path), join_rate=1e6, max_rows=1000)


@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"left": {"pth": "a"}}, "field of files.left must be .* got 'pth'; did you mean 'path'"),
        ({"left": {"path": 3}}, "files.left: path must be a word, got 3"),
        ({"left": {"path": "a", "rate": -1}}, "files.left: rate must be positive, got -1"),
        ({"left": {"path": "a", "method": "cubic"}}, "files.left: method must be one of"),
        ({"left": {"path": "a", "unit": "Hz"}}, "files.left: unit of time must be .* got 'Hz'"),
        ({"left": {"path": "a", "encoding": "klingon"}}, "files.left: encoding must be one of"),
        ({"left": {}, "right": {}}, "files must name the recording itself once, got 'left' and"),
        ({"left": 3}, "files must be tables of fields by the names of devices"),
    ],
)
def test_what_is_wrong_with_a_device_is_said_with_its_name(files, says):
    with pytest.raises(CoopenvError, match=says):
        Layout(files=files)


def test_a_wrong_device_in_a_layout_names_the_file_of_the_layout(tmp_path):
    path = save(tmp_path / "lab.toml", '[files.left]\npath = "left.csv"\nrate = "fast"\n')
    with pytest.raises(
        InvalidInput, match=r"lab\.toml: files\.left: rate must be a number, got 'f"
    ):
        Layout.load(path)


def test_a_damaged_sample_names_its_file_and_line_or_is_passed_over(tmp_path):
    path = devices(tmp_path)
    lines = (tmp_path / "left.csv").read_text().splitlines()
    for bad, says in (
        (
            lines[4].replace(",3.0,", ",x,"),
            "left.csv, line 5, column 'f1x' must be a finite number",
        ),
        (f"{lines[4]},7", "left.csv, line 5 must have as many fields as the header"),
        (lines[2], "left.csv, line 5, column 'time' must increase, got 0.01 s later"),
        (f"?{lines[4]}", "left.csv, line 5, column 'time' must be a finite number, got '?0.03'"),
    ):
        save(tmp_path / "left.csv", "\n".join([*lines[:4], bad, *lines[5:], ""]))
        with pytest.raises(InvalidInput, match=says.replace("?", r"\?")):
            joined(path)
        assert joined(path, bad_rows="skip").good.all()


def test_rows_put_beside_each_other_must_be_as_many(tmp_path):
    path = devices(tmp_path, left=np.arange(7) / 100)
    with pytest.raises(InvalidInput, match=r"left\.csv must have as many rows as .*, got 7 and 8"):
        joined(path, join_method="rows")


def test_a_clock_that_begins_again_is_refused(tmp_path):
    path = devices(tmp_path, motion=[0.0, 0.01, 0.02, 0.0, 0.01])
    with pytest.raises(InvalidInput, match=r"line 5: time of a clock must increase, got 0 s after"):
        joined(path)


def test_columns_of_one_name_are_told_apart_by_their_device(tmp_path):
    time = recorded()["time"]
    for name in ("left", "right"):
        given = {"time": time, "Fx": time if name == "left" else -time, "Fy": time, "Mz": time}
        save(tmp_path / f"{name}.csv", text(given))
    path = save(tmp_path / "motion.csv", text({"time": time}))
    columns = {
        f"{kind}{i}{axis}": f"{device}/{theirs}"
        for i, device in ((1, "left"), (2, "right"))
        for kind, axis, theirs in (("f", "x", "Fx"), ("f", "y", "Fy"), ("t", "z", "Mz"))
    }
    found = joined(path, columns=columns | {"f2x": "-right/Fx"})
    np.testing.assert_allclose(found.applied[:, 1, 0], found.applied[:, 0, 0])
    with pytest.raises(InvalidInput, match=r"column f1x must be there.* has: time, left/Fx"):
        joined(path)


def test_missing_values_are_filled_up_to_the_gap_and_bad_ones_are_not(tmp_path):
    head = "time,f1x,f1y,t1z\n"
    path = save(tmp_path / "a.csv", head + "0,1,0,0\n0.1,,0,0\n0.2,NA,0,0\n0.3,4,0,0\n0.9,5,0,0\n")
    said = {"grips": ONE, "longest_gap": 0.3}
    assert read(path, Layout(fill="linear", **said)).applied[:, 0, 0].tolist()[1:3] == [2.0, 3.0]
    previous = read(path, Layout(fill="previous", **said)).applied[:, 0, 0]
    assert previous.tolist() == [1.0, 1.0, 1.0, 4.0, 5.0]
    with pytest.raises(InvalidInput, match="line 3, column 'f1x' must be a finite number, got ''"):
        read(path, Layout(fill="linear", grips=ONE, longest_gap=0.2))
    save(path, path.read_text().replace("NA", "4?"))
    with pytest.raises(InvalidInput, match=r"line 4, column 'f1x' must be .* got '4\?'"):
        read(path, Layout(fill="linear", **said))


def test_filling_stops_where_a_trial_ends_and_pieces_do_not_matter(tmp_path, monkeypatch):
    rng = np.random.default_rng(1)
    rows = []
    for trial in range(3):
        for k in range(40):
            force = f"{10 * trial + k / 10:.1f}" if rng.random() < 0.4 or k in (0, 39) else ""
            rows.append(f"{k / 100},{force},0,0,{trial}")
    path = save(tmp_path / "a.csv", "\n".join(["time,f1x,f1y,t1z,trial", *rows, ""]))
    layout = Layout(grips=ONE, fill="linear", longest_gap=0.5)
    whole = read(path, layout)
    wanted = np.repeat([0.0, 10.0, 20.0], 40) + np.tile(np.arange(40) / 10, 3)
    np.testing.assert_allclose(whole.applied[:, 0, 0], wanted)
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", 60)
    np.testing.assert_array_equal(read(path, layout).applied, whole.applied)


def test_equal_times_are_told_and_cost_nothing(tmp_path):
    path = save(tmp_path / "a.csv", "time,f1x,f1y,t1z\n0,1,0,0\n0.1,2,0,0\n0.1,3,0,0\n0.2,4,0,0\n")
    with pytest.warns(UserWarning, match="1 rows of .* have the time of the row before, .* line 4"):
        found = read(path, Layout(grips=ONE))
    assert found.good.all()
    summary = decompose_file(path, layout=Layout(grips=ONE), picture=False)
    assert summary.bad_rows == 0
    assert "warning: 1 rows" in summary.notes[0]


def test_equal_times_of_a_device_are_warned_of_too(tmp_path):
    path = devices(tmp_path, right=np.repeat(np.arange(8), 2) / 100)
    with pytest.warns(UserWarning, match="8 samples of right had the time before's"):
        found = joined(path)
    assert found.good.all()
    np.testing.assert_allclose(found.applied[:, 1, 0], 100 * seconds(found))


def test_a_part_that_a_file_does_not_have_is_answered_with_those_it_has(tmp_path):
    savemat(tmp_path / "a.mat", {"trial": {"t": np.arange(3.0)}})
    with pytest.raises(InvalidInput, match="part must be one of its structures, got 'no'; has: tr"):
        formats.open_source(tmp_path / "a.mat", part="no")
    assert formats.open_source(tmp_path / "a.mat", part="trial").columns == ["t"]
