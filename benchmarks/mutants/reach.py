"""Which tests reach a change: those recorded on its line, or on lines that name what it is in.

Coverage sees nothing of compiled kernels, and sees constants, defaults and classes only when they
are imported. There the names lead on: to the functions that mention the kernel or constant, and if
those are compiled too, to the ones that mention them. Names are compared as words, without
resolving imports: rather a test too many than one too few.

A file of tests of which no run is recorded counts as a whole, if it mentions one of those names.
Changes of constants and defaults are tried first with the tests that hold a table of all of them.
"""

import ast
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import PurePath

from benchmarks.mutants.recording import Recording
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.tree import Project

DEEPEST = 6  # names between a kernel and a test
UNKNOWN = 10.0  # [s] that a file of tests counts for where no run is recorded


@dataclass(frozen=True)
class Selected:
    """A test, or a whole file of tests, and how long it takes [s]."""

    test: str
    seconds: float
    recorded: bool = True


@dataclass(kw_only=True)
class _Definition:
    """A function, class or constant at the top of a module."""

    name: str
    file: str
    lines: range
    words: frozenset[str]


@dataclass(kw_only=True)
class Reach:
    """The tests of a project, to be asked for those that reach a change."""

    project: Project
    recording: Recording
    _users: dict[str, list[_Definition]] = field(default_factory=lambda: defaultdict(list))
    _definitions: dict[str, list[_Definition]] = field(default_factory=dict)  # of a file
    _words: dict[str, frozenset[str]] = field(default_factory=dict)  # of files of tests

    def __post_init__(self) -> None:
        for file in self.project.modules():
            self._definitions[file] = _definitions(file, self._read(file))
            for definition in self._definitions[file]:
                for word in definition.words:
                    self._users[word].append(definition)
        for file in self.project.test_files():
            self._words[file] = _words(self._read(file))

    def tests(self, change: Change, source: Source) -> list[Selected]:
        """Tests that reach a change, nearest folder first, and quick ones first."""
        first, last = change.line, source.line(change.end)
        found = self._on_lines(change.file, range(first, last + 1))
        names, followed = self._names(change.owner)
        if change.at_import or not (found or self._is_recorded(change)):
            found |= followed
        if change.at_import and not change.owner:
            found |= self._on_lines(change.file, None)
        chosen = [Selected(test, self.recording.seconds[test]) for test in found]
        path = PurePath(change.file)
        for file, words in self._words.items():
            if file not in self.recording.files and words & (names | {path.stem}):
                chosen.append(Selected(file, UNKNOWN, recorded=False))
        close = {change.owner, path.stem, path.parent.name}
        package = self.project.folders[0]
        code = path.relative_to(package) if path.is_relative_to(package) else path

        def order(one: Selected) -> tuple[int, int, float]:
            file = one.test.partition("::")[0]
            return -_nearness(code, file), -len(close & self._words[file]), one.seconds

        ordered = sorted(chosen, key=order)
        if change.at_import:
            ordered = [*self._pinning(), *ordered]
        return ordered

    def _pinning(self) -> list[Selected]:
        """The tests of every constant, whose table is text that names nothing."""
        file = self.project.pinning
        if file not in self._words:
            return []
        if file not in self.recording.files:
            return [Selected(file, UNKNOWN, recorded=False)]
        seconds = self.recording.seconds.items()
        return [Selected(test, taken) for test, taken in seconds if test.startswith(f"{file}::")]

    def _is_recorded(self, change: Change) -> bool:
        """Whether tests ran other lines of the function or class: then it is no kernel."""
        return any(
            self._on_lines(change.file, definition.lines)
            for definition in self._definitions[change.file]
            if definition.name == change.owner
        )

    def _read(self, file: str) -> ast.Module:
        return ast.parse((self.project.root / file).read_bytes())

    def _on_lines(self, file: str, lines: Iterable[int] | None) -> set[str]:
        seen = self.recording.lines.get(file, {})
        wanted = seen if lines is None else lines
        return set().union(*(seen.get(line, ()) for line in wanted))

    def _names(self, owner: str) -> tuple[set[str], set[str]]:
        """Names that lead from a definition to tests, and recorded tests that they lead to."""
        names, tests = {owner} - {""}, set()
        new, unseen = set(names), set(names)  # the latter: what coverage has not seen so far
        kernels = set(names)  # all that it has not seen
        for _ in range(DEEPEST):
            users = [(name, definition) for name in new for definition in self._users[name]]
            new, before, unseen = set(), unseen, set()
            for name, user in users:
                on_lines = self._on_lines(user.file, user.lines)
                if name in before:
                    tests |= on_lines
                    if not on_lines:
                        unseen.add(user.name)
                        kernels.add(user.name)
                new.add(user.name)
            new -= names
            names |= new
        for file, words in self._words.items():  # tests that name one of them themselves
            if words & kernels:
                tests |= {test for test in self.recording.seconds if test.startswith(f"{file}::")}
        return names, tests


def within(chosen: Iterable[Selected], budget: float) -> list[Selected]:
    """The first tests, as long as what they take together is within the budget [s]."""
    spent = 0.0

    def fits(one: Selected) -> bool:
        nonlocal spent
        spent += one.seconds
        return spent <= budget or spent == one.seconds

    return list(takewhile(fits, chosen))


def _nearness(code: PurePath, test: str) -> int:
    """How many folders a file of code and one of tests have in common, their own names included."""
    tests = [part.removeprefix("test_").removesuffix(".py") for part in PurePath(test).parts[1:]]
    pairs = zip(code.with_suffix("").parts, tests, strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def _definitions(file: str, tree: ast.Module) -> list[_Definition]:
    found = []
    for node in tree.body:
        name = getattr(node, "name", "")
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            name = getattr(targets[0], "id", "")
        if name and not isinstance(node, ast.Import | ast.ImportFrom):
            last = node.end_lineno or node.lineno
            begin = node.body[0].lineno if isinstance(node, ast.FunctionDef) else node.lineno
            lines = range(begin, last + 1)
            found.append(
                _Definition(name=name, file=file, lines=lines, words=_words(node) - {name})
            )
    return found


def _words(node: ast.AST) -> frozenset[str]:
    """Names, attributes, and what is imported from where, anywhere in a node."""
    found = set()
    for each in ast.walk(node):
        if isinstance(each, ast.Name):
            found.add(each.id)
        elif isinstance(each, ast.Attribute):
            found.add(each.attr)
        elif isinstance(each, ast.alias):
            found.update(each.name.split("."))
        elif isinstance(each, ast.ImportFrom) and each.module:
            found.update(each.module.split("."))
    return frozenset(found)
