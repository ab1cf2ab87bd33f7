"""A copy of the repository, in which one file at a time is changed and put back."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

LEFT_OUT = shutil.ignore_patterns(
    ".*", "__pycache__", "*.egg-info", "build", "dist", "runs", "node_modules"
)


@dataclass(frozen=True, kw_only=True)
class Project:
    """Where code and tests lie."""

    root: Path
    folders: tuple[str, ...] = ("coopenv", "agents", "rewards")
    tests: str = "tests"
    pinning: str = "tests/test_defaults.py"  # a table of every default and constant

    def modules(self) -> list[str]:
        """Files of the code, relative to the root; what is linked into it belongs elsewhere."""
        return [file for folder in self.folders for file in self._python(folder)]

    def test_files(self) -> list[str]:
        """Files that hold tests, relative to the root."""
        return [file for file in self._python(self.tests) if Path(file).name.startswith("test_")]

    def digest(self) -> str:
        """Twelve letters that change with any file of code."""
        digest = sha256()
        for file in self.modules():
            digest.update(file.encode() + b"\0" + (self.root / file).read_bytes())
        return digest.hexdigest()[:12]

    def _python(self, folder: str) -> list[str]:
        found = []
        for top, folders, files in os.walk(self.root / folder):
            folders[:] = sorted(name for name in folders if name != "__pycache__")
            place = Path(top).relative_to(self.root)
            found += [(place / file).as_posix() for file in sorted(files) if file.endswith(".py")]
        return found


@dataclass(frozen=True, kw_only=True)
class Tree:
    """A copy of a project, and what was compiled in it."""

    project: Project  # the copy
    cache: Path  # numba's, of the unchanged code

    @classmethod
    def copied(cls, project: Project, folder: Path) -> "Tree":
        """The copy in ``folder``, made or brought up to date.

        Times of files are copied too: numba's cache asks for them.
        """
        place, cache = folder / "tree", folder / "numba"
        cache.mkdir(parents=True, exist_ok=True)
        wanted = set(_files(project.root))
        if place.exists():
            for name in set(_files(place)) - wanted:
                (place / name).unlink()
        for name in sorted(wanted):
            _copy(project.root / name, place / name)
        copy = replace(project, root=place)
        return cls(project=copy, cache=cache)

    @contextmanager
    def changed(self, file: str, text: bytes) -> Iterator[Path]:
        """The tree with another text in one file, and a cache that may be written to.

        The file has its old text and time again afterwards, so that what was compiled of the
        unchanged code stays valid. The cache is made of links: numba replaces its files and does
        not write into them.
        """
        path = self.project.root / file
        old, times = path.read_bytes(), path.stat()
        cache = self.cache.with_name("numba.changed")
        shutil.rmtree(cache, ignore_errors=True)
        shutil.copytree(self.cache, cache, copy_function=os.link)
        try:
            path.write_bytes(text)
            yield cache
        finally:
            path.write_bytes(old)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            shutil.rmtree(cache, ignore_errors=True)
            examples = self.project.root / ".hypothesis"  # of failures, which the next would try
            shutil.rmtree(examples, ignore_errors=True)


def _files(root: Path) -> Iterator[str]:
    """Files and links below a folder, but what tools have made there."""
    for top, folders, files in os.walk(root):
        names = [name for name in folders if (Path(top) / name).is_symlink()]
        left_out = LEFT_OUT(top, [*folders, *files])
        folders[:] = [name for name in folders if name not in left_out]
        for name in (*names, *files):
            if name not in left_out:
                yield (Path(top) / name).relative_to(root).as_posix()


def _copy(old: Path, new: Path) -> None:
    """Copy a file or link, unless it is there as it is."""
    if old.is_symlink():
        if not new.is_symlink():
            new.parent.mkdir(parents=True, exist_ok=True)
            new.symlink_to(os.readlink(old))
        return
    times = old.stat()
    if new.exists():
        there = new.stat()
        if (there.st_size, there.st_mtime_ns) == (times.st_size, times.st_mtime_ns):
            return
    new.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(old, new)
