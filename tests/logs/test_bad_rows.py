"""What is wrong with a file is said with file, line and column."""

import numpy as np
import pytest

from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs import Layout, read
from tests.logs import cases

HEADER = "time,f1x,f1y,t1z,f2x,f2y,t2z,note"
BEAM = Layout(grips=cases.BEAM)


@pytest.fixture(autouse=True)
def _extra():
    pytest.importorskip("pyarrow")


def rows(count):
    return [f"{k / 100},1,2,3,4,5,6,ok" for k in range(count)]


def complaint(path, layout=BEAM):
    with pytest.raises(InvalidInput) as raised:
        read(path, layout)
    return str(raised.value)


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        ("0.045,1,abc,3,4,5,6,ok", "column 'f1y' must be a finite number, got 'abc'"),
        ("0.045,1,,3,4,5,6,ok", "column 'f1y' must be a finite number, got ''"),
        ("0.045,1,2,3,4,-inf,6,ok", "column 'f2y' must be a finite number, got '-inf'"),
        ("0.045,1,2,3,4,NaN,6,ok", "column 'f2y' must be a finite number, got 'NaN'"),
        ("0.045,1_0,2,3,4,5,6,ok", "column 'f1x' must be a finite number, got '1_0'"),
        ("0.045,1,2,3,4,5,6", " must have 8 fields like the header, got 7 fields"),
        ("0.045,1,2,3,4,5,6,ok,7", " must have 8 fields like the header, got 9 fields"),
        ('0.045,1,2,3,4,5,6,"o', " must have 8 fields like the header, got an open quotation mark"),
        ("0.03,1,2,3,4,5,6,ok", "column 'time' must increase within a trial, got 0.03 after 0.04"),
        ("x,1,2,3,4,y,6,ok", "column 'time' must be a finite number, got 'x'"),
    ],
)
@pytest.mark.parametrize("block", [80, 1 << 20])
def test_the_line_and_the_column_are_named(bad, says, block, tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", block)
    lines = rows(9)
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *lines[:3], "", *lines[3:5], bad, *lines[5:]]) + "\n")
    said = complaint(path)
    assert said.startswith(f"{path}, line 8")
    assert says in said
    assert "--bad-rows skip" in said
    passed_over = read(path, BEAM, bad_rows="skip")
    assert np.flatnonzero(~passed_over.good).tolist() == [5]
    assert np.isnan(passed_over.applied[5]).all()
    np.testing.assert_array_equal(passed_over.applied[-1].ravel(), [1, 2, 3, 4, 5, 6])


def test_the_first_of_many_bad_rows_is_named(tmp_path):
    lines = rows(20)
    lines[15], lines[4], lines[9] = "short", lines[4].replace("6", "six"), lines[9] + ",long"
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *lines]))
    assert "line 6, column 't2z' must be a finite number, got 'six'" in complaint(path)
    assert (~read(path, BEAM, bad_rows="skip").good).sum() == 3


def test_the_mapped_name_of_a_column_is_said_too(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER.replace("f1x", "Fx"), *rows(2), "0.5,?,2,3,4,5,6,ok"]))
    layout = Layout(grips=cases.BEAM, columns={"f1x": "Fx"})
    assert "line 4, column 'Fx' (f1x) must be" in complaint(path, layout)


@pytest.mark.parametrize("suffix", [each for each in cases.FORMATS if each != ".csv"])
def test_other_formats_have_rows(suffix, tmp_path):
    columns = cases.planar(10)
    columns["t1z"][7] = np.nan
    path = cases.save(columns, tmp_path / f"a{suffix}")
    assert f"{path}, row 8, column 't1z' must be a finite number, got 'nan'" in complaint(path)


def test_time_may_begin_again_with_a_new_trial(tmp_path):
    columns = cases.planar(8) | {"session": np.repeat([1, 2], 4)}
    columns["time"] = np.tile(np.arange(4.0), 2)
    path = cases.save(columns, tmp_path / "a.csv")
    assert "line 6, column 'time' must increase" in complaint(path)
    recording = read(path, Layout(grips=cases.BEAM, trial_columns=("session",)))
    assert recording.trial.tolist() == [0] * 4 + [1] * 4


