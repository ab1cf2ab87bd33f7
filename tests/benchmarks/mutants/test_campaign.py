"""Mutants of a toy package: a fault is caught, a gap is reported, a run goes on."""

from contextlib import suppress
from dataclasses import replace

import pytest

from benchmarks.mutants.campaign import Campaign
from benchmarks.mutants.page import tables
from benchmarks.mutants.reach import Selected
from benchmarks.mutants.report import score, survivors
from benchmarks.mutants.results import Result, Results
from benchmarks.mutants.source import Source
from benchmarks.mutants.tree import Tree
from benchmarks.mutants.trial import tried
from tests.benchmarks.mutants.cases import change_of, toy


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
    page = tables({0: results[:2], 3: results[2:]})
    assert page["score"].splitlines() == [
        "- seed 0: 50.0 % of 2 mutants that change behaviour were caught; 0 more change none",
        "- seed 3: 0.0 % of 1 mutants that change behaviour were caught; 0 more change none",
    ]
    assert "| `toy/inner` | 2 | 0 | 2 | 0 | 0 % |" in page["folders"]
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


def test_a_run_goes_on_where_it_was_broken_off(tmp_path):
    pytest.importorskip("coverage")
    project = toy(tmp_path / "project")
    whole = Campaign(project=project, folder=tmp_path / "work", mutants=3, seed=1)
    Campaign(project=project, folder=tmp_path / "work", mutants=1, seed=1).run()
    path = tmp_path / "work" / project.digest() / "seed-1.jsonl"
    first = path.read_text()
    results = whole.run()
    assert path.read_text().startswith(first)
    assert len(results) == len(Results(path).of) == 3
    assert {result.status for result in results} <= {"caught", "survived", "unreached"}


def test_a_line_that_was_cut_off_is_tried_again_and_the_later_of_two_results_counts(tmp_path):
    one = Result(
        key="a:0-1:b", file="a", line=1, operator="sign", before="a", after="b", status="survived"
    )
    results = Results(tmp_path / "seed-0.jsonl")
    results.add(one)
    results.add(replace(one, key="c:0-1:d"))
    results.add(replace(one, status="caught"))
    with results.path.open("a") as file:
        file.write('{"key": "e:0-')
    again = Results(results.path)
    assert {key: result.status for key, result in again.of.items()} == {
        "a:0-1:b": "caught",
        "c:0-1:d": "survived",
    }
    again.add(replace(one, key="e:0-1:f"))
    assert len(Results(results.path).of) == 3
