"""Evaluation: held-out seeds, every episode once, honest intervals, whole files."""

import csv
import io
import json
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from coopenv import Transport, TransportConfig
from coopenv.agents import pretrained
from coopenv.agents.controllers import ImpedanceController, RandomPolicy
from coopenv.agents.evaluate import (
    compare,
    evaluate,
    run_episodes,
    save,
    table,
    wilson_interval,
)
from coopenv.agents.seeds import BLOCK, HELD_OUT, evaluation_seeds, training_seeds
from coopenv.errors import InvalidInput

SHORT = TransportConfig(horizon=45)  # some episodes succeed, some are truncated


class Leader(ImpedanceController):
    """Deterministic and without memory, but for what its subclasses add."""

    def __init__(self):
        super().__init__(SHORT)


def alone(config, policy, seed):
    """Success, length, mean γ and mean wasted cost of one episode, run by itself."""
    core = Transport(num_worlds=1, config=config)
    obs, _ = core.reset(seed=seed)
    costs, wasted = [], []
    while True:
        assert core.transition is not None
        obs, _, terminated, truncated, info = core.step(policy(obs, core.transition))
        costs.append(info["relative_cost"][0])
        wasted.append(info["wasted_cost"][0])
        if terminated[0] or truncated[0]:
            return bool(terminated[0]), len(costs), float(np.mean(costs)), float(np.mean(wasted))


def test_every_seed_is_one_episode_whatever_its_length():
    seen = run_episodes(Leader(), SHORT, episodes=25, seed=1, num_worlds=10)
    assert len(seen.length) == 25
    assert len(set(seen.length.tolist())) > 3
    assert 0 < seen.success.mean() < 1
    for k in (0, 7, 13, 24):
        success, length, cost, wasted = alone(SHORT, Leader(), evaluation_seeds(1, 25)[k])
        assert seen.success[k] == success
        assert seen.length[k] == length
        assert seen.relative_cost[k] == pytest.approx(cost, abs=1e-9)
        assert seen.wasted_cost[k] == pytest.approx(wasted, abs=1e-9)


def test_the_number_of_worlds_changes_nothing():
    few = run_episodes(Leader(), SHORT, episodes=13, num_worlds=4)
    many = run_episodes(Leader(), SHORT, episodes=13, num_worlds=100)
    np.testing.assert_array_equal(few.length, many.length)
    np.testing.assert_array_equal(few.success, many.success)
    np.testing.assert_allclose(few.reward, many.reward, atol=1e-9)
    np.testing.assert_allclose(few.force_load_share, many.force_load_share, atol=1e-9)


def test_the_number_of_worlds_does_not_change_what_the_random_policy_does():
    few, many, other = (
        run_episodes(RandomPolicy(SHORT, seed), SHORT, episodes=7, num_worlds=num_worlds)
        for seed, num_worlds in ((3, 2), (3, 100), (4, 100))
    )
    np.testing.assert_array_equal(few.length, many.length)
    np.testing.assert_allclose(few.reward, many.reward, atol=1e-9)
    np.testing.assert_allclose(few.relative_cost, many.relative_cost, atol=1e-9)
    assert not np.isclose(many.relative_cost, other.relative_cost).any()
    assert len(set(many.relative_cost.tolist())) == 7


def test_a_summary_is_the_mean_over_episodes_not_over_steps():
    seen = run_episodes(Leader(), SHORT, episodes=20)
    result = evaluate(Leader(), SHORT, episodes=20, name="leader")
    assert result.policy == "leader"
    assert result.episodes == 20
    assert result.success_rate == seen.success.mean()
    assert result.success_time == pytest.approx(0.05 * seen.length[seen.success].mean())
    assert result.relative_cost == pytest.approx(seen.relative_cost.mean())
    assert sum(result.force_load_share) == pytest.approx(1.0)
    terms = sum(term.sum(axis=0) for term in seen.reward_terms.values())
    np.testing.assert_allclose(terms, seen.reward.sum(axis=0))


