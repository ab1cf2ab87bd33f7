"""Runs of the benchmark: what is measured, kept, gone on with; and its intervals."""

import shutil
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest, bootstrap

from coopenv.agents.benchmark import conduct, measures, plan, read_entry, read_summary
from coopenv.agents.benchmark.meter import Meter
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.agents.evaluation import wilson_interval
from coopenv.agents.pretrained import file_of
from coopenv.errors import InvalidInput
from tests.agents.benchmark.cases import SMALL

ALONE, BESIDE = SMALL.scenarios
KILLED = """
import os, signal, sys
from pathlib import Path
from coopenv.agents.benchmark import conduct, plan, read_entry
from tests.agents.benchmark.cases import SMALL

def show(*, done, total, cells, of):
    if cells == 1:
        os.kill(os.getpid(), signal.SIGKILL)

conduct(plan([read_entry("scripted")], [SMALL]), Path(sys.argv[1]), show)
"""


def measured(path, scenario):
    """What is defined of a scenario in a summary."""
    found = read_summary(path).results[scenario].measures
    return {name: one for name, one in found.items() if one is not None}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The scripted controller in the small suite."""
    out = tmp_path_factory.mktemp("out")
    outcome = conduct(plan([read_entry("scripted")], [SMALL]), out)
    (path,) = outcome.summaries
    return path


def test_measures_are_those_of_an_evaluation(ran):
    for one in SMALL.scenarios:
        mine = measured(ran, one.name)
        seen = evaluate(find_controller(one.config), one.config, episodes=4, seed=SMALL.evaluation)
        assert mine["success_rate"].value == seen.success_rate
        assert mine["success_rate"][1:3] == pytest.approx(seen.success_interval, rel=1e-5)
        for name in ("relative_cost", "wasted_cost", "internal_force_level", "load_imbalance"):
            assert mine[name].value == pytest.approx(getattr(seen, name), rel=1e-5, abs=1e-12)
        assert mine["load_share"].value == pytest.approx(seen.force_load_share[0], rel=1e-5)
        if seen.success_rate:
            assert mine["success_time"].value == pytest.approx(seen.success_time, rel=1e-5)
        assert ("success_time" in mine) == (seen.success_rate > 0)


def test_success_at_other_tolerances_is_that_of_the_environment_with_them(ran):
    mine = measured(ran, "alone")
    for name, factor in (("success_at_half", 0.5), ("success_at_double", 2.0)):
        config = ALONE.within(factor)
        seen = evaluate(find_controller(config), config, episodes=4, seed=SMALL.evaluation)
        assert mine[name].value == seen.success_rate
    assert mine["success_at_half"].value <= mine["success_rate"].value
    assert mine["success_rate"].value <= mine["success_at_double"].value


def test_efforts_power_and_disagreement_are_means_over_steps_of_each_episode():
    config, rows = BESIDE.config, []

    class Watch:
        def add(self, transition, reward, info, running):
            assert running.all()
            force = np.hypot(transition.applied[..., 0], transition.applied[..., 1])
            power = transition.power.internal
            rows.append([force[:, 0], force[:, 1], power, info["disagreement"]])

        def end(self, episodes):
            assert episodes == 4

    policy = find_controller(config)
    run_episodes(policy, config, episodes=4, recorder=Watch())
    meter = Meter(config)
    run_episodes(policy, config, episodes=4, recorder=meter)
    names = ("effort", "partner_effort", "internal_power", "disagreement")
    for name, expected in zip(names, np.mean(rows, axis=0), strict=True):
        np.testing.assert_allclose(meter.means()[name], expected, rtol=1e-12)
    alone = Meter(ALONE.config)
    run_episodes(
        find_controller(ALONE.config), ALONE.config, episodes=3, recorder=alone, num_worlds=2
    )
    assert alone.means().keys() == {"effort", "internal_power"}
    assert alone.means()["effort"].shape == (3,)


def test_intervals_are_those_of_other_formulas():
    for successes, count in ((0, 50), (17, 200), (199, 200), (200, 200)):
        low, high = wilson_interval(successes, count)
        other = binomtest(successes, count).proportion_ci(method="wilson")
        assert (low, high) == pytest.approx((other.low, other.high), abs=1e-7)
    values = np.random.default_rng(3).gamma(2.0, size=200)
    found = measures.estimate(np.append(values, np.nan))
    assert found is not None
    assert (found.value, found.episodes) == (pytest.approx(values.mean(), rel=1e-5), 200)
    other = bootstrap((values,), np.mean, method="percentile", rng=1).confidence_interval
    spread = values.std() / np.sqrt(200)
    assert found.low == pytest.approx(other.low, abs=0.15 * spread)
    assert found.high == pytest.approx(other.high, abs=0.15 * spread)
    assert found.high - found.low == pytest.approx(2 * 1.96 * spread, rel=0.1)
    assert measures.estimate(np.full(3, np.nan)) is None


def test_what_is_finished_is_not_run_again(ran, monkeypatch):
    before = ran.read_bytes(), ran.stat().st_mtime_ns
    planned = plan([read_entry("scripted")], [SMALL])
    told = []
    conduct(planned, ran.parents[1], lambda **said: told.append((said["cells"], said["of"])))
    assert (ran.read_bytes(), ran.stat().st_mtime_ns) == before
    assert told == [(0, 2), (1, 2), (2, 2)]
    more = replace(SMALL, episodes=3)
    conduct(plan([read_entry("scripted")], [more]), ran.parents[1])
    assert measured(ran, "alone")["success_rate"].episodes == 3
    conduct(planned, ran.parents[1])
    assert ran.read_bytes() == before[0]


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such signal")
def test_a_run_that_was_killed_goes_on_to_the_same_summary(ran, tmp_path):
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()
    (path,) = tmp_path.glob("*/*.json")
    assert list(read_summary(path).results) == ["alone"]
    conduct(plan([read_entry("scripted")], [SMALL]), tmp_path)
    assert path.read_bytes() == ran.read_bytes()


def test_another_entry_under_a_name_that_is_taken_is_refused(ran):
    before = ran.read_bytes()
    other = read_entry("nobody", name="scripted")
    with pytest.raises(InvalidInput, match="is of 'scripted' as it was then; give another --name"):
        conduct(plan([other], [SMALL]), ran.parents[1])
    assert ran.read_bytes() == before


def test_a_file_that_changed_on_the_way_is_another_entry(tmp_path):
    file = shutil.copy(file_of("pretrained:BeamTransport/joint"), tmp_path / "mine.npz")
    conduct(plan([read_entry(str(file))], [SMALL], only=["alone"]), tmp_path / "out")
    shutil.copy(file_of("pretrained:BeamTransport/shared"), file)
    with pytest.raises(InvalidInput, match="as it was then; give another --name"):
        conduct(plan([read_entry(str(file))], [SMALL], only=["beside"]), tmp_path / "out")


def test_what_breaks_off_in_an_episode_says_whose_and_where_it_is(tmp_path):
    entry = read_entry("tests.agents.benchmark.cases:Failing")
    says = "Failing must act in the scenario 'alone', got ZeroDivisionError: no weight left"
    with pytest.raises(InvalidInput, match=says):
        conduct(plan([entry], [SMALL], only=["alone"]), tmp_path)


@pytest.mark.parametrize("text", ["{}", "[]", "no", '{"kind": "coopenv.benchmark", "format": 9}'])
def test_a_file_that_is_no_summary_is_refused_by_its_name(text, tmp_path):
    (tmp_path / "odd.json").write_text(text)
    with pytest.raises(InvalidInput, match=r"odd\.json must be a summary of coopenv benchmark"):
        read_summary(tmp_path / "odd.json")
