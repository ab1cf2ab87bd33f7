"""Known mutants, each with a reason: equivalent.toml has those that change no behaviour, and others
that are left.

One is known by its file and its lines before and after, so that it may move in the file.
"""

import sys
from functools import cache
from pathlib import Path

from benchmarks.mutants.source import Change, Source

if sys.version_info >= (3, 11):  # not by coopenv.files, since children import coopenv themselves
    import tomllib as toml
else:
    import tomli as toml  # pyright: ignore[reportMissingImports]

LIST = Path(__file__).with_name("equivalent.toml")


@cache
def entries(kind: str, path: Path = LIST) -> dict[tuple[str, str, str], str]:
    """Reasons by file, line before and after, of ``equivalent`` mutants or of those ``left``."""
    found = toml.loads(path.read_text(encoding="utf-8")).get(kind, [])
    return {(one["file"], one["line"], one["changed"]): one["reason"] for one in found}


def reason(change: Change, source: Source, path: Path = LIST) -> str:
    """Why a change is none of behaviour; empty where nobody has said so."""
    return entries("equivalent", path).get((change.file, *change.lines(source.text)), "")
