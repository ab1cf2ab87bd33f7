"""The beam study: what it carries, what it claims, what it writes."""

import csv
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.studies.beam import report, simulation
from coopenv.agents.studies.beam.simulation import MOTIONS, BeamConfig
from coopenv.agents.studies.methods import COMPARED, decompose_by_methods
from coopenv.errors import InvalidInput
from coopenv.wrench import load_share, object_wrench

GRIPS = np.array([(-1.0, 0.0), (1.0, 0.0)])
BRIEF = BeamConfig(duration=2.0, dt=0.02)


@pytest.fixture(scope="module")
def run():
    return simulation.simulate(BRIEF)


@pytest.fixture(scope="module")
def by_method(run):
    return decompose_by_methods(run.applied, run.grips)


def test_the_body_follows_the_plan_by_the_recorded_wrenches(run):
    assert run.applied.shape == (2, len(MOTIONS), 100, 2, 3)
    assert run.tracking_error[..., 0].max() < 1e-3  # [m] of 2.2 m
    assert run.tracking_error[..., 1].max() < 1e-3  # [rad] of 2
    np.testing.assert_allclose(object_wrench(run.applied, run.grips), run.object_wrench, atol=1e-12)
    ends = run.pose[0, :, -1]
    np.testing.assert_allclose(ends, [start_and_way(i) for i in range(4)], atol=1e-3)


def start_and_way(motion: int) -> np.ndarray:
    return np.array(simulation.STARTS[motion]) + np.array(simulation.WAYS[motion])


def test_a_beam_that_is_harder_to_turn_needs_more_torque(run):
    largest = np.abs(run.object_wrench[:, 0, :, 2]).max(axis=1)
    assert run.inertias == (1.0, 1 / 3)
    assert largest[0] > 1.2 * largest[1]


def test_forces_are_shared_as_wanted_and_add_up():
    wanted = np.array([(3.0, 0.0, 0.0), (-2.0, 0.0, 1.5), (1.0, 2.0, -0.7)])
    for mass, share in ((1.0, 0.5), (4.0, 0.5), (2.5, 0.9), (1.0, 0.0)):
        applied = simulation.share(wanted, GRIPS, mass, share)
        np.testing.assert_allclose(object_wrench(applied, GRIPS), wanted, atol=1e-12)
        assert load_share(applied[0], GRIPS).force == pytest.approx([share, 1 - share])
        torque = wanted[:, 2] / (2 + 2 * mass)  # J* / J_o*, both agents
        np.testing.assert_allclose(applied[:, :, 2], np.stack([torque, torque], axis=-1))


def test_every_motion_goes_through_every_combination_of_the_schedules(run):
    parts = simulation.sections(run)
    assert parts.sum(axis=0).tolist() == [1] * 100
    assert parts.sum(axis=1).min() >= 10
    assert run.virtual_mass.max() == pytest.approx(4.0, abs=0.02)
    assert (run.wanted_share.min(), run.wanted_share.max()) == pytest.approx((0, 1), abs=0.02)


def test_the_papers_claims_hold_and_ours_about_askew_motion_do_not(run, by_method):
    found = report.claims(run, by_method)
    assert len(found) == 21
    for claim in found:
        assert claim.holds == (claim.source != report.BEYOND), claim


def test_a_disagreement_that_is_put_in_breaks_the_claims(run):
    applied = run.applied.copy()
    applied[0, 2, 50, :, 2] += [0.5, -0.5]  # [N·m], one sample of pure translation
    spoilt = replace(run, applied=applied)
    found = report.claims(spoilt, decompose_by_methods(applied, run.grips))
    broken = {claim.text.split(":")[0] for claim in found if not claim.holds}
    assert {"ours", "ours (pTtTC)"} <= broken
    level = next(claim for claim in found if claim.text.startswith("ours: T_I"))
    assert level.measured == pytest.approx(0.5)