def test_a_ragged_row_does_not_begin_a_trial(tmp_path):
    path = tmp_path / "a.csv"
    lines = [line.replace("ok", str(k // 3)) for k, line in enumerate(rows(6))]
    lines[1] = "1,2"
    path.write_text("\n".join([HEADER.replace("note", "trial"), *lines]))
    recording = read(path, BEAM, bad_rows="skip")
    assert recording.trial.tolist() == [0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize(
    ("header", "layout", "says"),
    [
        ("F1x,f1y,t1z", BEAM, "column f1x must be there.*did you mean 'F1x'.*--map f1x=F1x"),
        ("f1x,f1y,t1z,f2x,f2y", BEAM, "column t2z must be there"),
        ("f1x,f1y,f1z,t1x,t1y,t1z,r1x,r1y", Layout(), "none of that name; rename a column or map"),
        ("f1x,f1y,T1z,r1x", Layout(forces_only=True), "column r1y must.*; rename a column or map"),
        ("f1x,f1y,t1z,f3x,f3y,t3z", Layout(), "column f2x must be there"),
        ("f1x,f1y,t1z", Layout(), "column r1x must be there.*--grips"),
        ("f1x,f1y,t1z", BEAM, "grips must be 2 or 3 numbers for each of 1 effectors, got 4"),
        ("f1x,f1y,t1z,r1x,r1y", Layout(grips=(0.0, 0.0)), "grips must be said once"),
        ("f1x,f1y,t1z,f1x", Layout(grips=(0.0, 0.0)), "columns must differ, got 'f1x' twice"),
        ("f1x,f1y,t1z", Layout(grips=(0.0, 0.0), frame="world"), "column theta must be there"),
        ("f1x,f1y,t1z,vx,vy", Layout(grips=(0.0, 0.0)), "column omega must be there.*--map vx="),
        (
            "f1x,f1y,t1z", Layout(grips=(0.0, 0.0), columns={"f1x": "f1_x"}),
            "f1x must be mapped to one of its columns, got 'f1_x'; did you mean 'f1x'",
        ),
        ("f1x,f1y,f1z,t1x,t1y,t1z,r1x,r1y,r1z", Layout(y="down"), "y must be 'up' in space"),
        ("f1x,f1y,t1z", Layout(grips=(0.0, 0.0), grip_frame="world"), "grip_frame must be"),
        ("f1x,f1y,t1z", Layout(grips=(0.0, 0.0)), "must have rows of data, got none"),
    ],
)  # fmt: skip
def test_a_wrong_header_is_explained(header, layout, says, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(header + "\n")
    with pytest.raises(InvalidInput, match=says):
        read(path, layout)


@pytest.mark.parametrize(("others", "ending"), [(0, ""), (27, ""), (28, " …")])
def test_up_to_thirty_columns_are_listed_and_that_there_are_more_is_said(others, ending, tmp_path):
    names = ["f1x", "f1y", "t1z", *(f"c{k}" for k in range(others))]
    path = tmp_path / "a.csv"
    path.write_text(",".join(names) + "\n")
    said = complaint(path, Layout(grips=(0.0, 0.0), frame="world"))
    assert f"has: {', '.join(names[:30])}{ending};" in said


def test_a_quaternion_must_be_of_unit_length(tmp_path):
    columns = cases.spatial()
    columns["qw"][3] += 3.0
    path = cases.save(columns, tmp_path / "a.csv")
    said = complaint(path, Layout(frame="world"))
    assert "line 5, columns qw, qx, qy, qz must be a unit quaternion" in said
    columns["qx"][3] = columns["qy"][3] = columns["qz"][3] = columns["qw"][3] = 0.0
    path = cases.save(columns, tmp_path / "a.csv")
    recording = read(path, Layout(frame="world"), bad_rows="skip")
    assert np.flatnonzero(~recording.good).tolist() == [3]


def test_a_file_that_is_none_is_refused(tmp_path):
    for name, content, says in (
        ("none.csv", None, "file must exist"),
        ("a.xlsx", b"", "file must end in one of"),
        ("a.npz", b"abc", "must be an NPZ file"),
        ("a.parquet", b"abc", "must be a Parquet file"),
        ("a.csv", "f1x;Kraft für\n".encode("latin-1"), "line 1 must be UTF-8"),
        ("a.csv", b"", "a.csv, line 1 must name the columns, got an empty file"),
        ("a.csv", b"\xef\xbb\xbf\r\nf1x,f1y\r\n1,2\r\n", "line 1 must name .* got a blank line"),
    ):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(InvalidInput, match=says):
            read(tmp_path / name)
    with pytest.raises(UnknownName, match="bad_rows"):
        read(cases.save(cases.planar(), tmp_path / "b.csv"), BEAM, bad_rows="skp")


def test_arrays_must_fit_each_other_and_hold_numbers(tmp_path):
    columns = cases.planar(5)
    for change, says in (
        ({"f2x": np.array(list("abcde"))}, "'f2x' must hold numbers"),
        ({"force": np.zeros((5, 2, 4))}, "'force' must be of a documented shape"),
        ({"twist": np.zeros((4, 3))}, "'twist' must be as long as the others"),
        ({"twist": np.zeros((5, 3))}, "vx must be there once"),
        ({"grips": np.array([["a", "b"], ["c", "d"]])}, r"a\.npz, array 'grips' must hold numbers"),
        ({"grips": np.zeros((2, 2)), "f2x": np.array([None] * 5)}, "must be an NPZ file of plain"),
    ):
        path = cases.save(columns | change, tmp_path / "a.npz")
        with pytest.raises(InvalidInput, match=says):
            read(path, BEAM)
    pytest.importorskip("pandas")
    columns["f2x"] = np.array(list("abcde"))
    with pytest.raises(InvalidInput, match="column 'f2x' must hold numbers, got"):
        read(cases.save(columns, tmp_path / "a.parquet"), BEAM)


@pytest.mark.parametrize("block", [80, 1 << 20])
def test_a_file_of_ragged_rows_alone_is_named_line_by_line(block, tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", block)
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *(f"{row},7" for row in rows(9))]))
    assert "line 2 must have 8 fields like the header, got 9 fields" in complaint(path)
    passed_over = read(path, BEAM, bad_rows="skip")
    assert len(passed_over) == 9
    assert not passed_over.good.any()


def test_line_ends_of_old_macs_are_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes("\r".join([HEADER, *rows(3)]).encode())
    assert "a.csv: lines must end with a line feed" in complaint(path)


def test_a_trial_that_begins_with_a_bad_time_has_one_bad_row(tmp_path):
    path = tmp_path / "a.csv"
    second = ["x,1,2,3,4,5,6,b", "0.01,1,2,3,4,5,6,b", "0.02,1,2,3,4,5,6,b", "0,1,2,3,4,5,6,b"]
    path.write_text("\n".join([HEADER, *rows(9), *second]))
    layout = Layout(grips=cases.BEAM, trial_columns=("note",))
    recording = read(path, layout, bad_rows="skip")
    assert np.flatnonzero(~recording.good).tolist() == [9, 12]
    assert recording.trial.tolist() == [0] * 9 + [1] * 4


def test_a_trial_column_that_is_not_there_is_named(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *rows(3)]))
    said = complaint(path, Layout(grips=cases.BEAM, trial_columns=("nota",)))
    assert "got 'nota'; has: note" in said
    assert Layout.load(trial_columns="note").trial_columns == ("note",)


def test_a_part_of_a_twist_says_how_to_leave_out_the_rest(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER + ",vy,omega", *(f"{row},0,0" for row in rows(3))]))
    assert "--map vy= omega=" in complaint(path)
    left_out = Layout(grips=cases.BEAM, columns={"vy": "", "omega": ""})
    assert read(path, left_out).twist is None


