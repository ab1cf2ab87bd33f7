"""Damaged recordings and layouts by seed, and the check that each is answered with a sentence.

``check(damaged(seed, folder))`` is one trial of the campaign. What comes of a seed is the same on
every run: a file of one of many kinds, wrong in what it holds, in its bytes, or both.
"""

import shutil
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import CoopenvError
from coopenv.logs import Layout, decompose_file, read
from tests.logs import cases
from tests.reliability import faulty, whole

KINDS: tuple[tuple[str, Callable[[np.random.Generator], whole.Made]], ...] = (
    (".csv", faulty.text),
    (".npz", lambda rng: faulty.archive(rng, compressed=False)),
    (".npz", lambda rng: faulty.archive(rng, compressed=True)),
    (".parquet", faulty.parquet),
    (".toml", lambda rng: faulty.layout(rng, toml=True)),
    (".json", lambda rng: faulty.layout(rng, toml=False)),
    *((suffix, make) for suffix, make, _ in whole.WHOLE),
)
NAMES = (
    "csv", "npz stored", "npz deflated", "parquet", "toml", "json", "csv.gz", "mat 5", "mat 4",
    "mat 7.3", "h5", "mcap", "db3", "rosbag2 folder", "bag", "c3d",
)  # fmt: skip
NEEDS = (*["pyarrow"] * (len(KINDS) - len(whole.WHOLE)), *(each[2] for each in whole.WHOLE))
INSERTED = (b"\0", b"\r", b"\n", b'"', b"\xef\xbb\xbf", b"\xff\xfe", b",", b";", b"\x00" * 40,
            b"PK\x01\x02", b"PAR1", b"9" * 300, b"{" * 50, b"e99999", b"-")  # fmt: skip
DECLARED: tuple[dict[str, Any], ...] = (
    {},
    {"force": "kN", "torque": "N*mm", "time": "ms"},
    {"frame": "world", "grip_frame": "world"},
    {"angle": "deg", "angular_velocity": "rpm"},
    {"space": "plane"},
    {"decimal": ","},
)
LONGEST = 6000  # [characters] of an answer


def damaged(seed: int, folder: Path) -> Path:
    """A file that is wrong in some way, of the kind that the seed has; the same for every run."""
    suffix = KINDS[seed % len(KINDS)][0]
    path = Path(folder) / f"damaged-{seed}{suffix}"
    made, _ = _content(seed)
    if isinstance(made, dict):
        path.mkdir()
        for name, data in made.items():
            (path / name).write_bytes(data)
    else:
        path.write_bytes(made)
    return path


def is_damaged(seed: int) -> bool:
    """Whether bytes of that file are others than those that were written at first."""
    return _content(seed)[1]


def _content(seed: int) -> tuple[whole.Made, bool]:
    """What the seed makes, a file or those of a folder, and whether its bytes were changed."""
    rng = np.random.default_rng([seed, 20261129])
    made = KINDS[seed % len(KINDS)][1](rng)
    files = {name: bytearray(each) for name, each in _files(made).items()}
    right = seed % len(KINDS) >= len(KINDS) - len(whole.WHOLE)  # as it is made
    shares = [0.1, 0.5, 0.3, 0.1] if right else [0.5, 0.3, 0.15, 0.05]
    for _ in range(int(rng.choice([0, 1, 2, 8], p=shares))):
        names = sorted(files)
        _damage(files[names[int(rng.integers(len(names))) if len(names) > 1 else 0]], rng)
    now = {name: bytes(each) for name, each in files.items()}
    return (now if isinstance(made, dict) else now[""]), now != _files(made)


def _files(made: whole.Made) -> dict[str, bytes]:
    return made if isinstance(made, dict) else {"": made}


def remove(path: Path) -> None:
    """Take a file or a folder away again."""
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()


def _damage(data: bytearray, rng: np.random.Generator) -> None:
    """Change bytes somewhere; more often near the ends, where formats describe themselves."""
    size = len(data)
    if not size:
        return
    near = rng.random()
    low, high = (0, min(200, size)) if near < 0.3 else (max(size - 400, 0), size)
    at = int(rng.integers(low, high) if near < 0.6 else rng.integers(size))
    kind, length = int(rng.integers(7)), int(rng.integers(1, 60))
    if kind == 0:
        del data[at:]
    elif kind == 1:
        data[at] ^= 1 << int(rng.integers(8))
    elif kind == 2:
        data[at : at + length] = rng.bytes(length)
    elif kind == 3:
        data[at:at] = INSERTED[int(rng.integers(len(INSERTED)))]
    elif kind == 4:
        del data[at : at + length]
    elif kind == 5:
        data[at:at] = data[at : at + length]
    else:
        data[at : at + length] = bytes([int(rng.choice([0, 255]))]) * len(data[at : at + length])


def check(path: Path) -> None:
    """Raise `AssertionError`, with how to see it again, unless a file is read or refused in words.

    A refusal is one `CoopenvError` of one line that names the file and leaves nothing behind;
    otherwise table and summary are there, and are removed again.
    Nobody else may use the folder meanwhile.
    """
    path = Path(path)
    before = sorted(path.parent.rglob("*"))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            made = use(path)
    except CoopenvError as error:
        problem = _wrong_answer(str(error), path)
    except Exception as error:
        problem = f"raised {type(error).__name__}: {error}"
    else:
        problem = "" if all(each.is_file() for each in made) else "wrote nothing"
        for each in made:
            each.unlink(missing_ok=True)
    left = sorted(set(path.parent.rglob("*")) - set(before))
    if left:
        problem = problem or f"left {[each.name for each in left]} behind"
    if problem:
        raise AssertionError(f"{path.name}: {problem[:2000]}\n{_reproduction(path)}")


def use(path: Path) -> list[Path]:
    """Do with a file what a user would; returns what was written."""
    if path.suffix in (".toml", ".json"):
        layout = Layout.load(path)
        with tempfile.TemporaryDirectory() as folder:
            columns = cases.planar(3) | {"trial": np.ones(3)}
            read(cases.save(columns, Path(folder) / path.with_suffix(".npz").name), layout)
        return []
    turn = sum(path.name.encode())
    bad_rows = "error" if turn % 3 else "skip"
    known = whole.LAYOUTS.get(path.suffix)
    layout = Layout(**DECLARED[turn % len(DECLARED)])
    if known is not None:
        grips = (1.0, 0.0, -1.0, 0.0)
        layout = Layout(grips=grips, **known[turn % len(known)])
    elif path.suffix == ".gz":
        layout = Layout(grips=(1.0, 0.0, -1.0, 0.0))
    summary = decompose_file(path, layout=layout, bad_rows=bad_rows, picture=False)
    return [summary.table, summary.written]


def _wrong_answer(said: str, path: Path) -> str:
    """What a refusal lacks, if anything."""
    wrong = {
        "is of several lines": "\n" in said,
        "does not name the file": path.stem not in said,
        "has no remedy": ";" not in said,
        "is too long": len(said) > LONGEST,
    }
    found = [what for what, so in wrong.items() if so]
    return f"said {said!r}, which {', '.join(found)}" if found else ""


def _reproduction(path: Path) -> str:
    seed = path.stem.removeprefix("damaged-")
    return (
        "again: python -c 'from pathlib import Path; from tests.reliability.damaged import *; "
        f'check(damaged({seed}, Path("/tmp")))\''
    )
