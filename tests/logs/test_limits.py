"""What one file may cost is bounded before anything is made of it, and each bound can be raised."""

import io
import json
import subprocess
import sys
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from coopenv.errors import InvalidInput
from coopenv.logs import Layout, decompose_file, read
from coopenv.logs.command import Decompose
from coopenv.logs.formats import open_source
from coopenv.logs.formats.chunks import Wanted
from coopenv.logs.limits import Limits
from tests.logs import cases, costly
from tests.reliability.faulty import header

BEAM: dict[str, Any] = {"grips": cases.BEAM}
ROW = "f1x,f1y,t1z,f2x,f2y,t2z\n1,2,3,4,5,6\n"


def refused(path: Path, **layout: Any) -> str:
    with pytest.raises(InvalidInput) as raised:
        read(path, Layout(**BEAM, **layout))
    said = str(raised.value)
    assert str(path) in said
    assert len(said) < 1500
    return said


def archive(path: Path, **entries: bytes) -> Path:
    """NPZ of entries that need not be what they say."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as made:
        for name, data in entries.items():
            made.writestr(f"{name}.npy", data)
    return path


def npy(array: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def test_every_limit_is_a_field_of_a_layout_and_an_option():
    options = {entry.name for entry in fields(Decompose)}
    for limit in fields(Limits):
        name = f"max_{limit.name}"
        assert name in options
        seven: dict[str, Any] = {name: 7}
        none: dict[str, Any] = {name: 0}
        assert getattr(Layout(**seven).limits, limit.name) == 7
        with pytest.raises(InvalidInput, match=f"{name} must be"):
            Layout(**none)


@pytest.mark.parametrize("line", [1, 2, 5])
def test_a_line_that_is_too_long_is_named_with_the_option(line, tmp_path):
    lines = ROW.splitlines() + ["1,2,3,4,5,6"] * 5
    lines[line - 1] += "." + "0" * 200
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines) + "\n")
    said = refused(path, max_row_bytes=150)
    assert f"{path}, line {line} must have at most 150 bytes in a row, got more" in said
    assert "--max-row-bytes" in said
    if line > 2:
        assert len(read(path, Layout(**BEAM, max_row_bytes=250, max_columns=6))) == 6


@pytest.mark.parametrize("block", [64, 4 << 20])
def test_a_long_cell_is_refused_whatever_blocks_it_spans(block, tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", block)
    path = tmp_path / "a.csv"
    for cell in ("7" * 2_000, '"' + "a" * 2_000 + '"', "7" * 2_000 + "\n1,2"):
        path.write_text(f"{ROW}1,2,3,4,5,{cell}")
        assert "line 3 must have at most 1,000 bytes" in refused(path, max_row_bytes=1000)
    path.write_text(f"{ROW}1,2,3,4,5,{'7' * 40}")
    assert len(read(path, Layout(**BEAM))) == 2


def test_columns_and_effectors_are_counted_before_they_are_looked_at(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(",".join(["f1x", *(f"c{k}" for k in range(12))]) + "\n")
    said = refused(path, max_columns=12)
    assert "line 1 must have at most 12 columns, got 13" in said
    assert "--max-columns" in said
    for name, found in (
        ("f999999999x", "999,999,999"),
        ("t101z", "101"),
        ("r" + "9" * 400 + "y", "number 999999999…"),
    ):
        path.write_text(f"f1x,f1y,{name}\n1,2,3\n")
        said = refused(path)
        assert f"must have at most 100 effectors, got {found}" in said
        assert "--max-effectors" in said
    path.write_text("f1x,f1y,t1z,Fx\n1,2,3,4\n")
    assert "at most 100 effectors" in refused(path, columns={"f10000000x": "Fx"})
    assert "got 2; rename it" in refused(path, columns={"f2x": "Fx"}, max_effectors=1)


def test_long_names_are_no_names(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(f"f1x,{'a' * 100_000},f1y\n1,2,3\n")
    said = refused(path)
    assert "column 2 must have a name of at most 1,000 characters, got 100,000: 'aaa" in said


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("f1x", header("'<f8'", "(10**12,)") + bytes(80), "says it has 8,000,000,000,000"),
        ("force", header("'<f8'", "(5, 10**9, 2)") + bytes(80), "says it has 80,000,000,000"),
        ("f1x", header("'<f8'", "(-5,)") + bytes(80), "of shape (-5,)"),
        ("f1x", header("'<U0'", "(5,)"), "of elements without size"),
        ("f1x", header("'|O'", "(5,)") + bytes(80), "of Python objects"),
        ("f1x", header("(" * 900 + "'<f8'" + ")" * 900, "(5,)"), "must be an NPZ file"),
        ("force", npy(np.zeros((5, 101, 2))), "'force' must have at most 100 effectors, got 101"),
        ("grips", npy(np.zeros((101, 2))), "'grips' must have at most 100 effectors, got 101"),
        ("note", npy(np.zeros(5, "U300000")), "at most 1,048,576 bytes in a row"),
    ],
)  # fmt: skip
def test_what_an_array_claims_is_checked_before_it_is_read(name, data, says, tmp_path):
    entries = {key: npy(column) for key, column in cases.planar(5).items()}
    said = refused(archive(tmp_path / "a.npz", **(entries | {name: data})))
    assert says in said


def test_arrays_in_fortran_order_are_read_at_once_and_therefore_bounded(tmp_path):
    force = np.asfortranarray(cases.wrench(cases.planar(50))[..., :2])
    path = tmp_path / "a.npz"
    np.savez(path, force=force, torque=np.zeros((50, 2)))
    np.testing.assert_array_equal(read(path, Layout(**BEAM)).applied[..., :2], force)
    said = refused(path, max_block_bytes=1000)
    assert "array 'force' in Fortran order must have at most 1,000 bytes to be read at once" in said
    assert "save it in C order, or say --max-block-bytes" in said


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_archives_compressed_otherwise_than_numpy_does_are_refused(method, tmp_path):
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", method) as made:
        for name, column in cases.planar(5).items():
            made.writestr(f"{name}.npy", npy(column))
    assert "compressed otherwise than NumPy does" in refused(path)


@pytest.mark.parametrize("suffix", [".npz", ".parquet"])
def test_rows_and_columns_that_a_file_declares_are_bounded(suffix, tmp_path):
    path = cases.save(cases.planar(30), tmp_path / f"a{suffix}")
    said = refused(path, max_rows=29)
    assert f"{path} must have at most 29 rows, got 30; cut it, or say --max-rows" in said
    assert "must have at most 5 columns, got 13" in refused(path, max_columns=5)
    assert len(read(path, Layout(**BEAM, max_rows=30, max_columns=13))) == 30


def test_row_groups_and_footers_of_parquet_are_bounded(tmp_path):
    path = cases.save(cases.planar(500), tmp_path / "a.parquet")
    said = refused(path, max_block_bytes=10_000)
    assert "row group 1 must have at most 10,000 bytes to be read at once" in said
    data = path.read_bytes()
    path.write_bytes(data[:-8] + (1 << 30).to_bytes(4, "little") + b"PAR1")
    assert "a footer of at most 67,108,864 bytes, got 1,073,741,824" in refused(path)


def test_a_long_text_that_many_rows_of_parquet_share_is_kept_once(tmp_path):
    import pyarrow as pa
    from pyarrow import parquet

    columns = {name: pa.array(values) for name, values in cases.planar(20_000).items()}
    path = tmp_path / "a.parquet"

    def save(length: int) -> None:
        note = pa.DictionaryArray.from_arrays(np.zeros(20_000, np.int32), ["n" * length])
        parquet.write_table(pa.table(columns | {"note": note}), path, store_schema=False)

    save(100_000)  # 2 GB of text in a small file
    chunks = open_source(path).chunks(Wanted(["f1x"], ["note"]))
    rows = []
    for chunk in chunks:
        rows.append(chunk.rows)
        assert chunk.carried["note"][0] is chunk.carried["note"][-1]
    assert sum(rows) == 20_000
    assert max(rows) * 100_000 <= 32 << 20
    save(2_000_000)
    assert "row 1 must have at most 1,048,576 bytes in a row, got 2,000," in refused(path)


def test_costly_files_are_refused_in_no_time_and_little_memory(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", costly.__name__, str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    said, grown, seconds = json.loads(done.stdout)
    assert len(said) == 10
    for path, answer in said.items():
        assert path in answer
        assert len(answer) < 1000
    assert grown < 40  # [MiB]
    assert seconds < 5


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_a_long_text_among_many_is_no_array_of_long_texts(suffix, tmp_path):
    lines = ["f1x,f1y,t1z,f2x,f2y,t2z,note", "1,2,3,4,5,6," + "n" * 1_000_000]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines + ["1,2,3,4,5,6,a"] * 1000))
    out, layout = tmp_path / f"b{suffix}", Layout(**BEAM)
    if suffix != ".npz":
        assert decompose_file(path, out, layout=layout, picture=False).rows == 1001
        return
    with pytest.raises(InvalidInput, match=r"a\.csv: column 'note' must need at most .* write CSV"):
        decompose_file(path, out, layout=layout, picture=False)
    assert sorted(tmp_path.iterdir()) == [path]


def test_nothing_is_ever_unpickled(tmp_path):
    trap = tmp_path / "sprung"

    class Trap:
        def __reduce__(self):
            return (open, (str(trap), "w"))

    for array in (np.array([Trap()] * 3), np.array(Trap())):
        path = cases.save(cases.planar(3) | {"note": array}, tmp_path / "a.npz")
        assert "of Python objects" in refused(path)
        assert not trap.exists()


def test_arrays_of_foreign_types_are_read_or_left_out(tmp_path):
    columns = cases.planar(3)
    columns["f1x"] = columns["f1x"].astype(">f8")
    columns |= {"long": np.ones(3, np.longdouble), "half": np.ones(3, np.float16)}
    columns |= {"other": np.ones(3, ">i4"), "raw": np.array([b"a", b"\xff", b""])}
    columns |= {"void": np.zeros(3, "V4"), "pair": np.zeros(3, "f4,i4")}
    columns |= {"complex": np.ones(3, complex), "day": np.zeros(3, "M8[D]")}
    columns |= {"wide": np.ones(3, ">U2")}
    path = cases.save(columns, tmp_path / "a.npz")
    for suffix in cases.FORMATS:
        summary = decompose_file(
            path, tmp_path / f"b{suffix}", layout=Layout(**BEAM), picture=False
        )
        assert set(summary.left_out) == {"void", "pair", "complex"}
        table = cases.load(summary.table)
        assert (
            table["long"].tolist() == table["half"].tolist() == table["other"].tolist() == [1] * 3
        )
        assert str(table["raw"][1]) == "\\xff"


def test_codes_that_are_no_characters_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    for code in (0x110000, 0xD800, 0xDFFF):
        for count in (1, 3):  # of the texts
            text = np.array([ord("a")] * (3 - count) + [code] * count, np.uint32).view("U1")
            np.savez(path, **cases.planar(3), note=text)
            assert "array 'note' must hold text, got codes that are no characters" in refused(path)
    most = np.array([0xD7FF, 0xE000, 0x10FFFF], np.uint32).view("U1")
    np.savez(path, **cases.planar(3), note=most)
    np.testing.assert_array_equal(read(path, Layout(**BEAM)).carried["note"], most)


def test_columns_of_foreign_types_are_written_to_every_table(tmp_path):
    import datetime
    import decimal

    import pyarrow as pa
    from pyarrow import parquet

    odd = {
        "raw": pa.array([b"a", None, b"\xff"]),
        "day": pa.array([datetime.date(2026, 1, 1)] * 3),
        "hour": pa.array([datetime.time(1)] * 3),
        "none": pa.nulls(3),
        "big": pa.array(["a"] * 3, pa.large_string()),
        "cost": pa.array([decimal.Decimal("1.5")] * 3),
        "listed": pa.array(["a", None, "b"]).dictionary_encode(),
        "when": pa.array([1, None, 2], pa.timestamp("ns", "UTC")),
        "span": pa.array([1, 2, 3], pa.duration("s")),
        "nested": pa.array([[1]] * 3),
    }
    path = tmp_path / "a.parquet"
    parquet.write_table(pa.table(cases.planar(3) | odd), path)
    for suffix in cases.FORMATS:
        summary = decompose_file(
            path, tmp_path / f"b{suffix}", layout=Layout(**BEAM), picture=False
        )
        assert summary.left_out == ("nested",)
        assert set(odd) - {"nested", "cost"} <= set(cases.load(summary.table))
