"""The analysis of the human study on trials whose answer is known."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("statsmodels")
pytest.importorskip("matplotlib")
pytest.importorskip("pandas")

import pandas as pd

from coopenv.agents.studies.dyads import report
from coopenv.agents.studies.dyads.analysis import (
    METHODS,
    analyse,
    internal_torques,
    quadrant_shares,
)
from coopenv.agents.studies.dyads.trials import checked_trials
from coopenv.errors import InvalidInput
from tests.agents.studies.dyads.cases import GUIDES, TORQUE, UNDONE, make_trials, undone, varied

OURS = "prioritized_torque"


def mixed_shares(pair, guide, trial, time):
    """Dominant, then passive, then (beyond 45°, which must not count) a specialist.

    With a guide to one, three quarters of the time that counts is dominant, else a half; pair k
    departs from that by k samples.
    """
    count = int((time <= np.pi / 4).sum())  # the beam turns at 1 rad/s
    dominant = round(count * (0.75 if guide == "one" else 0.5)) - pair % 3 - (guide == "none")
    step = np.arange(len(time))
    force = np.where(step < dominant, 0.8, 0.2)
    torque = np.where(step < dominant, 0.7, 0.3)
    late = step >= count
    return np.where(late, 0.9, force) + 1e-3 * trial, np.where(late, 0.1, torque) + 1e-3 * step


def test_internal_torque_is_that_of_the_first_600_ms_by_method():
    found = internal_torques(checked_trials(make_trials(disagreement=undone)))
    assert len(found) == 6 * len(GUIDES) * len(METHODS)
    assert (found["num_trials"] == 3).all()
    assert found.index.tolist() == list(range(len(found)))
    for row in found.itertuples():
        own = UNDONE[row.condition] + 0.02 * row.pair * (1 + (row.condition == "none"))
        more = 0.0 if row.method in (OURS, "point_mass") else TORQUE / 2
        assert row.internal_torque == pytest.approx(own + more, abs=1e-9), row


def test_only_trials_count_in_which_agent_1_is_first():
    def first(pair, guide, trial):
        return 1 if trial == 1 else 2 * (trial == 2)

    def wild(pair, guide, trial, time):
        return undone(pair, guide, trial, time) * (1 if trial == 1 else 100)

    found = internal_torques(checked_trials(make_trials(disagreement=wild, first=first)))
    ours = found[(found["method"] == OURS) & (found["pair"] == 0)].set_index("condition")
    assert (ours["num_trials"] == 1).all()
    assert ours["internal_torque"].to_dict() == pytest.approx(UNDONE)


def test_uneven_sampling_does_not_change_a_mean_over_time():
    trials = make_trials(pairs=2, trials=1, disagreement=undone)
    own = trials.groupby(["pair", "condition"])["time"].transform("min")
    sparse = trials[((trials["time"] - own) * 20).round().astype(int) % 4 != 1]
    pd.testing.assert_frame_equal(
        internal_torques(checked_trials(trials)), internal_torques(checked_trials(sparse))
    )


def test_quadrants_count_time_up_to_45_degrees_whatever_the_direction():
    for spin in (1.0, -1.0):
        found = quadrant_shares(checked_trials(make_trials(shares=mixed_shares, spin=spin)))
        count = 16  # samples at 0, 0.05, ..., 0.75 s
        for row in found.itertuples():
            wanted = 12 if row.condition == "one" else 8
            wanted -= row.pair % 3 + (row.condition == "none")
            assert row.dominant == pytest.approx(wanted / count)
            assert row.passive == pytest.approx(1 - wanted / count)
            assert row.force_specialist + row.torque_specialist == pytest.approx(0.0)


def test_the_analysis_finds_the_effects_that_were_put_in():
    table = make_trials(disagreement=undone)
    analysis = analyse(table)
    method, guide, both = analysis.torque_effects
    assert analysis.conditions == GUIDES
    assert (analysis.num_pairs, analysis.num_trials) == (6, 54)
    assert (method.df_effect, method.df_error) == (4, 20)
    assert (guide.df_effect, guide.df_error) == (2, 10)
    assert (both.df_effect, both.df_error) == (8, 40)
    assert guide.p < 1e-3
    assert guide.f == pytest.approx(_f_of_guide(table))
    assert np.isnan(method.f)  # pseudoinverses add TORQUE / 2 to everybody: no error


def _f_of_guide(table: Any) -> float:
    """From the disagreement that was put in, by sums of squares."""
    early = table[
        table.groupby(["pair", "condition", "trial"])["time"].transform("min") + 0.59
        > table["time"]
    ]
    cells = -early.groupby(["pair", "condition"])["t2z"].mean().unstack().to_numpy()
    rest = cells - cells.mean(axis=0) - cells.mean(axis=1, keepdims=True) + cells.mean()
    explained = len(cells) * ((cells.mean(axis=0) - cells.mean()) ** 2).sum()
    return (explained / 2) / ((rest**2).sum() / (2 * (len(cells) - 1)))


@pytest.fixture(scope="module")
def full():
    """Trials with every effect, analysed."""
    generator = np.random.default_rng(4)

    def shares(pair, guide, trial, time):
        force, torque = mixed_shares(pair, guide, trial, time)
        return force, np.clip(torque + generator.normal(0, 0.05, len(time)), 0, 1)

    return analyse(make_trials(disagreement=varied, shares=shares))


def test_effects_on_dominance_follow_the_guide():
    analysis = analyse(make_trials(shares=mixed_shares, disagreement=varied))
    (guide,) = analysis.dominance_effects
    assert (guide.df_effect, guide.df_error) == (2, 10)
    assert guide.p < 1e-3


def test_an_incomplete_pair_is_left_out_of_the_anova_and_named():
    def first(pair, guide, trial):
        return 2 if (pair, guide) == (4, "both") else 1

    analysis = analyse(make_trials(disagreement=varied, first=first))
    assert analysis.torque_effects[0].df_error == 4 * 4
    assert any("[4]" in note for note in analysis.notes)


def test_what_cannot_be_analysed_is_said():
    table = make_trials(pairs=1, disagreement=varied)
    analysis = analyse(table)
    assert analysis.torque_effects == ()
    assert any("2 subjects" in note for note in analysis.notes)
    claims = report.claims(analysis)
    assert not claims[0].holds
    assert "2 subjects" in claims[0].why
    with pytest.raises(InvalidInput, match="first must be 1"):
        analyse(table.assign(first=0))
    with pytest.raises(InvalidInput, match="platform"):
        analyse(table.drop(columns="first"))


def test_the_comparison_states_differences_to_the_human_numbers(full):
    rows = {row["quantity"]: row for row in report.comparison(full)}
    one = rows["T_I, ours, guide to one [N·m]"]
    assert one["people"] == "0.1548 ± 0.0693"
    here = float(one["recorded trials"].split()[0])
    assert float(one["difference"]) == pytest.approx(here - 0.1548, abs=1e-4)
    assert "(6 pairs)" in one["recorded trials"]
    f = rows["F of method × guide on T_I"]
    assert f["people"] == "F(8, 88) = 3.1"
    assert f["recorded trials"].startswith("F(8, 40) = ")


def test_everything_is_written(tmp_path, full):
    claims, files = report.write(full, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(files)
    assert len(claims) == 7
    for name in ("internal_torque.png", "load_density.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    torque = pd.read_csv(tmp_path / "internal_torque.csv")
    assert set(torque["method"]) == set(METHODS)
    saved = np.load(tmp_path / "load_density.npz")
    for name, density in zip(saved["condition"], saved["density"], strict=True):
        np.testing.assert_array_equal(density, full.densities[name].density)
    assert set(saved["condition"]) == set(full.densities)
    assert saved["share"].shape == (101,)
