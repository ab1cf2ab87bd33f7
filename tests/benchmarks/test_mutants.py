"""Mutants: one changed span each, a seeded sample of all folders, a toy package to try them on."""

import ast
from collections import Counter
from contextlib import suppress
from pathlib import Path
from textwrap import dedent

import pytest

from benchmarks.mutants import equivalent
from benchmarks.mutants.campaign import Campaign
from benchmarks.mutants.page import tables
from benchmarks.mutants.places import is_another_program, places
from benchmarks.mutants.reach import Reach, Selected, within
from benchmarks.mutants.recording import Recorder, Recording
from benchmarks.mutants.report import score, survivors
from benchmarks.mutants.results import Result, Results
from benchmarks.mutants.sample import sample
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.tree import Project, Tree
from benchmarks.mutants.trial import tried
from tests.sources import ROOT

TOY = {
    "toy/__init__.py": "",
    "toy/beam.py": '''
        """A beam."""

        import math

        LIMIT = 2.0  # [m]


        def reach(x, y):
            """Distance of a point, at most the limit."""
            if x < 0.0:
                raise ValueError("x must be at least 0, got " + str(x))
            return min(math.hypot(x, y), LIMIT)


        def endless(steps):
            while steps > 0:
                steps -= 1
            return steps
        ''',
    "toy/inner/__init__.py": "",
    "toy/inner/sums.py": "def total(a, b):\n    return a + 2 * b\n",
    "tests/test_beam.py": """
        import pytest

        from toy.beam import reach


        def test_a_point_within_the_limit_has_its_distance():
            assert reach(0.6, 0.8) == 1.0


        def test_what_lies_beyond_is_at_the_limit():
            assert reach(3.0, 4.0) == 2.0
        """,
    "tests/inner/test_sums.py": """
        from toy.inner.sums import total


        def test_a_total_is_a_number():
            assert isinstance(total(1, 0), int)
        """,
}


def toy(folder: Path) -> Project:
    for name, text in TOY.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text).lstrip("\n"), encoding="utf-8")
    return Project(root=folder, folders=("toy",))


def source(text: str) -> Source:
    return Source("toy/text.py", dedent(text).lstrip("\n").encode())


def edited(text: str) -> set[tuple[str, str]]:
    """Operator and whole changed text of each mutant."""
    made = source(text)
    return {
        (change.operator, change.applied(made.text).decode().strip())
        for changes in places(made)
        for change in changes
    }


def change_of(found: Source, old: str, new: str) -> Change:
    """The change of a file that puts ``new`` where ``old`` stands."""
    wanted = found.text.replace(old.encode(), new.encode())
    (made,) = (
        change
        for changes in places(found)
        for change in changes
        if change.applied(found.text) == wanted
    )
    return made


def test_an_operator_changes_in_its_place_and_nothing_else():
    found = edited("d = (a  # first\n     ) * (b - c)\n")
    assert ("arithmetic", "d = (a  # first\n     ) / (b - c)") in found
    assert ("arithmetic", "d = (a  # first\n     ) * (b + c)") in found
    assert len(found) == 2


@pytest.mark.parametrize(
    ("text", "operator", "changed"),
    [
        ("a = b < c\n", "comparison", "a = b <= c"),
        ("a = b is not None\n", "comparison", "a = b is None"),
        ("a = b not in c\n", "comparison", "a = b in c"),
        ("a = b and c\n", "and, or", "a = b or c"),
        ("a = -b\n", "sign", "a = b"),
        ("a = 3\n", "constant", "a = 4"),
        ("a = 0.25\n", "constant", "a = (-0.25)"),
        ("a = 1e-9\n", "constant", "a = 1e-06"),
        ("a = b[:, -1]\n", "index", "a = b[:, 0]"),
        ("a = b[1:]\n", "slice", "a = b[:]"),
        ("a = b(c, axis=-1)\n", "axis", "a = b(c, axis=(-2))"),
        ("a = b(c, axis=-1)\n", "keyword", "a = b(c)"),
        ("a = b(é, c)\n", "swapped", "a = b(c, é)"),
        ("a = np.maximum(b, c)\n", "twin", "a = np.minimum(b, c)"),
        ("a = b if c else d\n", "condition", "a = b if True else d"),
        ("def f(a=True): ...\n", "default", "def f(a=False): ..."),
        ("def f(a):\n    a = g(a)\n    return a\n", "dropped", "def f(a):\n    pass\n    return a"),
        ("def f(a):\n    a += b\n", "arithmetic", "def f(a):\n    a -= b"),
    ],
)
def test_each_kind_of_fault_is_made(text: str, operator: str, changed: str):
    assert (operator, changed) in edited(text)


