"""Text tables of every form are read as declared, and what was not declared is asked about."""

import gzip
import io
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("pandas")
pytest.importorskip("pyarrow")

import pandas as pd
import pyarrow as pa

from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.logs import Layout, read
from coopenv.logs.declared.dialect import ENCODINGS, Dialect
from coopenv.logs.declared.stamps import Origin, Stamps
from coopenv.logs.declared.units import SPELLINGS, UNITS, is_unit, known_unit
from coopenv.logs.formats import open_source
from coopenv.logs.formats.cleaning import blanks_as_tabs, cleaner, numbered

ONE = (0.0, 0.0)
HEAD = "time,f1x,f1y,t1z\n"
ROWS = "0,1,2,3\n1,4,5,6\n"


def trial(folder, content, name="a.csv", **said):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read(path, Layout(grips=ONE, **said))


@pytest.mark.parametrize(
    ("content", "said", "says"),
    [
        (
            "Device 7\nRate 100\n\n" + HEAD + ROWS,
            {},
            "line 1 must name .* line 4 .* --skip-lines 3",
        ),
        (HEAD + "s,N,N,Nm\n" + ROWS, {}, "line 2 must be a row of data, got units .* --units-row"),
        (
            HEAD + "s,N,N,Nm\n" + ROWS,
            {"units_row": True, "force": "kN"},
            "got N in the file and kN",
        ),
        (
            HEAD + "s,N,N,V\n" + ROWS,
            {"units_row": True},
            "'t1z': unit of torque must be .* got 'V'",
        ),
        (HEAD, {"units_row": True}, "must have a row of units below its header, got nothing"),
        (HEAD + ROWS, {"skip_lines": 9}, "must have its header below the 9 lines .* got 3 lines"),
        ("#a\n#b\n", {"comment": "#"}, "line 2 must name the columns"),
        ("Kraft für x\n".encode("cp1252"), {}, "line 1 must be UTF-8 text, .* say its --encoding"),
        (HEAD + "0,1,2,3\n1,4,5,\x81\n", {"encoding": "ascii"}, "line 3 must be text in ascii"),
        (HEAD.encode("utf-16")[:-1], {}, "line 1 must be text in utf-16"),
        (HEAD.replace(",", ";") + "0;1;2;3", {"decimal": ";"}, "decimal must be one of"),
        (HEAD + "0,1,2,3\n", {"decimal": ","}, "decimal must not be what separates the columns"),
        ("Time,f1x,f1y,t1z\n" + ROWS, {}, "'Time' must be called time .* say --map time=Time"),
        (
            "time,f1x,f1y,t1z,TIME\n0,1,2,3,4\n",
            {},
            "must differ by more than capitals, got 'time' and 'TIME'; .* --map time=time or",
        ),
        (
            "Time,f1x,f1y,t1z\n" + ROWS,
            {"sample_rate": 100.0},
            "sample_rate must be left out .* got column 'Time'; leave it out, or say --map time=",
        ),
        ("time,f1x,f1y,t1z,f1x\n", {}, "columns must differ, got 'f1x' twice; .* --map f1x=f1x"),
        (HEAD + "1,2,3,4,5\n", {}, "line 2 must have 4 fields like the header, got 5 fields"),
        (HEAD + "1,2,3,\n", {}, "line 2, column 't1z' must be a finite number, got ''"),
    ],
)
def test_what_a_text_is_like_is_asked_about_in_one_line(content, said, says, tmp_path):
    with pytest.raises(CoopenvError, match=says) as told:
        trial(tmp_path, content, **said)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("columns", "times"), [({"time": "time"}, [0.0, 1.0]), ({"time": "TIME"}, [5.0, 7.0])]
)
def test_of_two_columns_that_differ_in_capitals_the_one_that_is_mapped_is_read(
    columns, times, tmp_path
):
    found = trial(tmp_path, "time,f1x,f1y,t1z,TIME\n0,1,2,3,5\n1,4,5,6,7\n", columns=columns)
    np.testing.assert_array_equal(found.time, times)


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("separator", "~", "separator must be one of the known names"),
        ("encoding", "rot13", "encoding must be one of the known names, got 'rot13'"),
        ("encoding", "cp125é", "encoding must be one of the known names"),
        ("encoding", "utf-8é", "encoding must be one of the known names"),
        ("encoding", "utf\0-8", "encoding must be one of the known names"),
        ("encoding", 3, "encoding must be a word, got 3"),
        ("comment", "# ", "comment must be a mark of at most 8 characters"),
        ("skip_lines", -1, "skip_lines must be a whole number of at least 0"),
        ("units_row", "yes", "units_row must be true or false, got 'yes'"),
        ("fill", "cubic", "fill must be one of the known names"),
        ("longest_gap", 0, "longest_gap must be positive, got 0"),
        ("sample_rate", float("nan"), "sample_rate must be finite"),
        ("join", 3, "join must be files, got 3"),
        ("join", ("=a",), "join must be files, got '=a'; write NAME=PATH"),
        ("time", "%H:%Q", "time must be a unit, iso, or a form of"),
        ("time", "%Y-%m", "time must be a form with a time of the day"),
    ],
)
def test_a_wrong_form_is_explained(field, value, says):
    with pytest.raises(CoopenvError, match=says):
        Layout(**{field: value}).devices("a")


