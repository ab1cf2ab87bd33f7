"""Campaign of damaged files of every format that coopenv reads.

A damaged file is read whole or answered with one sentence by an error of coopenv's; nothing is left
beside it. A damaged cache of compiled code is made anew.
"""

import warnings
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.soak.commands import compiling
from benchmarks.soak.commands.server import server
from benchmarks.soak.damage.mutations import damaged
from benchmarks.soak.damage.readers import READERS, Reader
from coopenv.errors import CoopenvError
from tests.reliability import damaged as recordings

NAME = "damaged"
SHARE = 0.06
FILES = 12  # a trial
CACHE = 0.05  # of the trials are about the cache of compiled code
RECORDINGS = 0.4  # about recordings and layouts, of every format that is read


def warm_up() -> None:
    """Read every kind of file once, whole: readers import torch, pyarrow and the like."""
    for reader in READERS:
        with TemporaryDirectory() as folder:
            assert not is_refused(reader, reader.whole(), Path(folder)), reader.name


def trial(seed: int, folder: Path) -> dict[str, int]:
    """A few damaged files of one kind."""
    rng = np.random.default_rng([4, seed])
    if rng.random() < CACHE:
        return _damage_cache(rng, folder)
    if rng.random() < RECORDINGS:
        return _damage_recordings(seed, folder)
    reader = READERS[rng.integers(len(READERS))]
    refused = 0
    for number in range(FILES):
        place = folder / str(number)
        place.mkdir()
        content = damaged(reader.whole(), rng, Path(reader.file).suffix)
        refused += is_refused(reader, content, place)
        rmtree(place)
    return {"damaged_files": FILES, "refused_files": refused}


def _damage_recordings(seed: int, folder: Path) -> dict[str, int]:
    """Files of as many formats, also of those that are read alone: MATLAB, HDF5, bags, C3D."""
    for number in range(FILES * seed, FILES * (seed + 1)):
        path = recordings.damaged(number, folder)
        recordings.check(path)
        recordings.remove(path)
    return {"damaged_files": FILES}


def is_refused(reader: Reader, content: bytes, folder: Path) -> bool:
    """Whether a sentence says that the file is damaged; raise where it is answered otherwise."""
    path = folder / reader.file
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            reader.read(path)
        except CoopenvError as error:
            said = str(error)
        except AssertionError:
            raise
        except Exception as error:
            kind = type(error).__name__
            raise AssertionError(f"a damaged {reader.file} raises {kind}: {error}") from error
        else:
            return False
    assert len(said.splitlines()) == 1, f"a damaged {reader.file} is told in lines: {said!r}"
    left = [each.name for each in folder.rglob("*") if each.name.startswith((".", "out"))]
    assert not left, f"a damaged {reader.file} leaves {', '.join(left)}"
    return True


def _damage_cache(rng: np.random.Generator, folder: Path) -> dict[str, int]:
    """Cut, empty or overwrite files of a compile cache, again and again."""
    task = compiling.task(folder)
    compiling.check(server().run(task))
    changed = 0
    for _ in range(3):
        files = compiling.cache_files(folder)
        for k in rng.permutation(len(files))[: rng.integers(1, 4)]:
            path = files[k]
            path.write_bytes(_ruined(path.read_bytes(), rng))
            changed += 1
        compiling.check(server().run(task))
        compiling.check(server().run(task))  # healed, it comes from the cache
    return {"damaged_files": changed}


def _ruined(content: bytes, rng: np.random.Generator) -> bytes:
    """Half a file, none, zeros or noise; a flipped bit in machine code could not be told."""
    half = content[: int(rng.integers(len(content) + 1))]
    return (half, b"", bytes(len(content)), rng.bytes(len(content)))[rng.integers(4)]
