"""The partner ablation: what its rows see, its intervals, and that it runs from end to end."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning.partner_ablation import ROWS, Ablation, Sensing, interval, lines, run
from coopenv import Transport, wrench
from coopenv.agents.settings import TrainConfig
from coopenv.errors import InvalidInput, UnknownName


def test_the_learner_is_told_no_goal_and_rows_differ_in_what_they_sense():
    study = Ablation()
    for row, sight in ROWS.items():
        config = study.environment(row)
        assert config.observe == sight.observe
        assert config.decomposition.method == sight.method
        assert config.informed == ()
        assert config.learners == (0,)
        assert study.measured(row).decomposition == wrench.Settings()
    felt = set(ROWS["plausible"].observe) - set(ROWS["without"].observe)
    assert felt == {"own_internal", "partner_internal", "relative_cost"}
    core = Transport(config=replace(study.environment("plausible"), observe=("goal", "known")))
    obs, _ = core.reset(seed=0)
    assert not obs.any()


def test_the_pseudoinverse_and_the_own_wrench_determine_the_partners_and_the_plausible_part_not():
    generator = np.random.default_rng(0)
    grips = np.array([(-0.9, 0.0), (0.9, 0.0)])
    applied = generator.normal(size=(500, 2, 3))
    internal = wrench.decompose(applied, grips, method="moore_penrose").internal
    told = np.concatenate([applied[:, 0], internal[:, 0]], axis=1)  # all are linear in the wrench
    found, *_ = np.linalg.lstsq(told, applied[:, 1])
    np.testing.assert_allclose(told @ found, applied[:, 1], atol=1e-12)
    pulls = np.array([[(2.0, 0, 0), (x, 0, 0)] for x in (0.0, 1.0, 3.0)])  # another partner each
    assert not wrench.decompose(pulls, grips).internal.any()


def test_a_policy_sees_the_decomposition_it_was_trained_on_and_is_measured_by_the_plausible_one():
    study = Ablation()
    trained, measured = study.environment("Moore-Penrose"), study.measured("Moore-Penrose")
    core, told = Transport(num_worlds=3, config=measured), []
    shown = Transport(num_worlds=3, config=trained)

    def push(obs, transition):
        told.append(obs)
        return np.full((3, 1, 3), 0.5)

    policy = Sensing(push, trained)
    obs, _ = core.reset(seed=0)
    wanted, _ = shown.reset(seed=0)
    for _ in range(5):
        assert core.transition is not None
        action = policy(obs, core.transition)
        np.testing.assert_array_equal(told[-1], wanted)
        obs, *_, info = core.step(action)
        wanted, *_, other = shown.step(action)
        assert (info["internal_force_level"] < other["internal_force_level"]).all()
    assert not np.array_equal(obs, wanted)


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
    rows = ("without", "plausible")
    study = Ablation(rows=rows, seeds=(0, 1), episodes=4, horizon=8, out=tmp_path, training=tiny)
    seen = run(study, lambda line: None)
    assert set(seen) == {*rows, "idle", "informed"}
    assert [len(seen[row]) for row in rows] == [2, 2]
    table = lines(seen)
    assert [line[0] for line in table] == [*rows, "idle", "informed", "plausible − without"]
    for name in ("runs.csv", "table.csv", "curves.png"):
        assert (tmp_path / name).stat().st_size > 0


def test_a_study_of_one_seed_or_of_an_unknown_row_is_refused():
    with pytest.raises(InvalidInput, match="seeds must be at least two"):
        Ablation(seeds=(0,)).check()
    with pytest.raises(UnknownName, match="did you mean 'without'"):
        Ablation(rows=("plausible", "witout")).check()