def test_a_length_that_numpy_fills_in_does_not_become_another_negative_one():
    assert edited("a = b.reshape(-1, n)\n") == {
        ("constant", "a = b.reshape(1, n)"),
        ("swapped", "a = b.reshape(n, -1)"),
    }


@pytest.mark.parametrize(
    "text",
    [
        '"""At most 3."""\n',
        "__all__ = ['a', 'b']\n",
        "from a import b\n",
        "def f(a: Literal[1, 2]) -> tuple[int, ...]: ...\n",
        "a: dict[str, int | None]\n",
        "@dataclass(frozen=True)\nclass A: ...\n",
        "raise InvalidInput('a must be 1, got ' + str(2))\n",
        "a = warn('at most ' + str(3), stacklevel=2)\n",
        "a = f'{b + 1} of 3'\n",
        "a = b(describe='at most 3')\n",
        "if TYPE_CHECKING:\n    a = 1\n",
        "Kind = Callable[[int], str] | None\n",
        "assert a == 1\n",
    ],
)
def test_what_is_no_behaviour_is_left_out(text: str):
    assert not edited(text)


@pytest.mark.parametrize("file", ["coopenv/wrench/pair/lens.py", "rewards/terms.py"])
def test_every_mutant_is_a_program_that_differs_in_one_span(file: str):
    made = Source(file, (ROOT / file).read_bytes())
    changes = [change for found in places(made) for change in found][::7]
    assert len(changes) > 25
    for change in changes:
        text = change.applied(made.text)
        assert text[: change.start] == made.text[: change.start]
        assert text.endswith(made.text[change.end :])
        if is_another_program(made, change):
            ast.parse(text)


def test_a_sample_is_seeded_and_goes_through_all_folders(tmp_path):
    project = toy(tmp_path)
    keys = [change.key for _, change in sample(project, 12, seed=3)]
    assert keys == [change.key for _, change in sample(project, 12, seed=3)]
    assert keys[:5] == [change.key for _, change in sample(project, 5, seed=3)]
    assert keys != [change.key for _, change in sample(project, 12, seed=4)]
    folders = Counter(change.file.rpartition("/")[0] for _, change in sample(project, 6, seed=0))
    assert set(folders) == {"toy", "toy/inner"}
    everything = sample(project, 1000, seed=0)
    assert len({change.start for _, change in everything if change.file == "toy/inner/sums.py"}) > 2


def test_a_fault_is_caught_and_a_gap_is_reported(tmp_path):
    project = toy(tmp_path / "project")
    tree = Tree.copied(project, tmp_path / "work")
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    sums = Source("toy/inner/sums.py", (project.root / "toy/inner/sums.py").read_bytes())
    tests = [
        Selected("tests/test_beam.py::test_a_point_within_the_limit_has_its_distance", 0.1),
        Selected("tests/test_beam.py::test_what_lies_beyond_is_at_the_limit", 0.1),
    ]
    fault = change_of(beam, "min(", "max(")
    caught = tried(tree, fault, beam.text, tests)
    assert (caught.status, caught.how) == ("caught", "failed")
    assert caught.by == tests[0].test

    gap = change_of(sums, "a + 2", "a - 2")
    few = [Selected("tests/inner/test_sums.py::test_a_total_is_a_number", 0.1)]
    survived = tried(tree, gap, sums.text, few)
    assert (survived.status, survived.ran, survived.reached_by) == ("survived", 1, 1)
    nobody = tried(tree, gap, sums.text, [])
    assert nobody.status == "unreached"

    results = [
        Result.made(fault, beam, caught),
        Result.made(gap, sums, survived),
        Result.made(gap, sums, nobody),
    ]
    assert score(results[:2]) == 50.0
    (first, second) = survivors(results)
    assert "- return a + 2 * b" in first
    assert "+ return a - 2 * b" in first
    assert "passed: tests/inner/test_sums.py (1)" in first
    assert "no test reaches it" in second
    page = tables(results[:2], seed=0)
    assert "50.0 % of 2 mutants" in page["score"]
    assert "| `toy/inner` | 1 | 0 | 1 | 0 | 0 % |" in page["folders"]
    assert "`toy/inner/sums.py:2`" in page["survivors"]


