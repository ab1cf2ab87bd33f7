"""What is in a recorded file is told, and the layout that is made of it reads the file."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("tyro")

from coopenv import cli
from coopenv.errors import CoopenvError
from coopenv.logs import Layout, read
from coopenv.logs.inspected import first_layout, inspect_file
from coopenv.logs.inspected.contents import Seen
from coopenv.logs.inspected.guesses import guess, guesses
from tests.logs import cases, devices, kinds
from tests.reliability.damaged import KINDS, damaged

DAMAGED = (".csv", ".csv.gz", ".npz", ".parquet", ".mat")
QUICK = [kind for kind in kinds.KINDS if kind.needs != "rosbags"]  # these are below


def require_told(path, folder):
    """A layout is made of it that can be read, or one sentence says what is wrong."""
    try:
        text = first_layout(inspect_file(path))
    except CoopenvError as error:
        said = str(error)
    else:
        (folder / "made.toml").write_text(text, encoding="utf-8")
        Layout.load(folder / "made.toml")
        return
    assert str(path) in said
    assert "\n" not in said


def shown(capsys, *words):
    assert cli.main(["inspect", *map(str, words)]) == 0
    return capsys.readouterr().out


def test_columns_rates_gaps_and_missing_values_are_told(tmp_path, capsys):
    columns = cases.planar(60)
    columns["time"] = np.round(columns["time"] * 1000) + np.where(np.arange(60) < 30, 0, 200)
    columns["f1x"][[3, 7]] = np.nan
    path = cases.save(columns | {"note": np.array(["calm"] * 60)}, tmp_path / "trial.csv")
    text = shown(capsys, path)
    assert "60 rows, 14 columns" in text
    said = "time 'time' in ms, by the size of its numbers: 0 s to 0.79 s, 100 rows a second, gap"
    assert said in text
    assert "2 missing  could be f1x" in text
    assert "text such as 'calm'" in text


@pytest.mark.parametrize("clock", ["time", "stamp", ""])
def test_the_column_of_time_is_told_among_the_others_where_there_is_one(clock, tmp_path, capsys):
    columns = {"f1x": np.sin(np.arange(20.0)), "more": np.cos(np.arange(20.0))}
    if clock:
        columns[clock] = np.arange(20) / 100
    lines = shown(capsys, cases.save(columns, tmp_path / "a.npz")).splitlines()
    assert ("no column looks like time" in lines[1]) == (not clock)
    told = {line.split()[0]: line.split("  ")[-1] for line in lines[2:]}
    assert told["f1x"] == "could be f1x"
    assert [name for name, could in told.items() if could == "time"] == [clock] * bool(clock)


@pytest.mark.parametrize(
    ("name", "wanted", "unit"),
    [
        ("Fx_left", "f1x", ""),
        ("right.force.y [lbf]", "f2y", "lbf"),
        ("Mz2 (N-mm)", "t2z", "N*mm"),
        ("/right/wrench/wrench/torque/z", "t2z", ""),
        ("torque_z_1", "t1z", ""),
        ("pos_x_mm", "x", "mm"),
        ("/object/pose/orientation/w", "qw", ""),
        ("quat_z", "qz", ""),
        ("Velocity.y", "vy", ""),
        ("angular_z", "omega_z", ""),
        ("yaw [deg]", "theta", "deg"),
        ("grip_1_x", "r1x", ""),
        ("max", None, ""),
        ("emg_left", None, ""),
        ("w", None, ""),
    ],
)
def test_names_as_laboratories_give_them_are_guessed(name, wanted, unit, tmp_path):
    (tmp_path / "a.csv").write_text(f"time,{name}\n0.0,1\n0.1,2\n0.2,1\n")
    (found,) = guesses(inspect_file(tmp_path / "a.csv"))
    assert [each.name for each in found.values()] == ([wanted] if wanted else [])
    assert [each.unit for each in found.values()] == ([unit] if wanted else [])


def test_the_layout_that_is_written_reads_a_file_and_says_what_is_a_guess(tmp_path, capsys):
    columns = cases.planar(50)
    theirs = {"time": "stamp", "f1x": "Fx_left", "f1y": "Fy_left", "t1z": "Mz_left"}
    theirs |= {f"f2{a}": f"F{a}_right [lbf]" for a in "xy"} | {"t2z": "Mz_right"}
    renamed = {theirs.get(name, name): each for name, each in columns.items()}
    renamed["stamp"] = renamed["stamp"] * 1000
    renamed["theta"] = 100 * renamed["theta"]
    path = cases.save(renamed, tmp_path / "a.npz")
    text = shown(capsys, path, "--write", tmp_path / "lab.toml")
    assert "wrote" in text
    written = (tmp_path / "lab.toml").read_text()
    assert 'angle = "deg"  # a guess' in written
    assert 'force = "lbf"\n' in written
    layout = Layout.load(tmp_path / "lab.toml", grips=cases.BEAM)
    found = read(path, layout)
    assert found.time is not None
    np.testing.assert_allclose(found.time, columns["time"], atol=1e-12)
    np.testing.assert_allclose(found.applied[:, 1, 2], columns["t2z"])
    assert cli.main(["inspect", str(path), "--write", str(tmp_path / "lab.toml")]) == 1
    assert "must be a new .toml file" in capsys.readouterr().err
    assert (tmp_path / "lab.toml").read_text() == written


def test_files_of_devices_are_joined_by_the_layout_that_is_written(tmp_path, capsys):
    columns = cases.planar(60)
    for side, i in (("left", 1), ("right", 2)):
        own = {"ms": 1000 * columns["time"]}
        own |= {name: columns[f"{name[0].lower().replace('m', 't')}{i}{name[1]}"]
                for name in ("Fx", "Fy", "Mz")}  # fmt: skip
        cases.save(own, tmp_path / f"{side}.csv")
    pose = {name: columns[name][::2] for name in ("time", "x", "y", "theta")}
    files = [tmp_path / "left.csv", tmp_path / "right.csv", tmp_path / "motion.csv"]
    cases.save(pose, files[-1])
    for each in files[:2]:
        each.write_text(each.read_text().replace("ms,", "time_ms,", 1))
    shown(capsys, *files, "--write", tmp_path / "lab.toml")
    found = read(files[0], Layout.load(tmp_path / "lab.toml", grips=cases.BEAM))
    assert len(found) == 59
    assert found.position is not None
    np.testing.assert_allclose(found.applied, cases.wrench(columns)[:59], atol=1e-12)
    np.testing.assert_allclose(found.position[::2, 0], columns["x"][:59:2])


def test_arrays_are_told_with_their_shapes_and_orders_are_left_open(tmp_path, capsys):
    columns = cases.planar(20) | {f"q{j}": np.full(20, 0.5) for j in range(4)}
    del columns["theta"]
    path = cases.save(columns | {"actions": np.ones((20, 3))}, tmp_path / "a.npz")
    text = shown(capsys, path)
    assert "array actions of shape (20, 3)" in text
    assert "actions:2 " in text
    layout = first_layout(inspect_file(path))
    assert '# pose = { columns = ["q0", "q1", "q2", "q3"], order = "xyzw" }  # or "wxyz"' in layout


@pytest.mark.parametrize("kind", QUICK, ids=lambda kind: kind.name)
def test_a_file_of_every_kind_is_looked_through_or_what_is_to_be_said_is_said(kind, tmp_path):
    if kind.needs:
        pytest.importorskip(kind.needs)
    path = kind.write(tmp_path)
    layout = Layout(**kind.layout)
    for each in inspect_file(path, layout.dialect, layout.limits):
        assert each.rows >= 3
        assert each.columns
    require_told(path, tmp_path)


@pytest.mark.parametrize("kind", [k for k, (suffix, _) in enumerate(KINDS) if suffix in DAMAGED])
def test_a_damaged_file_is_looked_through_or_refused_in_words(kind, tmp_path):
    for seed in range(kind, 8 * len(KINDS), len(KINDS)):
        require_told(damaged(seed, tmp_path), tmp_path)


def test_streams_of_a_bag_are_told_apart_and_their_layout_reads_it(tmp_path):
    pytest.importorskip("rosbags")
    path = devices.rosbag1(kinds.recorded(), tmp_path)
    contents = inspect_file(path)
    assert {each.part for each in contents} == {"/left/wrench", "/right/wrench", "/object"}
    (tmp_path / "lab.toml").write_text(first_layout(contents))
    found = read(path, Layout.load(tmp_path / "lab.toml", grips=cases.BEAM, space="plane"))
    np.testing.assert_allclose(found.applied, cases.wrench(kinds.recorded()), atol=1e-9)


def test_the_header_of_a_message_is_no_column(tmp_path):
    pytest.importorskip("rosbags")
    columns = {
        each.part: {seen.name for seen in each.columns}
        for each in inspect_file(devices.rosbag1(kinds.recorded(), tmp_path))
    }
    sides = {f"wrench/{what}/{axis}" for what in ("force", "torque") for axis in "xyz"}
    assert columns["/left/wrench"] - {"time"} == sides
    assert not {name for names in columns.values() for name in names if "header" in name}


@pytest.mark.parametrize("folder", ["/data/left/", "C:\\data\\left\\"])
def test_whose_device_a_file_is_says_its_name_and_not_its_folder(folder, tmp_path):
    (tmp_path / "a.csv").write_text("time,Fx,Fy\n0.0,1,2\n0.1,2,1\n")
    (seen,) = inspect_file(tmp_path / "a.csv")
    contents = [replace(seen, path=f"{folder}{name}.csv") for name in ("right", "left")]
    found = [{each.name for each in made.values()} for made in guesses(contents)]
    assert found == [{"f2x", "f2y"}, {"f1x", "f1y"}]


def test_names_that_would_break_out_of_a_layout_do_not(tmp_path):
    name = 'Fx_left"]\n[x]\x7f\\'
    np.savez(tmp_path / "a.npz", **{"time": np.arange(4.0), "f1y": np.ones(4)})
    contents = inspect_file(tmp_path / "a.npz")
    seen = contents[0].columns[-1]
    contents = [replace(contents[0], columns=(replace(seen, name=name),))]
    (tmp_path / "made.toml").write_text(first_layout(contents), encoding="utf-8")
    made = Layout.load(tmp_path / "made.toml")
    assert made.columns == {"f1x": name}


@pytest.mark.parametrize(
    ("name", "could"),
    [("omega_w", None), ("vel_w", None), ("omega_x", "omega_x"), ("vel_y", "vy"), ("quat_w", "qw")],
)
def test_a_w_is_of_a_quaternion_alone(name, could):
    seen = Seen(name=name, is_number=True, unit="", first="0", missing=0, low=0.0, high=1.0)
    found = guess(seen)
    assert (found.name if found else None) == could


@pytest.mark.parametrize(
    ("name", "high", "unit"),
    [
        ("x", 812.0, "mm"),
        ("x", 0.8, ""),
        ("theta", 90.0, "deg"),
        ("theta", 1.5, ""),
        ("r1x", 900.0, ""),
        ("f1x", 900.0, ""),
    ],
)
def test_numbers_too_large_for_a_room_are_millimetres_or_degrees(name, high, unit):
    seen = Seen(name=name, is_number=True, unit="", first="0", missing=0, low=-0.1, high=high)
    found = guess(seen)
    assert found is not None
    assert (found.name, found.unit, found.said and bool(unit)) == (name, unit, False)


def test_all_matrices_of_a_structure_are_told_and_its_field_of_time(tmp_path):
    pytest.importorskip("scipy")
    from scipy.io import savemat

    time = np.arange(20) / 100
    fields = {"t": time, "left": np.ones((20, 6)), "right": np.ones((20, 6))}
    savemat(tmp_path / "a.mat", {"trial": fields})
    (contents,) = inspect_file(tmp_path / "a.mat")
    assert contents.clock is not None
    assert contents.clock.column == "trial.t"
    names = [seen.name for seen in contents.columns]
    assert names.count("trial.left:5") == names.count("trial.right:5") == 1
