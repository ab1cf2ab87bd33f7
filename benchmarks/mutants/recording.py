"""Which tests run which lines of Python, and how long they take: one recorded run of the suite.

Every file of tests is run once in a child of its own under coverage, and leaves a JSON file.
"""

import json
import time
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from typing import Any

from benchmarks.mutants.child import Child
from benchmarks.mutants.tree import Tree

WALL = 3600.0  # [s] for a file of tests
RAN = (0, 1, 5)  # pytest's codes of a run: all passed, some failed, none was chosen
OPTIONS = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--hypothesis-seed=0"]


@dataclass(kw_only=True)
class Recording:
    """What a run of the suite did. A test is named by file and function, without parameters."""

    seconds: dict[str, float] = field(default_factory=dict)  # CPU time of tests that passed
    lines: dict[str, dict[int, set[str]]] = field(default_factory=dict)  # file, line → tests
    failed: list[str] = field(default_factory=list)  # in the unchanged code
    files: set[str] = field(default_factory=set)  # files of tests that are in it

    def add(self, file: str, record: Mapping[str, Any]) -> None:
        """Take in what a file of tests left."""
        self.files.add(file)
        outcomes = record["outcomes"]
        passed = {test for test, outcome in outcomes.items() if outcome == "passed"}
        self.failed += sorted(test for test, outcome in outcomes.items() if outcome == "failed")
        self.seconds |= {test: record["seconds"][test] for test in passed}
        for seen_file, lines in record["lines"].items():
            seen = self.lines.setdefault(seen_file, {})
            for line, tests in lines.items():
                seen.setdefault(int(line), set()).update(passed.intersection(tests))


class Recorder:
    """Records of a tree's files of tests, in a folder; what is missing is run when it is asked for.

    A record holds as long as its file of tests is the same; a folder is for one state of the code.
    """

    def __init__(self, tree: Tree, folder: Path) -> None:
        self.tree = tree
        self.folder = folder
        self.recording = Recording()
        folder.mkdir(parents=True, exist_ok=True)
        for file in tree.project.test_files():
            self._read(file)

    def missing(self) -> list[str]:
        """Files of tests without a record."""
        files = self.tree.project.test_files()
        return [file for file in files if file not in self.recording.files]

    def complete(self, files: Iterable[str], jobs: int = 1, twice: bool = False) -> None:
        """Record the files, ``jobs`` at a time.

        With ``twice`` a file is recorded again if kernels were compiled while it ran, so that its
        seconds are those of its tests.
        """
        waiting = list(files)
        running: dict[str, Child] = {}
        total, done = len(waiting), 0
        again = set(waiting) if twice else set()
        compiled: dict[str, int] = {}
        while waiting or running:
            while waiting and len(running) < jobs:
                file = waiting.pop(0)
                compiled[file] = self._compiled()
                running[file] = self._child(file)
            for file, child in [*running.items()]:
                ended = child.poll(WALL)
                if ended is None:
                    continue
                del running[file]
                if file in again and self._compiled() > compiled[file]:
                    again.remove(file)
                    waiting.append(file)
                    continue
                done += 1
                print(f"recorded {done}/{total} {file} {ended.cpu:.0f} s", flush=True)
                if not self._read(file):
                    log = self._path(file).with_suffix(".log")
                    raise RuntimeError(f"{file} must leave a record, got none; see {log}")
            time.sleep(0.05)

    def _compiled(self) -> int:
        """How many files numba has in its cache."""
        return sum(1 for _ in self.tree.cache.rglob("*.nbc"))

    def _path(self, file: str) -> Path:
        return self.folder / (file.replace("/", "+") + ".json")

    def _child(self, file: str) -> Child:
        path = self._path(file)
        return Child(
            lambda: record(self.tree, file, path),
            tree=self.tree.project.root,
            cache=self.tree.cache,
            log=path.with_suffix(".log"),
        )

    def _read(self, file: str) -> bool:
        """Take in the record of a file, if there is one that holds."""
        try:
            found = json.loads(self._path(file).read_text(encoding="utf-8"))
        except FileNotFoundError:
            return False
        if found["of"] != _digest(self.tree.project.root / file):
            return False
        self.recording.add(file, found)
        return True


def _digest(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest()


class _Watch:
    """A pytest plugin that notes test, time and outcome."""

    def __init__(self, coverage: Any) -> None:
        self.coverage = coverage
        self.seconds: dict[str, float] = defaultdict(float)
        self.outcomes: dict[str, str] = {}

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.coverage.switch_context(without_parameters(nodeid))
        self.begun = time.process_time()

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.seconds[without_parameters(nodeid)] += time.process_time() - self.begun
        self.coverage.switch_context("")

    def pytest_runtest_logreport(self, report: Any) -> None:
        test = without_parameters(report.nodeid)
        order = ("skipped", "passed", "failed")
        outcomes = (report.outcome, self.outcomes.get(test, "skipped"))
        if report.when == "call" or report.outcome != "passed":
            self.outcomes[test] = max(outcomes, key=order.index)


def without_parameters(nodeid: str) -> str:
    """The name of a test function."""
    return nodeid.partition("[")[0]


def record(tree: Tree, file: str, to: Path) -> int:
    """Run a file of tests in this process and write its record."""
    import coverage
    import pytest

    root = tree.project.root
    tops = (*tree.project.folders, tree.project.tests)
    measure = coverage.Coverage(
        data_file=None, config_file=False, include=[f"{root / top}/*" for top in tops]
    )
    measure.start()
    watch = _Watch(measure)
    places = [f"--rootdir={root}", f"--basetemp={to.with_suffix('.tmp')}"]
    code = pytest.main([*OPTIONS, *places, file], plugins=[watch])
    measure.stop()
    if code not in RAN:
        return int(code)
    data = measure.get_data()
    lines = {}
    for measured in data.measured_files():
        seen = data.contexts_by_lineno(measured)
        lines[Path(measured).relative_to(root).as_posix()] = {
            line: sorted(filter(None, tests)) for line, tests in seen.items() if any(tests)
        }
    part = to.with_suffix(".part")
    wanted = {
        "of": _digest(root / file),
        "seconds": watch.seconds,
        "outcomes": watch.outcomes,
        "lines": lines,
    }
    part.write_text(json.dumps(wanted), encoding="utf-8")
    part.rename(to)
    rmtree(to.with_suffix(".tmp"), ignore_errors=True)
    return 0
