"""The pages of the benchmark: they show the summaries beside them, of these versions."""

from dataclasses import replace

import pytest

pytest.importorskip("rich")

from benchmarks import pages
from benchmarks.board import tables as board
from coopenv.agents.benchmark import SUITES, conduct, plan, read_entry
from coopenv.agents.benchmark.summary import Summary
from coopenv.agents.benchmark.trained import Trained

ENTERED = [(suite, one) for suite in SUITES.values() for one in board.summaries(suite)]


def test_the_pages_show_the_summaries_beside_them():
    # else: python -m benchmarks.board --write
    for page, tables in ((board.PAGE, board.tables()), (board.REST, board.measures())):
        assert page.read_text(encoding="utf-8") == pages.filled(page, tables)


@pytest.mark.parametrize(("suite", "one"), ENTERED, ids=lambda each: getattr(each, "entry", ""))
def test_summaries_are_of_the_suites_as_they_are(suite, one: Summary):
    assert (one.suite, one.version) == (suite.name, suite.version)
    digests = {scenario.name: suite.digest_of(scenario) for scenario in suite.scenarios}
    for name, result in one.results.items():
        assert result.digest == digests[name]
        for found in filter(None, result.measures.values()):
            assert 0 < found.episodes <= suite.episodes


@pytest.mark.parametrize(("suite", "one"), ENTERED, ids=lambda each: getattr(each, "entry", ""))
def test_summaries_of_the_packages_policies_are_of_those_it_has(suite, one: Summary):
    if not one.given.startswith("pretrained:"):
        return
    entry = read_entry(one.given)
    for scenario in suite.scenarios:
        if scenario.name in one.results:
            assert one.results[scenario.name].sha256 == entry.digest(scenario)


def test_what_is_beyond_a_budget_or_not_told_is_marked():
    one = next(one for suite, one in ENTERED if (suite.name, one.entry) == ("team", "scripted"))

    def told(trained):
        results = {name: replace(each, trained=trained) for name, each in one.results.items()}
        return replace(one, results=results)

    most = SUITES["team"].budget
    assert board.budget([told(Trained(most))]) == "within"
    assert board.budget([told(Trained(most // 2, 3)), one]) == "over, in `team`"
    assert board.budget([told(None), one]) == board.NONE


def test_every_suite_has_a_reference_that_succeeds():
    for suite in SUITES.values():
        mine = {one.entry: one for one in board.summaries(suite)}
        assert {"nobody", "random", "scripted"} <= mine.keys()
        for name in mine["scripted"].results.keys() & mine["nobody"].results.keys():
            better, idle = (
                mine[entry].results[name].measures["success_rate"]
                for entry in ("scripted", "nobody")
            )
            assert better is not None
            assert idle is not None
            assert better.value >= idle.value


def test_what_stands_on_the_page_is_measured_again(tmp_path):
    suite = SUITES["haptics"]
    name = "wrench, 7.7 kg"
    entry = read_entry("scripted")
    outcome = conduct(plan([entry], [suite], only=[name]), tmp_path)
    (again,) = outcome.summaries.values()
    (kept,) = [one for one in board.summaries(suite) if one.entry == "scripted"]
    for measure, found in kept.results[name].measures.items():
        mine = again.results[name].measures[measure]
        assert (mine is None) == (found is None)
        if mine is not None and found is not None:
            assert mine.value == pytest.approx(found.value, rel=1e-3, abs=0.01)
