"""Sums over episodes and the evaluation made of them, by hand, to the last printed cell."""

import csv
import io
import json
from dataclasses import asdict
from math import nan

import numpy as np
import pytest

from coopenv.agents.episodes import Episodes, EpisodeSums
from coopenv.agents.evaluation import Evaluation, save, table
from coopenv.info import Info


def step(**changes):
    """Infos of two worlds and three agents."""
    return Info({
        "force_load_share": np.array([[0.5, 0.25, 0.25], [0.0, 0.2, 0.8]]),
        "force_load_share_defined": np.array([True, True]),
        "torque_load_share": np.array([[0.1, 0.3, 0.6], [1.0, 0.0, 0.0]]),
        "torque_load_share_defined": np.array([True, False]),
        "relative_cost": np.array([0.2, 0.4]),
        "wasted_cost": np.array([1.0, 3.0]),
        "internal_force_level": np.array([5.0, 7.0]),
        "internal_torque_level": np.array([0.5, 0.7]),
        "contact_impulse": np.array([0.1, 0.0]),
        "success": np.array([False, False]),
        "reward/near": np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        **changes,
    })  # fmt: skip


def test_episodes_are_what_their_steps_add_up_to():
    sums = EpisodeSums(2, 3)
    sums.add(np.array([[1.0, 2.0, 3.0], [0.0, -1.0, -2.0]]), step())
    undefined = {
        "force_load_share": np.full((2, 3), 1 / 3),
        "force_load_share_defined": np.array([False, True]),
        "relative_cost": np.array([0.6, 0.0]),
        "success": np.array([True, False]),
        "contact_impulse": np.array([0.3, 2.0]),
    }
    sums.add(np.array([[0.5, 0.5, 0.5], [1.0, 1.0, 1.0]]), step(**undefined))
    seen = sums.take(np.array([1, 0]))
    assert seen.length.tolist() == [2, 2]
    assert seen.success.tolist() == [False, True]
    np.testing.assert_allclose(seen.reward, [[1, 0, -1], [1.5, 2.5, 3.5]])
    np.testing.assert_allclose(seen.relative_cost, [0.2, 0.4])
    np.testing.assert_allclose(seen.wasted_cost, [3, 1])
    np.testing.assert_allclose(seen.internal_force_level, [7, 5])
    np.testing.assert_allclose(seen.internal_torque_level, [0.7, 0.5])
    np.testing.assert_allclose(seen.contact_impulse, [2.0, 0.4])  # a sum
    np.testing.assert_allclose(
        seen.force_load_share, [[1 / 6, (0.2 + 1 / 3) / 2, (0.8 + 1 / 3) / 2], [0.5, 0.25, 0.25]]
    )
    np.testing.assert_allclose(seen.torque_load_share, [[nan] * 3, [0.1, 0.3, 0.6]])
    # (0.8 − ⅓) / ⅔ and an even step; (½ − ⅓) / ⅔, the other step being undefined
    np.testing.assert_allclose(seen.load_imbalance, [0.35, 0.25])
    np.testing.assert_allclose(seen.reward_terms["near"], [[8, 10, 12], [2, 4, 6]])


def test_a_finished_world_starts_from_zero_and_the_others_go_on():
    sums = EpisodeSums(2, 3)
    for _ in range(2):
        sums.add(np.ones((2, 3)), step())
    assert sums.take(np.array([0])).length.tolist() == [2]
    sums.add(np.ones((2, 3)), step(force_load_share_defined=np.array([False, False])))
    seen = sums.take(np.array([0, 1]))
    assert seen.length.tolist() == [1, 3]
    assert seen.reward[:, 0].tolist() == [1.0, 3.0]
    assert np.isnan(seen.force_load_share[0]).all()
    assert np.isnan(seen.load_imbalance[0])
    np.testing.assert_allclose(seen.relative_cost, [0.2, 0.4])
    np.testing.assert_allclose(seen.force_load_share[1], [0.0, 0.2, 0.8])


def test_one_agent_alone_bears_all_evenly():
    sums = EpisodeSums(2, 1)
    one = {name: step()[name] for name in step() if "share" not in name}
    for kind in ("force", "torque"):
        one[f"{kind}_load_share"] = np.ones((2, 1))
        one[f"{kind}_load_share_defined"] = np.array([True, True])
    sums.add(np.ones((2, 1)), Info({**one, "reward/near": np.ones((2, 1))}))
    assert sums.take(np.array([0, 1])).load_imbalance.tolist() == [0.0, 0.0]


