"""The partner ablation: what its rows see, its intervals, and that it runs from end to end."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning.partner_ablation import ROWS, Ablation, interval, lines, run
from coopenv import Transport
from coopenv.agents.settings import TrainConfig
from coopenv.errors import InvalidInput, UnknownName


def test_the_learner_is_told_no_goal_and_rows_differ_in_what_they_feel():
    study = Ablation()
    for row, blocks in ROWS.items():
        config = study.environment(row)
        assert config.observe == blocks
        assert config.informed == ()
        assert config.learners == (0,)
    felt = set(ROWS["with"]) - set(ROWS["without"])
    assert felt == {"own_internal", "partner_internal", "relative_cost"}
    core = Transport(config=replace(study.environment("with"), observe=("goal", "known")))
    obs, _ = core.reset(seed=0)
    assert not obs.any()


def test_an_interval_is_that_of_the_mean_over_seeds():
    generator = np.random.default_rng(0)
    sample = generator.normal(3.0, 1.0, 40)
    middle, rest = interval([sample]).split(" ", 1)
    low, high = (float(end) for end in rest.strip("[]").split(","))
    assert float(middle) == pytest.approx(sample.mean(), abs=1e-3)
    spread = 1.96 * sample.std() / np.sqrt(40)
    assert (low, high) == pytest.approx((sample.mean() - spread, sample.mean() + spread), abs=0.05)
    shifted = interval([sample + 5.0, sample])
    assert float(shifted.split()[0]) == pytest.approx(5.0)
    assert interval([np.array([np.nan, np.nan])]) == "-"
    assert interval([np.array([0.5])]) == "0.500"


def test_a_small_study_runs_and_leaves_its_table(tmp_path):
    tiny = TrainConfig(
        control="partner", steps=64, num_worlds=4, rollout=8, batch_size=16, epochs=1, hidden=(8,)
    )
    rows = ("without", "with")
    study = Ablation(rows=rows, seeds=(0, 1), episodes=4, horizon=8, out=tmp_path, training=tiny)
    seen = run(study, lambda line: None)
    assert set(seen) == {*rows, "idle", "informed"}
    assert [len(seen[row]) for row in rows] == [2, 2]
    table = lines(seen)
    assert [line[0] for line in table] == [*rows, "with − without", "idle", "informed"]
    for name in ("runs.csv", "table.csv", "curves.png"):
        assert (tmp_path / name).stat().st_size > 0


def test_a_study_without_a_comparison_is_refused():
    with pytest.raises(InvalidInput, match="seeds must be at least two"):
        Ablation(seeds=(0,)).check()
    with pytest.raises(InvalidInput, match="rows must hold 'with' and 'without'"):
        Ablation(rows=("with",)).check()
    with pytest.raises(UnknownName, match="did you mean 'without'"):
        Ablation(rows=("with", "witout")).check()
