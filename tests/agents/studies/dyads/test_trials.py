"""Tables of trials: their checks, and what is computed within each trial."""

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("pandas")

import pandas as pd

from coopenv.agents.studies.dyads import reading, trials
from coopenv.errors import InvalidInput
from coopenv.logs import Layout
from coopenv.physics.scene import Box
from tests.agents.studies.dyads.cases import DT, STEPS, make_trials


def test_trials_come_back_from_files_in_order(tmp_path):
    table = make_trials(pairs=2)
    table[table["pair"] == 0].to_csv(tmp_path / "a.csv", index=False)
    backwards = table.sort_values(["condition", "trial", "time"], ascending=[False, False, True])
    backwards[backwards["pair"] == 1].to_parquet(tmp_path / "b.parquet")
    found = reading.read_trials([tmp_path / "b.parquet", tmp_path / "a.csv"])
    expected = table.sort_values(["pair", "condition", "trial", "time"], ignore_index=True)
    pd.testing.assert_frame_equal(found, expected, check_like=True, check_dtype=False)


def test_files_may_have_other_units_names_and_frames(tmp_path):
    table = make_trials(pairs=1, trials=2)
    c, s = np.cos(table["theta"]), np.sin(table["theta"])
    theirs = table.rename(columns={"pair": "dyad", "time": "t"}).drop(
        columns=["r1x", "r1y", "r2x", "r2y"]
    )
    theirs["t"] *= 1000
    theirs["theta"] = np.rad2deg(theirs["theta"])
    for i in (1, 2):
        x, y = table[f"f{i}x"], table[f"f{i}y"]
        theirs[f"f{i}x"], theirs[f"f{i}y"] = c * x - s * y, s * x + c * y
    theirs.to_csv(tmp_path / "lab.csv", index=False)
    layout = Layout(
        columns={"time": "t"}, trial_columns=("dyad", "condition", "trial"), time="ms",
        angle="deg", frame="world", grips=(-1.0, 0.0, 1.0, 0.0),
    )  # fmt: skip
    found = reading.read_trials([tmp_path / "lab.csv"], layout)
    expected = trials.checked_trials(table)
    pd.testing.assert_frame_equal(found, expected, check_like=True, check_dtype=False)


def test_arrays_make_the_same_table_as_columns():
    table = trials.checked_trials(make_trials(pairs=2, trials=1))
    made = trials.table_of(
        pair=table["pair"],
        condition=table["condition"],
        trial=0,
        time=table["time"],
        pose=table[["x", "y", "theta"]],
        applied=trials.applied_wrenches(table),
        grips=trials.grip_positions(table),
        first=1,
    )
    pd.testing.assert_frame_equal(made, table, check_like=True, check_dtype=False)
    with pytest.raises(InvalidInput, match=r"applied must be of shape \(3, 2, 3\)"):
        trials.table_of(
            pair=0, condition="one", trial=0, time=[0, 1, 2], pose=[0, 0, 0],
            applied=np.zeros((4, 2, 3)), grips=np.zeros((2, 2)),
        )  # fmt: skip


@pytest.mark.filterwarnings("error")
def test_keys_may_be_categories_of_which_some_have_no_trial():
    table = make_trials(pairs=2, trials=1)
    expected = trials.checked_trials(table)
    kinds = pd.CategoricalDtype(["none", "blindfold", "one", "both"])
    given = table.assign(condition=table["condition"].astype(kinds))
    found = trials.checked_trials(given)
    assert sorted(found["condition"].unique()) == ["both", "none", "one"]
    by_key = ["pair", "condition", "trial", "time"]
    found = found.astype({"condition": expected["condition"].dtype}).sort_values(by_key)
    pd.testing.assert_frame_equal(found.reset_index(drop=True), expected)
    assert len(trials.durations(found)) == len(expected)


def test_time_turn_and_duration_are_those_of_the_trial():
    table = trials.checked_trials(make_trials(pairs=1, trials=2, spin=-2.0))
    time = DT * np.arange(STEPS)
    np.testing.assert_allclose(trials.elapsed(table), np.tile(time, 6), atol=1e-12)
    np.testing.assert_allclose(trials.durations(table), DT)
    np.testing.assert_allclose(trials.turned(table), np.tile(2 * time, 6), atol=1e-9)


def test_turned_keeps_its_largest_value():
    table = make_trials(pairs=1, trials=1).query("condition == 'one'")
    swing = 3.0 + np.sin(np.linspace(0, np.pi, STEPS))
    table = trials.checked_trials(table.assign(theta=swing))
    assert trials.turned(table)[-1] == pytest.approx(1.0, abs=1e-2)


PLATFORM = Box(center=(2.0, 0.0), size=(2.0, 2.0))


