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
KINDS = {each.name: each for each in log_files.ALL if not each.picture}
WHOLE = ".mat before 7.3"  # SciPy reads it so
ROW_BYTES = 80  # of time, wrenches and twist


def peak_of(kind: log_files.LogFile, folder: Path, rows: int) -> float:
    """The most memory that Python, NumPy and pyarrow take to read so many rows [bytes]."""
    import pyarrow as pa

    folder.mkdir()
    reader = Reader(kind.write(folder, rows), Layout(grips=log_files.GRIPS, **kind.layout))
    gc.collect()
    before, arrow, read = pa.total_allocated_bytes(), 0, 0
    tracemalloc.start()
    try:
        for recording in reader:
            read += len(recording)
            arrow = max(arrow, pa.total_allocated_bytes() - before)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read > 0.5 * rows
    return peak + arrow


def growth(kind: log_files.LogFile, folder: Path) -> tuple[float, float]:
    """Peaks of a short and of a long file [bytes]."""
    peak_of(kind, folder / "first", 100)  # what is imported stays
    return peak_of(kind, folder / "short", ROWS), peak_of(kind, folder / "long", LONGER * ROWS)


@pytest.mark.parametrize("name", [name for name in KINDS if name != WHOLE])
def test_a_longer_file_needs_no_more_memory(name, tmp_path, monkeypatch):
    cases.set_chunk(CHUNK, monkeypatch)
    monkeypatch.setattr(log_files, "CHUNK_ROWS", CHUNK)
    short, long = growth(KINDS[name], tmp_path)
    print(name, short, long)
    assert long - short < 0.2 * (LONGER - 1) * ROWS * ROW_BYTES
