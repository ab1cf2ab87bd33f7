"""Rows per second and memory of decomposing recorded files.

    python -m benchmarks.speed.logs [rows]     # prints them
    python -m benchmarks.speed.logs --write    # and puts them on docs/recordings.md

Each figure is that of a process of its own, which decomposes a file of two planar effectors with
time and twist, once small to load and compile everything, then for the clock. The memory is the
largest that the process ever took, beside that of the same process after the small file.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks import recordings
from benchmarks.pages import fill, markdown
from coopenv.logs.formats import FORMATS, open_sink
from coopenv.logs.formats.chunks import CHUNK_ROWS

ROWS = 1_000_000
ON_PAGE = ("file", "CPU s", "above a small file [MiB]")  # the clock counts other work too
BEAM = "(-0.9, 0.0, 0.9, 0.0)"
CHILD = f"""
import json, resource, sys, time
from coopenv.logs import Layout, decompose_file
small, large, out, picture = sys.argv[1:]
def run(path):
    decompose_file(path, out, layout=Layout(grips={BEAM}), picture=picture == "True")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
before = run(small)
began, used = time.perf_counter(), time.process_time()
peak = run(large)
print(json.dumps([time.perf_counter() - began, time.process_time() - used, peak, before]))
"""


def write(path: Path, rows: int) -> None:
    """A recording of random wrenches as a file of the format its name asks for.

    In pieces, as a process's largest memory counts that of the process which starts it.
    """
    rng = np.random.default_rng(0)
    names = ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z", "vx", "vy", "omega")
    sink = open_sink(path)
    for first in range(0, rows, CHUNK_ROWS):
        time = np.arange(first, min(first + CHUNK_ROWS, rows)) / 1000
        drawn = {name: rng.normal(size=len(time)).round(6) for name in names}
        sink.write({"time": time, **drawn})
    sink.close()


def measure(folder: Path, suffix: str, rows: int, picture: bool) -> tuple[float, ...]:
    """Seconds, CPU seconds, largest memory and that of a small file [MiB]."""
    small, large = folder / f"small{suffix}", folder / f"large{suffix}"
    for path, count in ((small, 1000), (large, rows)):
        if not path.exists():
            write(path, count)
    out = folder / f"out{suffix}"
    command = [sys.executable, "-c", CHILD, str(small), str(large), str(out), str(picture)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return tuple(json.loads(done.stdout))


def tables(rows: int = ROWS) -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for suffix in [known.suffixes[0] for known in FORMATS]:
            for picture in (False, True):
                seconds, cpu, peak, before = measure(Path(folder), suffix, rows, picture)
                lines.append(
                    [
                        f"{suffix} to {suffix}" + ", with picture" * picture,
                        f"{rows / seconds:,.0f}",
                        f"{seconds:.1f}",
                        f"{cpu:.1f}",
                        f"{peak:.0f}",
                        f"{peak - before:.0f}",
                    ]
                )
    columns = ["file", "rows/s", "s", "CPU s", "peak [MiB]", "above a small file [MiB]"]
    return [(f"Recorded files, {rows:,} rows, pair on its axis", columns, lines)]


def main() -> None:
    """Print the table; with ``--write`` also put it on the page."""
    from rich.console import Console
    from rich.table import Table

    rows = [int(word) for word in sys.argv[1:] if word != "--write"]
    for title, columns, lines in tables(*rows):
        table = Table(*columns, title=title, title_justify="left")
        for line in lines:
            table.add_row(*line)
        Console().print(table)
        if "--write" in sys.argv[1:]:
            kept = [columns.index(name) for name in ON_PAGE]
            on_page = [[line[j] for j in kept] for line in lines]
            fill(recordings.PAGE, {"speed": markdown(ON_PAGE, on_page)})


if __name__ == "__main__":
    main()