def test_grips_of_an_archive_are_complained_of_with_its_name(tmp_path):
    for grips, says in (
        (np.full((2, 2), np.nan), r"a\.npz: grips must be finite"),
        (np.zeros((5, 1)), r"a\.npz: grips must be 2 or 3 numbers for each of 2 effectors"),
    ):
        path = cases.save(cases.planar(5) | {"grips": grips}, tmp_path / "a.npz")
        with pytest.raises(InvalidInput, match=says):
            read(path)


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_a_row_has_its_number_however_many_pieces_were_read_before_it(
    suffix, tmp_path, monkeypatch
):
    cases.set_chunk(4, monkeypatch)
    columns = cases.planar(30)
    columns["f2y"][21] = columns["f1x"][25] = np.nan
    path = cases.save(columns, tmp_path / f"a{suffix}")
    place = "line 23" if suffix == ".csv" else "row 22"
    assert f"{path}, {place}, column 'f2y' must be a finite number" in complaint(path)
    passed_over = read(path, BEAM, bad_rows="skip")
    assert np.flatnonzero(~passed_over.good).tolist() == [21, 25]


def test_lines_are_counted_through_blocks_with_blank_and_ragged_ones(tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", 70)  # about three lines
    lines = [text for row in rows(20) for text in (row, "", "\r")]
    lines[45] = "0.15,1,2,3,4,5,6"  # the 16th row
    path = tmp_path / "a.csv"
    path.write_bytes("\n".join([HEADER, *lines, "0.5,1,2,x,4,5,6,ok"]).encode())
    assert f"{path}, line 47 must have 8 fields like the header, got 7 fields" in complaint(path)
    passed_over = read(path, BEAM, bad_rows="skip")
    assert np.flatnonzero(~passed_over.good).tolist() == [15, 20]
    lines[45] = rows(20)[15]
    path.write_bytes("\n".join([HEADER, *lines, "0.5,1,2,x,4,5,6,ok"]).encode())
    assert "line 62, column 't1z' must be a finite number, got 'x'" in complaint(path)


def test_time_and_trials_go_on_from_one_piece_to_the_next(tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", 70)
    path = tmp_path / "a.csv"
    lines = rows(20)
    lines[12] = lines[10]
    path.write_text("\n".join([HEADER, *lines]))
    assert "line 14, column 'time' must increase within a trial, got 0.1 after 0.11" in complaint(
        path
    )
    lines[12] = lines[11]
    lines[12] = lines[11].replace("ok", "new")
    path.write_text(
        "\n".join([HEADER, *lines[:13], *(row.replace("ok", "new") for row in lines[13:])])
    )
    layout = Layout(grips=cases.BEAM, trial_columns=("note",))
    assert read(path, layout).trial.tolist() == [0] * 12 + [1] * 8


@pytest.mark.parametrize(("number", "good"), [(1e50, True), (1.001e50, False)])
def test_numbers_beyond_measure_are_bad_in_the_unit_of_the_file(number, good, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *rows(3), f"0.5,-{number},2,3,4,5,6,ok"]))
    assert read(path, BEAM, bad_rows="skip").good.tolist() == [True, True, True, good]
    assert read(path, Layout(grips=cases.BEAM, force="mN"), bad_rows="skip").good.all()
    kilo = read(path, Layout(grips=cases.BEAM, force="kN"), bad_rows="skip")
    assert kilo.good.tolist() == [True, True, True, False]
    if not good:
        said = "line 5, column 'f1x' must be at most 1e+50 in SI units, got '-1.001e+50'"
        assert said in complaint(path)


@pytest.mark.parametrize(("length", "good"), [(1.0099, True), (0.9901, True), (1.011, False)])
def test_a_quaternion_may_be_off_by_a_hundredth(length, good, tmp_path):
    columns = cases.spatial()
    for name in ("qw", "qx", "qy", "qz"):
        columns[name][3] *= length
    path = cases.save(columns, tmp_path / "a.csv")
    recording = read(path, Layout(frame="world"), bad_rows="skip")
    assert recording.good.tolist() == [True] * 3 + [good] + [True] * 2
