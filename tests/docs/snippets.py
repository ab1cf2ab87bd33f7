"""Fenced code of README and docs: what a page shows, and running it as its reader would.

Code runs in names of its own and in an empty folder. A block whose first line is ``# name.py`` or
``# name.toml`` is a file, which the page's other blocks find beside them. A block under the mark
``<!-- continues -->`` goes on from the one before it; no other block knows what came before. Below
a command, lines that begin with ``#>`` are some of what it prints.
"""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from tests.docs import recorded
from tests.logs import cases

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))

_FENCE = re.compile(r"(<!-- continues -->\n)?^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# (\w+\.(?:py|toml))\n")


@dataclass(frozen=True, slots=True, kw_only=True)
class Snippet:
    """A fenced block of a page."""

    page: Path
    line: int  # of its first line of code
    language: str
    code: str
    continues: bool

    @property
    def file(self) -> str:
        """The name of the file that the block is, or nothing."""
        found = _FILE.match(self.code)
        kind = {"python": ".py", "toml": ".toml"}.get(self.language, "no file")
        return found[1] if found and found[1].endswith(kind) else ""

    @property
    def place(self) -> str:
        """Page and line, for people."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def snippets(page: Path) -> list[Snippet]:
    """All fenced blocks of a page in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Snippet(
            page=page,
            line=text.count("\n", 0, found.start(3)) + 1,
            language=found[2],
            code=found[3],
            continues=bool(found[1]),
        )
        for found in _FENCE.finditer(text)
    ]


def chains(page: Path) -> list[list[Snippet]]:
    """Python blocks that run together: each with those that continue it. Files are in none."""
    made: list[list[Snippet]] = []
    for snippet in snippets(page):
        if snippet.language != "python" or snippet.file:
            continue
        if snippet.continues:
            made[-1].append(snippet)
        else:
            made.append([snippet])
    return made


def lay_out(page: Path, folder: Path) -> None:
    """Write what a page's reader has: the files that it shows, and recorded trials."""
    columns = cases.planar(40)
    cases.save(columns, folder / "trial.csv")
    if "motion.csv" in page.read_text(encoding="utf-8"):  # of a trial, a file a device
        for i, name in enumerate(("left", "right"), 1):
            own = {each: columns[each] for each in ("time", f"f{i}x", f"f{i}y", f"t{i}z")}
            own |= {f"r{i}x": np.full(40, 1.8 * i - 2.7), f"r{i}y": np.zeros(40)}
            cases.save(own, folder / f"{name}.csv")
        pose = {each: columns[each] for each in ("time", "x", "y", "theta")}
        cases.save(pose, folder / "motion.csv")
    for snippet in snippets(page):
        if snippet.file:
            (folder / snippet.file).write_text(snippet.code, encoding="utf-8")


def printed(snippet: Snippet, command: str) -> list[str]:
    """Lines below a command of a block that say what it prints."""
    lines = snippet.code.splitlines()
    after = lines[lines.index(command) + 1 :]
    return [line.removeprefix("#>") for line in takewhile(lambda each: each[:2] == "#>", after)]


@contextmanager
def running(chain: list[Snippet], folder: Path) -> Iterator[dict[str, Any]]:
    """Run blocks one after the other in ``folder``; yields their names, then undoes the rest."""
    page, names = chain[0].page, {"__name__": "__main__"}
    lay_out(page, folder)
    recorded.lay_out("".join(snippet.code for snippet in chain), folder)
    path, modules, ids = list(sys.path), set(sys.modules), set(gymnasium.registry)
    sys.path.insert(0, str(folder))
    before = Path.cwd()
    os.chdir(folder)
    try:
        for snippet in chain:
            code = "\n" * (snippet.line - 1) + snippet.code  # tracebacks name the page's line
            exec(compile(code, str(page), "exec"), names)
        yield names
    finally:
        os.chdir(before)
        sys.path[:] = path
        for name in set(gymnasium.registry) - ids:
            del gymnasium.registry[name]
        for snippet in snippets(page):
            if (name := snippet.file.removesuffix(".py")) not in modules:
                sys.modules.pop(name, None)