def test_all_policies_get_the_same_episodes():
    starts = []

    class Watcher(Leader):
        def reset(self, mask):
            self.fresh = mask.copy()

        def __call__(self, obs, transition):
            if self.fresh.all():
                starts.append(transition.next_state.pose.copy())
            self.fresh = np.zeros(1, dtype=np.bool_)
            return super().__call__(obs, transition)

    compare({"a": Watcher(), "b": Watcher()}, SHORT, episodes=6, num_worlds=3)
    assert len(starts) == 4
    np.testing.assert_array_equal(starts[:2], starts[2:])
    assert not np.array_equal(starts[0], starts[1])


def test_a_policy_with_memory_is_told_which_episodes_begin():
    class Counter(Leader):
        steps = np.zeros(5)

        def reset(self, mask):
            self.steps[mask] = 0

        def __call__(self, obs, transition):
            np.testing.assert_allclose(transition.next_state.time, 0.05 * self.steps)
            self.steps += 1
            return super().__call__(obs, transition)

    run_episodes(Counter(), SHORT, episodes=10, num_worlds=5)


def test_an_undefined_load_share_is_left_out():
    class Still:
        def __call__(self, obs, transition):
            return np.zeros((*obs.shape[:2], 3))

    result = evaluate(Still(), TransportConfig(horizon=3), episodes=4)
    assert np.isnan(result.force_load_share).all()
    assert np.isnan(result.load_imbalance)
    assert np.isnan(result.success_time)
    assert result.relative_cost == 0


def test_training_and_evaluation_never_share_a_world_seed():
    top = HELD_OUT // BLOCK - 1
    for seed in (0, 1, top):
        assert training_seeds(seed, BLOCK)[-1] < HELD_OUT <= evaluation_seeds(seed, BLOCK)[0]
    assert training_seeds(0, BLOCK)[-1] < training_seeds(1, 1)[0]
    assert evaluation_seeds(0, BLOCK)[-1] < evaluation_seeds(1, 1)[0]
    with pytest.raises(InvalidInput, match="share"):
        training_seeds(top + 1, 1)
    with pytest.raises(InvalidInput, match="share"):
        evaluation_seeds(0, BLOCK + 1)