def test_lines_keep_their_numbers_whatever_is_passed_over(tmp_path):
    content = "made by x\n# a\n" + HEAD + "# b\n0,1,2,3,\n\n1,4,x,6,\n"
    with pytest.raises(InvalidInput, match="line 7, column 'f1y' must be a finite number, got 'x'"):
        trial(tmp_path, content, skip_lines=1, comment="#")


def test_a_line_that_lacks_its_last_field_is_not_taken_for_one_with_a_separator(tmp_path):
    with pytest.raises(InvalidInput, match="line 3 must have 4 fields like the header, got 3"):
        trial(tmp_path, HEAD + "0,1,2,3,\n1,4,5\n")
    with pytest.raises(InvalidInput, match="line 3 must have 4 fields like the header, got 5"):
        trial(tmp_path, HEAD + "0,1,2,3,\n1,4,5,6,7\n")


def test_a_damaged_archive_of_text_names_its_file(tmp_path):
    with pytest.raises(InvalidInput, match=r"a\.csv\.gz must be whole"):
        trial(tmp_path, gzip.compress((HEAD + ROWS).encode())[:-9], "a.csv.gz")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252", "gb18030", "shift_jis"])
def test_an_encoding_is_read_in_pieces_like_the_whole(encoding, tmp_path, monkeypatch):
    text = HEAD.replace("t1z", "t1z,note") + "".join(f"{k},1,2,3,Ω力{k}\n" for k in range(50))
    text = text if encoding != "cp1252" else text.replace("Ω力", "äß€")
    monkeypatch.setattr("coopenv.logs.formats.encoded.PIECE", 44)
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", 37)
    found = trial(tmp_path, text.encode(encoding), encoding=encoding)
    assert found.carried["note"][49] in ("Ω力49", "äß€49")
    np.testing.assert_array_equal(found.applied[:, 0, 0], np.ones(50))
    assert found.time is not None
    assert found.time.tolist() == list(range(50))


def test_every_encoding_is_known_to_python():
    assert [Dialect(encoding=each).encoding for each in ENCODINGS] == list(ENCODINGS)


@given(names=st.lists(st.sampled_from(["a", "b", "a.1", "a.2", "", "c"]), max_size=8))
@settings(max_examples=40, deadline=None)
def test_names_that_are_there_again_are_counted_and_never_meet(names):
    made, repeated = numbered(names)
    assert len(set(made)) == len(names)
    assert repeated == {name for name in names if names.count(name) > 1}
    if names and "" not in names and not {"a.1", "a.2"} & set(names):
        line = io.StringIO(",".join(names) + "\n" + ",".join("1" * len(names)))
        assert list(pd.read_csv(line).columns) == made


FIELD = st.text("01a ", max_size=3) | st.sampled_from(['"a,b"', '"a b"'])


@given(lines=st.lists(st.lists(FIELD, min_size=3, max_size=3), min_size=1, max_size=4))
@settings(max_examples=40, deadline=None)
def test_cleaning_leaves_fields_and_the_number_of_lines_as_they_are(lines):
    plain = "\n".join(",".join(line) for line in lines) + "\n"
    clean = cleaner(",", "", columns=3, empty=2)
    assert clean is not None
    for more in ("", ",", ",,", ", ,"):
        ended = "".join(f"{line}{more}\r\n" for line in plain.splitlines()).encode()
        assert clean(ended) == plain.replace("\n", "\r\n").encode()
    blanks = blanks_as_tabs(plain.replace(",", "  ").encode()).decode()
    assert blanks.count("\n") == len(lines)
    assert all(line == line.strip() for line in blanks.splitlines())


