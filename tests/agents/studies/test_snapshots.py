"""The study of snapshots: its claims, what breaks them, what it writes."""

import csv

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv import wrench
from coopenv.agents.studies.snapshots import examples, grasps, pairs, pictures, report
from coopenv.agents.studies.snapshots.report import SnapshotsConfig
from coopenv.errors import InvalidInput

FEW = SnapshotsConfig(samples=1000)


@pytest.fixture(scope="module")
def found():
    return report.claims(FEW)


def test_every_claim_holds_but_equation_24_as_it_is_printed(found):
    assert len(found) > 35
    failed = [claim.source for claim in found if not claim.holds]
    assert failed == ["eq. 24, as printed"]
    assert all(claim.why for claim in found if not claim.holds)


def test_every_figure_has_claims_and_a_source_of_its_numbers(found):
    figures = {row["figure"] for row in report.sources()}
    assert figures == {f"Fig. {number}" for number in (2, 3, 4, 5, 6, 7, 8, 17)}
    for figure in figures:
        assert any(figure in claim.source for claim in found), figure


def test_other_forces_than_those_reconstructed_do_not_give_the_sums_of_figure_5(monkeypatch):
    other = examples.TRIO.copy()
    other[0, 0] += 0.1
    monkeypatch.setattr(examples, "TRIO", other)
    broken = [claim.text for claim in grasps.trio_claims() if not claim.holds]
    assert any("Σ‖f_M‖ = 4.472" in text for text in broken)


def test_an_answer_that_is_not_optimal_breaks_the_claim_of_the_least_cost(monkeypatch):
    def worse(applied, grips, **options):
        return wrench.decompose(applied, grips, method="nonsqueezing")

    monkeypatch.setattr(pairs, "decompose", worse)
    broken = [claim.text for claim in pairs.lens_claims(500, 0) if not claim.holds]
    assert any(text.startswith("ours lies in the lens") for text in broken)


def test_in_figure_4_all_that_the_second_effector_applies_is_internal_and_it_balances():
    panels = pictures.panels()["fig4"]
    assert len(panels) == 2
    for panel in panels:
        internal = panel.options["internal"]
        np.testing.assert_array_equal(panel.applied[1], internal[1])
        np.testing.assert_array_equal(internal[0], -internal[1])
        assert np.linalg.norm(internal[1]) > 0.1


def test_the_random_splits_of_a_pair_balance_are_plausible_and_fill_the_lens():
    splits = pairs.plausible_splits(2000, 1)
    assert len(splits) > 50
    off = wrench.object_wrench(splits, examples.SHORTER)
    wanted = wrench.object_wrench(examples.PAIR, examples.SHORTER)
    np.testing.assert_allclose(off, np.broadcast_to(wanted, off.shape), atol=1e-12)
    assert np.ptp(splits[:, 0, :2], axis=0).min() > 0.5


def test_panels_are_drawn_into_one_picture_with_one_legend(tmp_path):
    panels = pictures.panels()
    assert [*panels] == [f"fig{number}" for number in range(2, 9)]
    pictures.draw("fig7", panels["fig7"], tmp_path / "fig7.png")
    assert 5_000 < (tmp_path / "fig7.png").stat().st_size < 250_000


def test_it_writes_claims_sources_and_a_picture_for_each_figure(tmp_path, monkeypatch, found):
    drawn = []
    monkeypatch.setattr(report, "claims", lambda config: found)
    monkeypatch.setattr(report, "draw", lambda name, shown, path: drawn.append(path.name))
    monkeypatch.setattr(report, "draw_power", lambda path: drawn.append(path.name))
    _, files = report.write(FEW, tmp_path)
    assert drawn == [f"fig{number}.png" for number in (2, 3, 4, 5, 6, 7, 8, 17)]
    assert {"claims.md", "claims.csv", "sources.md", "sources.csv", *drawn} == set(files)
    with (tmp_path / "claims.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(found)


@pytest.mark.parametrize("values", [{"samples": 10}, {"samples": 1.5}, {"seed": -1}])
def test_wrong_numbers_are_refused(values):
    with pytest.raises(InvalidInput, match=next(iter(values))):
        SnapshotsConfig(**values)


def test_how_far_a_split_lies_outside_its_ball_is_that_of_the_ball():
    internal = 3.0 * examples.SQUEEZE
    manipulation = examples.GRASP - internal
    out = np.linalg.norm((manipulation - examples.GRASP / 2)[:, :2], axis=-1)
    out -= np.linalg.norm(examples.GRASP[:, :2], axis=-1) / 2
    assert grasps.beyond(internal) == pytest.approx(max(out.max(), 0.0), rel=1e-9)
    assert grasps.beyond(internal) > 1.0


def test_the_picture_of_powers_has_the_band_and_the_velocity_of_its_claim(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(pictures, "save_figure", lambda figure, path: drawn.append(figure))
    pictures.draw_power(tmp_path / "power.png")
    right = drawn[0].axes[1]
    by_label = dict(zip(*reversed(right.get_legend_handles_labels()), strict=True))
    band = next(artist for label, artist in by_label.items() if label.startswith("between 0 and"))
    applied = by_label["Ė_2, applied"].get_ydata()
    heights = band.get_paths()[0].vertices[:, 1]
    assert heights.min() == pytest.approx(min(applied.min(), 0.0))
    assert heights.max() == pytest.approx(max(applied.max(), 0.0))
    velocity = by_label["the velocity of the claim"].get_xdata()[0]
    expected = np.degrees(np.arctan2(examples.TWIST[1], examples.TWIST[0]))
    assert velocity == pytest.approx(expected)
