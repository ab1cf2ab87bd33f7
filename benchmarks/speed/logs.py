"""CPU time and memory of decomposing recorded files of each kind.

    python -m benchmarks.speed.logs [rows]     # prints them
    python -m benchmarks.speed.logs --write    # and puts them on docs/recordings.md
    python -m benchmarks.speed.logs --only .mcap .db3 --write    # of some kinds
    python -m benchmarks.speed.logs --long --write    # only memory, of longer files of a few kinds

Each line is that of a process of its own, which decomposes three files of two planar effectors: one
of a thousand rows to load and compile everything, a tenth of the rows, and all of them for the
clock. Of ROS bags these are messages of three topics, not rows. The memory is the largest that the
process ever took, as Linux counts it, above what it took for the smallest file.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks import recordings
from benchmarks.pages import cells, fill, markdown
from benchmarks.speed.log_files import ALL, GRIPS, LogFile

ROWS = 1_000_000
FEW = 1_000
LONG = (400_000, 1_000_000, 4_000_000)  # rows, by which the samples of the summary are full
LONG_KINDS = (".csv", ".csv.gz")
MIB = 1024  # [KiB]


def measure(kind: LogFile, rows: tuple[int, ...]) -> tuple[float, list[float]]:
    """CPU seconds of the longest of files, and memory for each above that for a small one [MiB]."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for count in (FEW, *rows):
            (Path(folder) / f"{count}").mkdir()
            files.append(str(kind.write(Path(folder) / f"{count}", count)))
        command = [sys.executable, "-m", "benchmarks.speed.logs", "--child", kind.name, *files]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    cpu, first, *peaks = json.loads(done.stdout)
    return cpu, [peak - first for peak in peaks]


def child(name: str, files: list[str]) -> None:
    """Decompose the files one after the other; print the CPU time of the last and all peaks."""
    import time

    from coopenv.logs import Layout, decompose_file

    kind = next(each for each in ALL if each.name == name)
    layout = Layout(grips=GRIPS, **kind.layout)
    cpu, peaks = 0.0, []
    for path in files:
        used = time.process_time()
        out = Path(path).parent / f"out{kind.out}"
        decompose_file(path, out, layout=layout, picture=kind.picture)
        cpu = time.process_time() - used
        peaks.append(_peak())
    print(json.dumps([cpu, *peaks]))


def _peak() -> float:
    """The most memory of this program so far [MiB]; not that of the one which started it."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(status.split("VmHWM:")[1].split()[0]) / MIB


def tables(rows: int = ROWS, kinds: tuple[LogFile, ...] = ALL) -> tuple[list[str], list[list[str]]]:
    """Columns and rows of what this module measures."""
    lines = []
    for kind in kinds:
        cpu, (tenth, whole) = measure(kind, (rows // 10, rows))
        lines.append([kind.name, kind.out, f"{cpu:.1f}", f"{tenth:.0f}", f"{whole:.0f}"])
        print(*lines[-1], sep="\t", file=sys.stderr, flush=True)
    columns = ["file", "table", "CPU s", f"{rows // 10:,} rows [MiB]", f"{rows:,} rows [MiB]"]
    return columns, lines


def longer(kinds: tuple[LogFile, ...]) -> tuple[list[str], list[list[str]]]:
    """Columns and rows of the memory that longer files take."""
    lines = []
    for kind in (each for each in kinds if each.name in LONG_KINDS):
        lines.append([kind.name, kind.out, *(f"{peak:.0f}" for peak in measure(kind, LONG)[1])])
        print(*lines[-1], sep="\t", file=sys.stderr, flush=True)
    return ["file", "table", *(f"{rows:,} rows [MiB]" for rows in LONG)], lines


def main() -> None:
    """Print the table; with ``--write`` also put it on the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("rows", nargs="?", type=int, default=ROWS)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--only", nargs="+", default=[each.name for each in ALL])
    parser.add_argument("--child", nargs="+", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.child:
        child(args.child[0], args.child[1:])
        return
    kinds = tuple(kind for kind in ALL if kind.name in args.only)
    columns, lines = longer(kinds) if args.long else tables(args.rows, kinds)
    print(markdown(columns, lines))
    if args.write:
        mark = "long" if args.long else "speed"
        known = {line[0]: line for line in (*cells(recordings.PAGE, mark)[1:], *lines)}
        kept = [known[kind.name] for kind in ALL if kind.name in known]
        fill(recordings.PAGE, {mark: markdown(columns, kept)})


if __name__ == "__main__":
    main()