@pytest.mark.parametrize("quantity", UNITS)
def test_every_spelling_means_its_unit_and_an_unknown_one_names_the_known(quantity):
    for unit in UNITS[quantity]:
        forms = {unit, f"[{unit}]", f"({unit})", unit.replace("*", "·"), unit.replace("*", "-"),
                 unit.replace("*", " "), unit.replace("*", " . ")}  # fmt: skip
        forms |= set(SPELLINGS[quantity].get(unit, "").split())
        assert {known_unit(quantity, form) for form in forms} == {unit}
    with pytest.raises(UnknownName, match=f"unit of {quantity} .* got 'furlong'; .*known: "):
        known_unit(quantity, "furlong")


def test_the_case_of_a_unit_says_how_much_it_is():
    for quantity, said in (("force", "MN"), ("force", "n"), ("torque", "MN*m"), ("length", "MM")):
        with pytest.raises(UnknownName):
            known_unit(quantity, said)
    assert known_unit("angular_velocity", "RPM") == "rpm"
    assert known_unit("angle", "Degrees") == "deg"
    assert [is_unit(each) for each in ("[s]", "", "Nm", "-", "x1", "3")] == [True] * 4 + [False] * 2


def seconds(form, *texts):
    return Stamps(form).of_texts(pa.array(texts)).tolist()


@pytest.mark.parametrize(
    ("form", "texts", "wanted"),
    [
        ("iso", ("2026-03-01", "2026-03-01T01:00", "2026-03-01 00:00:01,5Z"), [0, 3600, 1.5]),
        ("iso", ("2026-03-01T12:00:00+02:00", "2026-03-01T10:00:00.000000001Z"), [0, 1e-9]),
        ("iso", ("2024-02-28T00:00:00Z", "2024-03-01T00:00:00Z"), [0, 2 * 86400]),
        ("%I:%M %p", ("11:30 AM", "12:30 pm", "1:30 PM"), [0, 3600, 7200]),
        ("%d %b %y, %H.%M", ("28 Feb 25, 23.59", "01 Mar 25, 00.00"), [0, 60]),
        (
            "%H:%M:%S.%f",
            ("23:59:59.9", "00:00:00.1", "23:59:59.9", "00:00:00.1"),
            [0, 0.2, 86400, 86400.2],
        ),
    ],
)
def test_times_as_text_are_seconds_since_the_first(form, texts, wanted):
    assert seconds(form, *texts) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    "text",
    ["2025-02-29", "2026-13-01", "2026-00-01", "2026-01-00", "25:00", "", "x", "2026-1-1T24:00"],
)
def test_a_time_that_there_is_not_is_none(text):
    assert np.isnan(seconds("iso", "2026-01-01", text, "2026-01-02")[1])


def test_files_may_count_from_the_same_time():
    origin = Origin()
    assert Stamps("iso", origin).of_texts(pa.array(["2026-01-01T00:00:01"])).tolist() == [0.0]
    assert Stamps("iso", origin).of_texts(pa.array(["2026-01-01T00:00:03"])).tolist() == [2.0]


def test_time_stamps_keep_their_nanoseconds():
    stamps = np.datetime64("2026-01-01", "ns") + np.array([0, 1, 1_000_000_001])
    found = Stamps("iso").of_nanoseconds(stamps.astype(np.int64), np.ones(3, np.bool_))
    np.testing.assert_allclose(found, [0.0, 1e-9, 1.000000001], rtol=1e-15)


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"f1x": "a:9"}, "array 'a' must have a number at 'a:9' in every row, got rows of shape"),
        ({"f1x": "a:0:0"}, "array 'a' must have a number at 'a:0:0'"),
        ({"f1x": "b:0"}, "array 'b' must be as long as the others, 4 rows, got 2"),
        ({"f1x": "c:0"}, "f1x must be mapped to one of its columns, got 'c:0'"),
    ],
)
def test_a_part_that_an_array_does_not_have_is_refused(columns, says, tmp_path):
    np.savez(tmp_path / "a.npz", time=np.arange(4.0), a=np.zeros((4, 3)), b=np.zeros((2, 3)))
    with pytest.raises(InvalidInput, match=says):
        read(tmp_path / "a.npz", Layout(grips=ONE, columns=columns))


