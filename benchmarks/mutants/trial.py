"""One mutant: run the tests that reach it until one fails, and say what came of it."""

import os
import signal
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.mutants.child import Child, Ended
from benchmarks.mutants.reach import Selected, within
from benchmarks.mutants.recording import OPTIONS, without_parameters
from benchmarks.mutants.source import Change
from benchmarks.mutants.tree import Tree

FIRST = 8.0  # [s] of tests that run first; most mutants are caught by them
LIMIT = 240.0  # [s] of CPU beyond ten times what a test takes: kernels may have to be compiled
WALL = 3600.0  # [s] for all tests of a mutant


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What came of a mutant."""

    status: str  # caught, survived, unreached
    by: str = ""  # the test that caught it
    how: str = ""  # failed, timed out, crashed
    ran: int = 0  # tests, or files of tests that are not recorded, that ran
    reached_by: int = 0  # of how many
    tests: tuple[str, ...] = ()  # that ran
    cpu: float = 0.0  # [s]

    def as_json(self) -> dict[str, Any]:
        """Its fields by name."""
        return asdict(self)


def tried(tree: Tree, change: Change, text: bytes, tests: Sequence[Selected]) -> Verdict:
    """Run tests on the changed tree until one fails."""
    if not tests:
        return Verdict(status="unreached")
    early = within(tests, FIRST)
    how, failed, cpu = "", "", 0.0
    with tree.changed(change.file, change.applied(text)) as cache:
        for part in filter(None, (early, tests[len(early) :])):
            ended, failed = run(tree, part, cache)
            cpu += ended.cpu
            how = _how(ended)
            if how:
                break
    return Verdict(
        status="caught" if how else "survived",
        by=failed if how else "",
        how=how,
        ran=len(tests),
        reached_by=len(tests),
        tests=() if how else tuple(one.test for one in tests),
        cpu=round(cpu, 1),
    )


def run(tree: Tree, tests: Sequence[Selected], cache: Path) -> tuple[Ended, str]:
    """Run tests in a child until one fails; how it ended, and which test it ended in."""
    note = cache.with_name("running")
    note.write_text("", encoding="utf-8")
    root = tree.project.root
    child = Child(
        lambda: _pytest(root, tests, note), tree=root, cache=cache, log=cache.with_name("log.txt")
    )
    return child.wait(WALL), note.read_text(encoding="utf-8")


def _how(ended: Ended) -> str:
    """How the mutant was caught; empty where all tests passed."""
    if ended.signal is not None:
        slow = ended.signal in (signal.SIGPROF, signal.SIGALRM)
        return "timed out" if slow else "crashed"
    if ended.code in (0, 5):  # passed, or all tests of a file are left to slow runs
        return ""
    if ended.code == 70:
        raise RuntimeError("the child must run pytest, and broke off; see log.txt")
    return "failed"


class _Watch:
    """A pytest plugin that notes which test runs, and ends endless ones."""

    def __init__(self, tests: Sequence[Selected], note: Path) -> None:
        self.seconds = {one.test: one.seconds for one in tests}
        self.note = note

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.note.write_text(nodeid, encoding="utf-8")
        expected = self.seconds.get(without_parameters(nodeid), 0.0)
        signal.setitimer(signal.ITIMER_PROF, LIMIT + 10 * expected)

    def pytest_runtest_logfinish(self) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _pytest(root: Path, tests: Sequence[Selected], note: Path) -> int:
    import sys

    import pytest

    sys.dont_write_bytecode = True  # the changed file could pass for the old one in its second
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    signal.setitimer(signal.ITIMER_PROF, LIMIT)  # an import may be endless too
    names = [one.test for one in tests]
    places = [f"--rootdir={root}", f"--basetemp={note.with_name('tmp')}"]
    return int(pytest.main([*OPTIONS, "-x", *places, *names], plugins=[_Watch(tests, note)]))