def hand_made():
    """Three episodes of two agents."""
    return Episodes(
        reward=np.array([[1.0, 3.0], [5.0, 7.0], [0.0, 2.0]]),
        length=np.array([10, 30, 200]),
        success=np.array([True, True, False]),
        relative_cost=np.array([0.1, 0.2, 0.6]),
        wasted_cost=np.array([1.0, 2.0, 6.0]),
        internal_force_level=np.array([3.0, 4.0, 8.0]),
        internal_torque_level=np.array([0.5, 1.0, 1.8]),
        force_load_share=np.array([[0.25, 0.75], [nan, nan], [0.5, 0.5]]),
        torque_load_share=np.full((3, 2), nan),
        load_imbalance=np.array([0.5, nan, 0.1]),
        contact_impulse=np.array([0.0, 0.3, 0.9]),
    )


def test_an_evaluation_is_the_mean_over_episodes_by_hand():
    made = Evaluation.of(hand_made(), dt=0.1, policy="mine", seed=4)
    assert (made.policy, made.seed, made.episodes) == ("mine", 4, 3)
    assert made.success_rate == pytest.approx(2 / 3)
    assert made.success_interval == pytest.approx((0.2077, 0.9385), abs=1e-4)  # Wilson's
    assert made.success_time == pytest.approx(2.0)  # of 1 s and 3 s
    assert made.reward == pytest.approx(3.0)
    assert (made.relative_cost, made.wasted_cost) == pytest.approx((0.3, 3.0))
    assert (made.internal_force_level, made.internal_torque_level) == pytest.approx((5.0, 1.1))
    assert made.force_load_share == pytest.approx((0.375, 0.625))
    assert np.isnan(made.torque_load_share).all()
    assert made.load_imbalance == pytest.approx(0.3)
    assert made.contact_impulse == pytest.approx(0.4)
    assert np.isnan(made.sampled_success_rate)
    other = hand_made().pick(np.array([2, 0, 2, 2]))
    both = Evaluation.of(hand_made(), dt=0.1, sampled=other)
    assert both.sampled_success_rate == 0.25
    assert both.sampled_success_interval == pytest.approx((0.0456, 0.6994), abs=1e-4)
    assert both.success_rate == made.success_rate


def test_picked_and_joined_episodes_keep_their_numbers_together():
    seen = hand_made()
    both = Episodes.joined([seen.pick(np.array([2])), seen.pick(np.array([0, 1]))])
    assert both.length.tolist() == [200, 10, 30]
    assert both.reward[:, 1].tolist() == [2.0, 3.0, 7.0]
    assert both.success.tolist() == [False, True, True]


def test_every_cell_of_the_printed_table_is_the_number_of_its_heading():
    rich = pytest.importorskip("rich.console")
    one = Evaluation.of(hand_made(), dt=0.1, policy="mine", sampled=hand_made().pick(np.array([0])))
    none = Evaluation.of(hand_made().pick(np.array([2])), dt=0.1, policy="lost")
    console = rich.Console(width=200, record=True, file=io.StringIO())
    console.print(table([one, none]))
    lines = [line.split() for line in console.export_text().splitlines() if line.strip(" ─")]
    heads = ["success", "95", "%", "sample", "time", "γ", "F_I", "T_I", "share", "skew"]
    assert lines[0] == heads
    assert lines[1] == ["policy", "%", "%", "%", "s", "N", "N·m", "force", "0-1"]
    assert lines[2] == [
        "mine", "66.7", "21-94", "100.0", "2.00", "0.300", "5.00", "1.10", "0.38:0.62", "0.30",
    ]  # fmt: skip
    assert lines[3] == [
        "lost", "0.0", "0-79", "-", "-", "0.600", "8.00", "1.80", "0.50:0.50", "0.10",
    ]  # fmt: skip


def test_what_a_file_says_of_an_evaluation_is_read_back_nan_too():
    lost = Evaluation.of(hand_made().pick(np.array([2])), dt=0.1, policy="lost")
    assert np.isnan(lost.success_time)
    again = Evaluation.from_dict(json.loads(json.dumps(lost.plain())))
    np.testing.assert_equal(asdict(again), asdict(lost))


def test_files_hold_the_numbers_themselves(tmp_path):
    one = Evaluation.of(hand_made(), dt=0.1, policy="mine")
    save([one], tmp_path / "a.csv")
    save([one], tmp_path / "a.json")
    (row,) = csv.DictReader((tmp_path / "a.csv").open())
    assert list(row) == [
        "policy", "episodes", "seed", "success_rate", "success_interval_0", "success_interval_1",
        "sampled_success_rate", "sampled_success_interval_0", "sampled_success_interval_1",
        "success_time", "reward", "relative_cost", "wasted_cost", "internal_force_level",
        "internal_torque_level", "force_load_share_0", "force_load_share_1",
        "torque_load_share_0", "torque_load_share_1", "load_imbalance", "contact_impulse", "cost",
    ]  # fmt: skip
    assert row["force_load_share_1"] == "0.625"
    assert float(row["contact_impulse"]) == one.contact_impulse
    (told,) = json.loads((tmp_path / "a.json").read_text())
    assert told["success_interval"] == list(one.success_interval)
    assert told["torque_load_share"] == [None, None]
    assert told["internal_torque_level"] == one.internal_torque_level