def test_a_list_that_is_too_short_is_a_bad_row(tmp_path):
    from pyarrow import parquet

    table = {"a": pa.array([[1.0, 2.0, 3.0], [1.0, 2.0], None, [4.0, 5.0, 6.0]])}
    parquet.write_table(pa.table(table), tmp_path / "a.parquet")
    columns = {"f1x": "a:0", "f1y": "a:1", "t1z": "-a:2"}
    layout = Layout(grips=ONE, columns=columns)
    found = read(tmp_path / "a.parquet", layout, bad_rows="skip")
    assert found.good.tolist() == [True, False, False, True]
    assert found.applied[3, 0].tolist() == [4.0, 5.0, -6.0]
    source = open_source(tmp_path / "a.parquet")
    source.offer(["a:1"])
    assert source.columns == ["a:1"]
    assert list(source.left_out) == []


MEASURED = "0.0,1,2,3\n0.1,1,2,3\n"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (MEASURED, "line 1 must name the columns, got numbers such as 0.0; say --no-header"),
        (
            "Made by X\nDate 2026\n\ntime,f1x,f1y,t1z\n" + MEASURED,
            "looks like names; say --skip-lines 3",
        ),
        (
            "time,f1x,f1y,t1z\n09:00:00:000,1,2,3\n",
            "got '09:00:00:000', a time as text: say --time \"%H:%M:%S:%f\"; repair it",
        ),
        (
            "time,f1x,f1y,t1z\n2026-03-01T09:00:00Z,1,2,3\n",
            "got '2026-03-01T09:00:00Z', a time as text: say --time \"iso\"",
        ),
    ],
)
def test_what_a_text_seems_to_be_is_told_with_its_option(content, says, tmp_path):
    (tmp_path / "a.csv").write_text(content)
    with pytest.raises(InvalidInput, match=re.escape(says)):
        read(tmp_path / "a.csv", Layout(grips=ONE))


def test_whole_numbers_may_be_names(tmp_path):
    (tmp_path / "a.csv").write_text("0,1,2,3\n" + MEASURED)
    columns = {name: str(k) for k, name in enumerate(("time", "f1x", "f1y", "t1z"))}
    assert len(read(tmp_path / "a.csv", Layout(grips=ONE, columns=columns))) == 2


def test_a_last_column_that_has_values_and_no_name_is_called_by_its_number(tmp_path):
    (tmp_path / "a.csv").write_text("time,f1x,f1y,t1z,\n0.0,1,2,3,0.5\n0.1,1,2,3,0.6\n")
    found = read(tmp_path / "a.csv", Layout(grips=ONE))
    assert found.carried["4"].tolist() == [0.5, 0.6]


def test_parts_of_arrays_are_kept_whoever_asks_for_them(tmp_path):
    """Columns and pose are asked for one after the other; no array says how many rows there are."""
    block = np.arange(40.0).reshape(4, 10) / 100
    np.savez(tmp_path / "a.npz", a=block[:, :3], b=block[:, 3:6], c=block[:, 6:])
    names = ("f1x", "f1y", "t1z")
    columns = {name: f"a:{k}" for k, name in enumerate(names)} | {"x": "b:0", "y": "b:1"}
    pose: Any = {"orientation": "euler", "columns": ["c:0", "c:1", "c:2"], "order": "ZYX"}
    said: Any = {"columns": columns, "sample_rate": 100.0, "frame": "world", "angle": "deg"}
    found = read(tmp_path / "a.npz", Layout(grips=ONE, pose=pose, **said))
    assert found.position is not None
    np.testing.assert_allclose(found.position, block[:, 3:5])
    source = open_source(tmp_path / "a.npz")
    source.offer(["a:0"])
    source.offer(["b:1"])
    assert source.columns == ["a:0", "b:1"]


@pytest.mark.parametrize(
    ("said", "unit"),
    [("Lbf-in", "lbf*in"), ("LBF-FT", "lbf*ft"), ("Kgf-cm", "kgf*cm"), ("Kg-cm", "kgf*cm")],
)
def test_units_of_torque_are_known_in_any_case_where_it_tells_nothing(said, unit):
    assert Layout(torque=said).torque == unit


def test_case_is_kept_where_it_tells_how_much(tmp_path):
    with pytest.raises(CoopenvError, match="unit of torque must be one of the known names"):
        Layout(torque="MN*m")