@pytest.mark.parametrize(
    ("angle", "first"),
    [(0.0, 2), (np.pi, 1), (np.pi / 2, 0), (-np.pi / 2, 0), (0.7, 2), (1.569, 2), (1.573, 1)],
)
@pytest.mark.parametrize("edge", [0.0125, 0.51])  # [m] where the platform begins
def test_the_leading_grip_enters_the_platform_first(angle, first, edge):
    table = make_trials(pairs=1, trials=1).assign(theta=angle)  # moves along x from 0 to about 1 m
    table = trials.checked_trials(table)
    platform = Box(center=(edge + 1.0, 0.0), size=(2.0, 6.0))
    assert (trials.first_to_enter(table, platform) == first).all()


def test_nobody_enters_a_platform_far_away_and_a_turned_one_is_met_askew():
    table = trials.checked_trials(make_trials(pairs=1, trials=1).assign(theta=0.0))
    assert (trials.first_to_enter(table, Box(center=(9.0, 9.0), size=(1.0, 1.0))) == 0).all()
    thin = Box(center=(1.5, 0.0), size=(8.0, 0.2), angle=np.pi / 2)  # a gate across the way
    assert (trials.first_to_enter(table, thin) == 2).all()


def test_grips_that_enter_between_the_same_two_samples_are_told_apart():
    path = np.array([[(0.5, 0.0), (0.8, 0.2)], [(1.1, 0.0), (1.1, 0.2)]])  # after 5/6 and 2/3
    assert trials.entered_first(path, PLATFORM) == 2
    assert trials.entered_first(path[:, ::-1], PLATFORM) == 1


def test_a_grip_that_comes_in_past_a_corner_is_inside_once_it_is_behind_both_edges():
    past_corner = [(0.6, -1.2), (1.4, -0.8)]  # behind x = 1 and behind y = −1 after a half
    path = np.array([[past_corner[0], (0.4, 0.0)], [past_corner[1], (1.4, 0.0)]])  # and after 3/5
    assert trials.entered_first(path, PLATFORM) == 1


def test_grips_that_enter_at_the_same_instant_are_neither_of_them_first():
    level = np.array([[(0.5, -0.9), (0.5, 0.9)], [(1.5, -0.9), (1.5, 0.9)]])
    assert trials.entered_first(level, PLATFORM) == 0
    faster = np.array([[(0.0, -0.9), (0.5, 0.9)], [(2.0, -0.9), (1.5, 0.9)]])  # both after a half
    assert trials.entered_first(faster, PLATFORM) == 0
    assert trials.entered_first(level[1:], PLATFORM) == 0  # there from the start


def test_a_start_on_the_platform_counts_as_an_entry_and_leaving_again_changes_nothing():
    path = np.array([[(2.0, 0), (0, 0)], [(0, 0), (2.0, 0)], [(0, 0), (2.0, 0)]])
    assert trials.entered_first(path, PLATFORM) == 1


@pytest.mark.parametrize("every", [1, 7, 50])
def test_who_is_first_does_not_depend_on_the_rate_of_the_recording(every):
    time = np.arange(0.0, 3.0, 0.001)  # 1 kHz, 143 Hz, 20 Hz
    angles = np.pi / 2 + np.array([0.02, -0.02, 0.001, -0.001])
    pose = np.stack(np.broadcast_arrays(0.7 * time[:, None], 0.0, angles), axis=-1)
    path = trials.grips_in_world(pose, np.array([(-0.9, 0.0), (0.9, 0.0)]))
    assert trials.entered_first(path[::every], PLATFORM).tolist() == [1, 2, 1, 2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns=["t1z", "r2y"]), "t1z, r2y"),
        (lambda table: table.iloc[:0], "none"),
        (lambda table: table.assign(f1x=["oops", *table["f1x"][1:]]), "f1x.*'oops' in row 0"),
        (lambda table: table.assign(pair=[None, *table["pair"][1:]]), "pair must be known"),
        (lambda table: table.assign(condition=["", *table["condition"][1:]]), "condition .* row 0"),
        (lambda table: pd.concat([table, table]), r"twice in .*\('0', 'both', '0'\)"),
        (lambda table: table.assign(first=["", *["1"] * (len(table) - 1)]), "trial, got ''"),
        (lambda table: table.assign(first=3), "0, 1 or 2"),
        (lambda table: table.assign(first=[1, *[2] * (len(table) - 1)]), "all through"),
    ],
)
def test_a_bad_table_is_refused(change, message):
    with pytest.raises(InvalidInput, match=message):
        trials.checked_trials(change(make_trials(pairs=1, trials=1)))


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InvalidInput, match=r"gone\.csv"):
        reading.read_trials([tmp_path / "gone.csv"])
    bad = tmp_path / "bad.csv"
    bad.write_text("a,b\n1,2\n")
    with pytest.raises(InvalidInput, match=r"bad\.csv.*column"):
        reading.read_trials([bad])
    make_trials(pairs=1).drop(columns=["pair", "theta"]).to_csv(bad)
    with pytest.raises(InvalidInput, match=r"bad\.csv.*none for pair, theta"):
        reading.read_trials([bad])
    with pytest.raises(InvalidInput, match="got none"):
        reading.read_trials([])
