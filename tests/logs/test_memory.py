"""Memory of reading recorded files does not grow with their length, whatever their format is."""

import gc
import tracemalloc
from pathlib import Path

import pytest

from benchmarks.speed import log_files
from coopenv.logs import Layout
from coopenv.logs.recording import Reader
from tests.logs import cases

CHUNK = 200  # rows at once
ROWS = 3_000
LONGER = 4
ROW_BYTES = 80  # of time, wrenches and twist
SHARE = 0.2  # of what is longer that may be there at once
WHOLE = ".mat before 7.3"  # SciPy reads it so
OTHERS = (WHOLE, ".bag", ".mcap")  # an index of all messages; pieces longer than the files here
KINDS = [each for each in log_files.ALL if not each.picture and each.name not in OTHERS]
STEPS = log_files.LogFile(
    name="filled and resampled",
    write=log_files.joined(".npz"),
    out=".npz",
    layout={
        "files": {"motion": {"path": "motion.npz"}},
        "fill": "linear",
        "longest_gap": 0.01,
        "filters": {"rate": 700.0},
        "sensors": {1: {"tare": {"first": 0.1}}},
    },
)


def peak_of(kind: log_files.LogFile, folder: Path, rows: int) -> float:
    """The most memory that Python, NumPy and pyarrow take to read so many rows [bytes]."""
    import pyarrow as pa

    folder.mkdir()
    path = kind.write(folder, rows)
    gc.collect()
    before, arrow, read = pa.total_allocated_bytes(), 0, 0
    tracemalloc.start()
    try:
        for recording in Reader(path, Layout(grips=log_files.GRIPS, **kind.layout)):
            read += len(recording)
            arrow = max(arrow, pa.total_allocated_bytes() - before)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read > 0.3 * rows
    return peak + arrow


def growth(kind: log_files.LogFile, folder: Path, monkeypatch: pytest.MonkeyPatch) -> float:
    """How much more memory a longer file takes, as a share of what is longer."""
    cases.set_chunk(CHUNK, monkeypatch)
    monkeypatch.setattr(log_files, "CHUNK_ROWS", CHUNK)
    monkeypatch.setattr(log_files, "ANALOG_RATE", 2)
    peak_of(kind, folder / "first", 100)  # what is imported stays
    short, long = (peak_of(kind, folder / f"{n}", n * ROWS) for n in (1, LONGER))
    return (long - short) / ((LONGER - 1) * ROWS * ROW_BYTES)


@pytest.mark.parametrize("kind", [*KINDS, STEPS], ids=lambda kind: kind.name)
def test_a_longer_file_needs_no_more_memory(kind, tmp_path, monkeypatch):
    assert growth(kind, tmp_path, monkeypatch) < SHARE


def test_a_file_that_is_read_whole_is_seen_to_need_more(tmp_path, monkeypatch):
    matlab = next(each for each in log_files.ALL if each.name == WHOLE)
    assert growth(matlab, tmp_path, monkeypatch) > 1 - SHARE