def test_a_tree_is_whole_again_after_a_mutant_and_follows_its_project(tmp_path):
    project = toy(tmp_path / "project")
    tree = Tree.copied(project, tmp_path / "work")
    file = tree.project.root / "toy/beam.py"
    before = (file.read_bytes(), file.stat().st_mtime_ns)
    (tree.cache / "kernel.nbc").write_text("compiled")
    with suppress(KeyboardInterrupt), tree.changed("toy/beam.py", b"LIMIT = 0\n") as cache:
        assert file.read_bytes() == b"LIMIT = 0\n"
        assert (cache / "kernel.nbc").read_text() == "compiled"
        (cache / "new.nbc").write_text("of the mutant")
        raise KeyboardInterrupt
    assert (file.read_bytes(), file.stat().st_mtime_ns) == before
    assert [path.name for path in tree.cache.iterdir()] == ["kernel.nbc"]
    file.write_bytes(b"LIMIT = 0\n")  # a run that was killed
    (project.root / "tests/test_beam.py").unlink()
    Tree.copied(project, tmp_path / "work")
    assert file.read_bytes() == before[0]
    assert tree.project.test_files() == ["tests/inner/test_sums.py"]


def test_tests_come_from_lines_and_for_constants_from_the_functions_that_name_them(tmp_path):
    project = toy(tmp_path)
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    near, far = "tests/test_beam.py::test_near", "tests/inner/test_sums.py::test_far"
    line = beam.text[: beam.text.index(b"return min")].count(b"\n") + 1
    recording = Recording(
        seconds={near: 0.5, far: 0.1, "tests/inner/test_sums.py::test_other": 0.1},
        lines={"toy/beam.py": {line: {near, far}}},
        files=set(project.test_files()),
    )
    reach = Reach(project=project, recording=recording)
    for change in (change_of(beam, "min(", "max("), change_of(beam, "2.0", "4.0")):
        found = [one.test for one in reach.tests(change, beam)]
        assert sorted(found) == sorted((near, far))
    assert not reach.tests(change_of(beam, "steps > 0", "steps > 1"), beam)


def test_a_line_that_no_test_ran_is_reached_by_none_though_its_function_is(tmp_path):
    project = toy(tmp_path)
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    test = "tests/test_beam.py::test_what_lies_beyond_is_at_the_limit"
    line = beam.text[: beam.text.index(b"return min")].count(b"\n") + 1
    recording = Recording(
        seconds={test: 0.1}, lines={"toy/beam.py": {line: {test}}}, files=set(project.test_files())
    )
    reach = Reach(project=project, recording=recording)
    assert not reach.tests(change_of(beam, "x < 0.0", "x <= 0.0"), beam)
    recording.lines.clear()  # as of a kernel: the tests that name it count
    found = reach.tests(change_of(beam, "x < 0.0", "x <= 0.0"), beam)
    assert [one.test for one in found] == [test]


def test_a_file_of_tests_without_a_recording_counts_where_it_names_what_is_changed(tmp_path):
    project = toy(tmp_path)
    sums = Source("toy/inner/sums.py", (project.root / "toy/inner/sums.py").read_bytes())
    reach = Reach(project=project, recording=Recording())
    found = reach.tests(change_of(sums, "a + 2", "a - 2"), sums)
    assert [(one.test, one.recorded) for one in found] == [("tests/inner/test_sums.py", False)]


