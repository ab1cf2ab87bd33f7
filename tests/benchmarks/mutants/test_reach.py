"""Which tests reach a change: by recorded lines, by names, up to the budget."""

import pytest

from benchmarks.mutants.reach import Reach, Selected, within
from benchmarks.mutants.recording import Recorder, Recording
from benchmarks.mutants.source import Source
from benchmarks.mutants.tree import Tree
from tests.benchmarks.mutants.cases import change_of, toy


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


def test_constants_are_tried_first_with_the_table_of_all_of_them(tmp_path):
    project = toy(tmp_path)
    (project.root / project.pinning).write_text("def test_the_table():\n    pass\n")
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    reach = Reach(project=project, recording=Recording())
    constant = reach.tests(change_of(beam, "2.0", "4.0"), beam)
    assert constant[0] == Selected(project.pinning, 10.0, recorded=False)
    inside = reach.tests(change_of(beam, "min(", "max("), beam)
    assert project.pinning not in [one.test for one in inside]
    table = f"{project.pinning}::test_the_table"
    outcomes = {table: "passed", f"{project.pinning}::test_of_more": "failed"}
    seconds = dict.fromkeys(outcomes, 2.0)
    recording = Recording()
    recording.add(project.pinning, {"outcomes": outcomes, "seconds": seconds, "lines": {}})
    known = Reach(project=project, recording=recording)
    tests = known.tests(change_of(beam, "2.0", "4.0"), beam)
    assert tests == [Selected(table, 2.0), constant[-1]]


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


def test_a_kernel_in_a_kernel_is_reached_by_the_tests_that_call_the_outer_one(tmp_path):
    project = toy(tmp_path)
    (project.root / "toy/beam.py").write_text(
        "def within(x):\n    return x < 1\n\n\ndef reach(x, y):\n    return within(x + y)\n"
    )
    beam = Source("toy/beam.py", (project.root / "toy/beam.py").read_bytes())
    test = "tests/test_beam.py::test_what_lies_beyond_is_at_the_limit"
    recording = Recording(seconds={test: 0.1}, files=set(project.test_files()))
    reach = Reach(project=project, recording=recording)
    found = reach.tests(change_of(beam, "x < 1", "x <= 1"), beam)
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
