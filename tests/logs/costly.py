"""Files that would cost much if they were believed, and what it costs to refuse them all.

A program of its own, since memory is measured for a whole process: it prints what each file was
answered, how much memory was needed beyond that for a small file [MiB], and the CPU time [s].
"""

import json
import resource
import sys
import zipfile
from pathlib import Path

from coopenv.errors import CoopenvError
from coopenv.logs import Layout, decompose_file
from tests.reliability.faulty import header

SIZE = 100  # [MiB] of what a file holds, or inflates to
MIB = 1 << 20
LAYOUT = Layout(grips=(0.0, 0.0))


def text(path: Path, begin: bytes, filling: bytes, end: bytes = b"") -> None:
    """A text file, mostly of one thing."""
    with path.open("wb") as file:
        for part in (begin, *[filling * (MIB // len(filling))] * SIZE, end):
            file.write(part)


def archive(path: Path, name: str, begin: bytes, method: int = zipfile.ZIP_DEFLATED) -> None:
    """An archive of one array that is mostly zeros."""
    with (
        zipfile.ZipFile(path, "w", method, compresslevel=1) as made,
        made.open(f"{name}.npy", "w") as file,
    ):
        for part in (begin, *[bytes(MIB)] * SIZE):
            file.write(part)


def make(folder: Path) -> list[Path]:
    """All of them."""
    text(folder / "long-cell.csv", b"f1x,f1y,t1z\n1,2,", b"7")
    text(folder / "long-quoted-cell.csv", b'f1x,f1y,t1z\n1,2,"', b"7", b'"')
    text(folder / "long-header.csv", b"f1x,", b"abc,")
    (folder / "many-columns.csv").write_text(",".join(f"c{k}" for k in range(120_000)))
    (folder / "effector.csv").write_text("f1x,f1y,f999999999x\n1,2,3")
    archive(folder / "effectors.npz", "force", header("'<f8'", "(1, 5000000, 2)"))
    archive(folder / "fortran.npz", "force", header("'<f8'", "(5, 1000000, 2)", fortran=True))
    archive(folder / "grips.npz", "grips", header("'<f8'", "(5000000, 2)"))
    archive(folder / "array-header.npz", "f1x", b"\x93NUMPY\x02\x00\xff\xff\xff\x7f")
    archive(folder / "bzip2.npz", "f1x", header("'<f8'", "(10,)"), zipfile.ZIP_BZIP2)
    return sorted(folder.iterdir())


def main(folder: Path) -> None:
    """Make them, read them, print."""
    files = make(folder)
    right = folder / "right.csv"
    right.write_text("f1x,f1y,t1z\n1,2,3\n")
    decompose_file(right, layout=LAYOUT, picture=False)
    before = resource.getrusage(resource.RUSAGE_SELF)
    said = {}
    for path in files:
        try:
            decompose_file(path, layout=LAYOUT, picture=False)
        except CoopenvError as error:
            said[str(path)] = str(error)
    after = resource.getrusage(resource.RUSAGE_SELF)
    grown = (after.ru_maxrss - before.ru_maxrss) / 1024  # from KiB
    print(json.dumps([said, grown, after.ru_utime - before.ru_utime]))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