def test_names_lead_to_tests_without_a_recording_also_where_others_are_recorded(tmp_path):
    project = toy(tmp_path)
    tests = project.root / "tests/test_beam.py"
    tests.write_text("from toy import reach\n\n\ndef test_it():\n    assert reach(0, 0) == 0\n")
    (project.root / "toy/__init__.py").write_text("from .beam import reach\n")
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    line = beam.text[: beam.text.index(b"return min")].count(b"\n") + 1
    other = "tests/inner/test_sums.py::test_other"
    recording = Recording(
        seconds={other: 0.1},
        lines={"toy/beam.py": {line: {other}}},
        files={"tests/inner/test_sums.py"},
    )
    found = Reach(project=project, recording=recording).tests(change_of(beam, "2.0", "4.0"), beam)
    assert [one.test for one in found] == ["tests/test_beam.py", other]


def test_tests_are_taken_up_to_the_budget_and_at_least_one():
    tests = [Selected(name, seconds) for name, seconds in (("a", 5.0), ("b", 4.0), ("c", 2.0))]
    assert [one.test for one in within(tests, 10.0)] == ["a", "b"]
    assert [one.test for one in within(tests, 1.0)] == ["a"]


def test_an_equivalent_mutant_is_known_wherever_its_line_stands(tmp_path):
    known = tmp_path / "equivalent.toml"
    known.write_text(
        '[[equivalent]]\nfile = "toy/text.py"\nline = "a = b < c"\n'
        'changed = "a = b <= c"\nreason = "b is never c"\n'
    )
    for text in ("a = b < c\n", "z = y\n\nif z:\n    a  =  b < c\n"):
        made = source(text)
        assert equivalent.reason(change_of(made, "<", "<="), made, known) == "b is never c"
        assert not equivalent.reason(change_of(made, "<", ">="), made, known)


def test_every_known_equivalent_still_stands_in_its_file():
    for (file, line, changed), reason in equivalent.known().items():
        made = Source(file, (ROOT / file).read_bytes())
        lines = {change.lines(made.text) for found in places(made) for change in found}
        assert (line, changed) in lines, f"{file}: {line}"
        assert reason


def test_a_run_goes_on_where_it_was_broken_off(tmp_path):
    pytest.importorskip("coverage")
    project = toy(tmp_path / "project")
    whole = Campaign(project=project, folder=tmp_path / "work", mutants=5, seed=1)
    Campaign(project=project, folder=tmp_path / "work", mutants=2, seed=1).run()
    path = tmp_path / "work" / project.digest() / "seed-1.jsonl"
    first = path.read_text()
    results = whole.run()
    assert path.read_text().startswith(first)
    assert len(results) == len(Results(path).of) == 5
    assert {result.status for result in results} <= {"caught", "survived", "unreached"}


def test_a_recording_knows_lines_and_failures_and_holds_until_its_tests_change(tmp_path):
    pytest.importorskip("coverage")
    project = toy(tmp_path / "project")
    file = "tests/test_beam.py"
    tests = project.root / file
    tests.write_text(
        tests.read_text() + "\n\ndef test_that_fails():\n    assert reach(0, 0) == 1\n"
    )
    tree = Tree.copied(project, tmp_path / "work")
    recorder = Recorder(tree, tmp_path / "records")
    recorder.complete([file])
    found = recorder.recording
    near = f"{file}::test_a_point_within_the_limit_has_its_distance"
    beyond = f"{file}::test_what_lies_beyond_is_at_the_limit"
    assert set(found.seconds) == {near, beyond}
    assert found.failed == [f"{file}::test_that_fails"]
    lines = (project.root / "toy/beam.py").read_text().splitlines()
    assert found.lines["toy/beam.py"][lines.index("    if x < 0.0:") + 1] == {near, beyond}
    assert lines.index("        steps -= 1") + 1 not in found.lines["toy/beam.py"]
    assert file not in Recorder(tree, tmp_path / "records").missing()
    tests.write_text(tests.read_text() + "\n# another\n")
    assert file in Recorder(Tree.copied(project, tmp_path / "work"), tmp_path / "records").missing()