def test_a_body_that_leaves_its_plan_breaks_the_claims(run, by_method):
    lost = replace(run, pose=run.pose + np.array([0.01, 0.0, 0.02]))
    found = report.claims(lost, by_method)
    assert [claim.holds for claim in found[:2]] == [False, False]


@pytest.mark.parametrize("inertias", [(1.0, 1 / 3), (0.5,)])
def test_two_figures_for_each_inertia_show_every_motion_and_where_sections_meet(
    inertias, run, tmp_path, monkeypatch
):
    drawn = {}

    def draw(trials, panels, path, *, title, marks):
        drawn[path.name] = (trials, [label for label, _ in panels], title, marks)

    monkeypatch.setattr(report, "draw_trials", draw)
    few = replace(
        run, inertias=inertias, **{
            name: getattr(run, name)[: len(inertias)] for name in ("applied", "pose", "twist")
        },
    )  # fmt: skip
    files = report.draw(few, decompose_by_methods(few.applied, few.grips), tmp_path)
    assert [*drawn] == files
    endings = [""] if len(inertias) == 1 else ["_J1", "_J0p333"]
    assert files == [f"{kind}{end}.png" for end in endings for kind in ("motion", "disagreement")]
    for number, (trials, labels, title, marks) in enumerate(drawn.values()):
        i = number // 2
        assert f"J = {inertias[i]:.3g} kg·m²" in title
        assert "schedules" in labels
        assert marks == pytest.approx([run.time[-1] / 4, run.time[-1] / 2, 3 * run.time[-1] / 4])
        assert [trial.title for trial in trials] == list(MOTIONS)
        for j, trial in enumerate(trials):
            np.testing.assert_array_equal(trial.applied, run.applied[i, j])
            np.testing.assert_array_equal(trial.pose, run.pose[i, j])
            np.testing.assert_array_equal(trial.twist, run.twist[i, j])
            np.testing.assert_array_equal(trial.planned, run.planned[j])
            assert set(trial.by_method) == set(COMPARED)


def test_the_series_are_what_was_recorded(tmp_path, run, by_method):
    report.save_series(run, by_method, tmp_path)
    with (tmp_path / "series.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * len(MOTIONS) * 100
    last = rows[-1]
    assert (last["motion"], float(last["inertia"])) == (MOTIONS[-1], pytest.approx(1 / 3))
    assert float(last["f2x"]) == pytest.approx(run.applied[-1, -1, -1, 1, 0])
    level = by_method["nonsqueezing"].internal_torque_level[-1, -1, -1]
    assert float(last["nonsqueezing_T_I"]) == pytest.approx(level)
    arrays = np.load(tmp_path / "series.npz")
    np.testing.assert_array_equal(arrays["applied"], run.applied)
    np.testing.assert_array_equal(arrays["internal_optimal"], by_method["optimal"].internal)
    assert all(f"internal_{name}" in arrays for name in COMPARED)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"inertias": ()}, "inertias"),
        ({"inertias": (0.0,)}, "inertias"),
        ({"dt": 0.07}, "multiple of dt"),
        ({"duration": 0.3}, "at least 40 steps"),
        ({"damping": -1.0}, "damping"),
    ],
)
def test_a_bad_configuration_is_refused(values, message):
    with pytest.raises(InvalidInput, match=message):
        BeamConfig(**values)


def test_a_twist_is_told_in_the_object_frame_at_the_middle_of_its_step():
    before = SimpleNamespace(pose=np.array([[0.0, 0.0, 3.0]]), twist=np.array([[1.0, 0.0, 0.4]]))
    after = SimpleNamespace(pose=np.array([[0.0, 0.0, -3.0]]), twist=np.array([[1.0, 0.0, 0.4]]))
    angle = np.pi  # half of the way from 3 on to 2 pi - 3
    expected = [[np.cos(angle), -np.sin(angle), 0.4]]
    np.testing.assert_allclose(simulation.object_twist(before, after), expected, atol=1e-12)
