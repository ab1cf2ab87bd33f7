"""Files are opened by the suffix of their name, and every format has a reader and a writer."""

import gc
import os
import sys
import tempfile
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from coopenv.errors import InvalidInput
from coopenv.files import written
from coopenv.logs import Layout, formats, read
from coopenv.logs.formats.chunks import Wanted
from coopenv.logs.recording import Reader
from tests.logs import cases, devices, kinds


@pytest.fixture(autouse=True)
def _extra():
    pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")


def test_every_format_is_among_those_that_are_tested():
    assert [known.suffixes[0] for known in formats.FORMATS] == list(cases.FORMATS)


def test_no_suffix_has_two_formats():
    suffixes = [suffix for known in formats.FORMATS for suffix in known.suffixes]
    assert len(set(suffixes)) == len(suffixes)
    assert all(suffix == suffix.lower() for suffix in suffixes)


@pytest.mark.parametrize("known", formats.FORMATS, ids=lambda known: known.suffixes[0])
def test_reader_and_writer_are_in_one_file(known):
    assert known.source.__module__ == known.sink.__module__


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_what_is_written_in_pieces_is_read_back_in_pieces(suffix, tmp_path, monkeypatch):
    columns = cases.planar(30) | {"who": np.repeat(["ann", "b, c", 'd "e"'], 10).astype(object)}
    columns["f1x"][7] = np.nan
    path = tmp_path / f"a{suffix.upper()}"
    monkeypatch.setattr("coopenv.logs.formats.text.WRITTEN", 7)
    sink = formats.open_sink(path)
    for rows in (slice(0, 1), slice(1, 20), slice(20, 30)):
        sink.write({name: values[rows] for name, values in columns.items()})
    sink.close()
    cases.set_chunk(7, monkeypatch)
    source = formats.open_source(path)
    numbers = [name for name in columns if name != "who"]
    assert sorted(source.columns) == sorted(columns)
    chunks = list(source.chunks(Wanted(numbers, ["who"])))
    assert len(chunks) > 2
    for name in numbers:
        read = np.concatenate([chunk.numbers[name] for chunk in chunks])
        np.testing.assert_array_equal(read, columns[name], err_msg=name)
    assert [who for chunk in chunks for who in chunk.carried["who"]] == columns["who"].tolist()
    assert [chunk.first_row for chunk in chunks] == [
        1 + sum(chunk.rows for chunk in chunks[:k]) for k in range(len(chunks))
    ]
    assert all(chunk.whole.all() and len(chunk.whole) == chunk.rows for chunk in chunks)
    progress = [chunk.progress for chunk in chunks]
    assert progress == sorted(progress)
    assert progress[-1] == 1.0


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_a_table_that_is_abandoned_can_be_deleted(suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    for pieces in (0, 1):
        sink = formats.open_sink(path)
        for _ in range(pieces):
            sink.write(cases.planar(3))
        sink.abandon()
        path.unlink(missing_ok=True)
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_the_memory_of_a_table_does_not_grow_with_the_rows_that_are_written(suffix, tmp_path):
    peaks = []
    for pieces in (8, 24):
        tracemalloc.start()
        sink = formats.open_sink(tmp_path / f"a{pieces}{suffix}")
        for _ in range(pieces):
            sink.write({name: np.random.default_rng(0).random(20_000) for name in ("time", "f1x")})
        sink.close()
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.3 * peaks[0]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked there")
def test_columns_that_wait_where_every_file_has_a_name_are_swept_with_their_table(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(tempfile, "_O_TMPFILE_WORKS", False, raising=False)  # as on a network disk
    table = tmp_path / "table.npz"
    child = os.fork()
    if not child:
        with written(table) as part:
            monkeypatch.setattr(os, "unlink", lambda *_, **__: os.kill(os.getpid(), 9))
            formats.open_sink(part).write({"x": np.zeros(2)})
        os._exit(1)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == 9
    assert len(list(tmp_path.iterdir())) == 2
    with written(table):
        pass
    assert [each.name for each in tmp_path.iterdir()] == ["table.npz"]


@pytest.mark.parametrize("version", [(1, 0), (2, 0)])  # NumPy takes the latter where much is said
def test_arrays_of_either_version_are_read(version, tmp_path):
    path, columns = tmp_path / "a.npz", cases.planar(3)
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in columns.items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, np.asarray(values), version)
    found = read(path, Layout(grips=cases.BEAM))
    np.testing.assert_array_equal(found.applied[:, 1, 2], columns["t2z"])


def test_an_unknown_suffix_is_answered_with_those_that_are_known(tmp_path):
    with pytest.raises(InvalidInput, match=r"one of \.csv, \.tsv, \.txt, .* got 'a\.xlsx'"):
        formats.open_sink(tmp_path / "a.xlsx")
    assert formats.find_format(Path("a.TXT")).sink is formats.find_format(Path("a.csv")).sink


def test_a_bag_that_is_not_read_to_its_end_is_closed_without_a_word(tmp_path, monkeypatch):
    pytest.importorskip("rosbags")
    said = []
    monkeypatch.setattr(sys, "unraisablehook", said.append)
    cases.set_chunk(2, monkeypatch)
    path = devices.rosbag2(kinds.recorded(), tmp_path, "SQLITE3")
    reader = Reader(path, Layout(grips=cases.BEAM, **devices.OF_TOPICS))
    assert len(next(iter(reader))) == 2
    del reader
    gc.collect()
    assert not said