@pytest.mark.parametrize(
    ("successes", "count", "low", "high"),
    [  # Brown, Cai & DasGupta 2001; Newcombe 1998
        (0, 10, 0.0, 0.2775),
        (10, 10, 0.7225, 1.0),
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_the_interval_is_wilsons(successes: int, count: int, low: float, high: float):
    assert wilson_interval(successes, count) == pytest.approx((low, high), abs=6e-5)


def test_the_table_has_a_row_a_policy():
    rich = pytest.importorskip("rich.console")
    seen = compare(
        {"leader": Leader(), "random": RandomPolicy(SHORT)}, SHORT, episodes=5, num_worlds=5
    )
    console = rich.Console(width=80, record=True, file=io.StringIO())
    console.print(table(seen, "title"))
    text = console.export_text()
    for word in ("title", "leader", "random", "success", "γ", "F_I", "T_I", "share"):
        assert word in text


def printed(evaluations, title="title"):
    rich = pytest.importorskip("rich.console")
    console = rich.Console(width=80, record=True, file=io.StringIO())
    console.print(table(evaluations, title))
    return console.export_text()


@pytest.mark.parametrize("name", ["x[/]", "x[bold]y", "q[red].zip", ":x:[a", "a\\[b]"])
def test_names_with_brackets_and_colons_stand_in_the_table_as_they_are(name):
    text = printed([replace(evaluate(Leader(), SHORT, episodes=1), policy=name)])
    assert name in text


def test_a_title_stands_over_the_table_as_it_is():
    title = "[bold]a: coopenv/BeamTransport-v0 with body.grips [[0.9, 0.0]] :x: [/]"
    text = printed([evaluate(Leader(), SHORT, episodes=1)], title)
    assert title in " ".join(text.split())  # it may go on in a second line


@pytest.mark.parametrize("team", [2, 3, 4, 6])
def test_the_table_fits_80_columns_whole(team: int):
    even = (1 / team,) * team
    one = evaluate(Leader(), SHORT, episodes=2)
    seen = replace(
        one,
        policy="trained PPO",
        success_rate=1.0,
        success_interval=(0.99, 1.0),
        sampled_success_rate=0.987,
        success_time=12.34,
        relative_cost=0.1234,
        internal_force_level=9.87,
        internal_torque_level=6.54,
        force_load_share=even,
        load_imbalance=0.5678,
    )
    other = replace(seen, policy="scripted", sampled_success_rate=nan)
    text = printed([seen, other])
    for word in (
        "100.0",
        "99-100",
        "98.7",
        "12.34",
        "0.123",
        "9.87",
        "6.54",
        "0.57",
        "0-1",
        "sample",
    ):
        assert text.count(word) >= 1, text
    assert text.count("0.57") == 2
    assert sum(text.count(f"{share:.2f}") for share in set(even)) >= 2 * team
    assert "   - 12.34" in text  # one way of acting


def test_names_of_the_packages_policies_are_whole_in_80_columns():
    one = evaluate(Leader(), SHORT, episodes=2)
    text = printed([replace(one, policy=name) for name in pretrained.names()])
    assert len(pretrained.names()) > 3
    for name in pretrained.names():
        assert f"{name} " in text


def test_results_are_saved_as_csv_and_json(tmp_path):
    seen = compare(
        {"still": Leader(), "other": RandomPolicy(SHORT)}, TransportConfig(horizon=2), episodes=3
    )
    save(seen, tmp_path / "deep" / "table.csv")
    save(seen, tmp_path / "deep" / "table.json")
    with (tmp_path / "deep" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["policy"] for row in rows] == ["still", "other"]
    assert float(rows[0]["relative_cost"]) == seen[0].relative_cost
    assert float(rows[1]["wasted_cost"]) == seen[1].wasted_cost > 0
    assert {"force_load_share_0", "force_load_share_1"} <= rows[0].keys()
    loaded = json.loads((tmp_path / "deep" / "table.json").read_text())
    assert loaded[0]["success_time"] is None  # NaN is no JSON
    assert loaded[1]["force_load_share"] == pytest.approx(seen[1].force_load_share)
    assert sorted(file.name for file in (tmp_path / "deep").iterdir()) == [
        "table.csv",
        "table.json",
    ]
    with pytest.raises(InvalidInput, match=r"\.csv"):
        save(seen, tmp_path / "table.txt")


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    seen = [evaluate(Leader(), TransportConfig(horizon=2), episodes=2)]
    path = tmp_path / "table.json"
    save(seen, path)
    before = path.read_text()
    monkeypatch.setattr(json, "dumps", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        save(seen, path)
    assert path.read_text() == before
    assert [file.name for file in tmp_path.iterdir()] == ["table.json"]


def test_the_default_environment_is_the_default():
    one = evaluate(ImpedanceController(TransportConfig()), episodes=3)
    other = evaluate(ImpedanceController(TransportConfig()), TransportConfig(), episodes=3)
    assert one == other


@pytest.mark.parametrize("given", ["coopenv/BeamTransport-v0", {"horizon": 3}, 3])
def test_an_environment_that_is_no_configuration_is_refused(given):
    with pytest.raises(InvalidInput, match=r"config must be a TransportConfig.*EnvironmentChoice"):
        evaluate(Leader(), given, episodes=2)


def test_a_title_keeps_what_is_in_brackets():
    console = pytest.importorskip("rich.console").Console(
        width=120, record=True, file=io.StringIO()
    )
    console.print(table([evaluate(Leader(), SHORT, episodes=2)], "terms [mine(a=1)]"))
    assert "terms [mine(a=1)]" in console.export_text()
