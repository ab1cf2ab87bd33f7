"""Figures of trials: what they show and how it is labelled."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.studies import figures
from coopenv.agents.studies.figures import DISAGREEMENT_PANELS, MOTION_PANELS, Trial
from coopenv.agents.studies.methods import COMPARED, LOOKS, decompose_by_methods
from coopenv.wrench import energy_share, load_share

GRIPS = np.array([(-0.9, 0.0), (0.9, 0.0)])
TIME = np.linspace(0, 1, 11)
APPLIED = np.random.default_rng(0).normal(size=(11, 2, 3))
TRIAL = Trial(
    title="swing",
    time=TIME,
    pose=np.stack([TIME, -TIME, 0 * TIME], axis=-1),
    twist=np.ones((11, 3)),
    applied=APPLIED,
    grips=GRIPS,
    by_method=decompose_by_methods(APPLIED, GRIPS),
)


def curves(panels) -> dict[str, np.ndarray]:
    return {curve.label: curve.values for _, make in panels for curve in make(TRIAL)}


def test_motion_panels_show_what_was_applied_and_shared():
    found = curves(MOTION_PANELS)
    np.testing.assert_array_equal(found["f_1,x"], APPLIED[:, 0, 0])
    np.testing.assert_array_equal(found["t_2"], APPLIED[:, 1, 2])
    np.testing.assert_array_equal(found["α_f,1 (force)"], load_share(APPLIED, GRIPS).force[:, 0])
    energy = energy_share(APPLIED, GRIPS, TRIAL.twist)
    np.testing.assert_array_equal(found["β_rot,1"], energy.angular[:, 0])


def test_disagreement_panels_show_every_method():
    for (label, make), name in zip(
        DISAGREEMENT_PANELS,
        ("internal_force_level", "internal_torque_level", "relative_cost"),
        strict=True,
    ):
        made = {curve.label: curve.values for curve in make(TRIAL)}
        assert list(made) == [LOOKS[method].label for method in COMPARED], label
        for method in COMPARED:
            values = getattr(TRIAL.by_method[method], name)
            np.testing.assert_array_equal(made[LOOKS[method].label], values)


def test_panels_share_scales_and_legends_stay_outside(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(figures, "save_figure", lambda figure, path: seen.append(figure))
    shorter = Trial(
        title="rest", time=TIME[:5], pose=TRIAL.pose[:5], twist=TRIAL.twist[:5],
        applied=0 * APPLIED[:5], grips=GRIPS,
        by_method=decompose_by_methods(0 * APPLIED[:5], GRIPS),
    )  # fmt: skip
    figures.draw_trials(
        [TRIAL, shorter], [*MOTION_PANELS, *DISAGREEMENT_PANELS], tmp_path / "x.png", marks=[0.5]
    )
    (figure,) = seen
    figure.draw_without_rendering()
    panels = np.reshape(figure.axes, (-1, 2))
    assert len(panels) == len(MOTION_PANELS) + 3
    assert [axes.get_title() for axes in panels[0]] == ["swing", "rest"]
    explained = 0
    for left, right in panels:
        assert left.get_ylim() == right.get_ylim()
        assert left.get_ylabel()
        legend = right.get_legend()
        if legend is not None:
            explained += 1
            assert legend.get_window_extent().x0 >= right.get_window_extent().x1
    assert explained == len(MOTION_PANELS) + 1  # the methods are explained once


def test_a_figure_is_a_png(tmp_path):
    figures.draw_trials([TRIAL], DISAGREEMENT_PANELS[:1], tmp_path / "one.png", title="one")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["one.png"]


def test_a_legend_stands_beside_its_panel_without_a_frame():
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    axes.plot([0, 1], [0, 1], label="γ")
    figures.legend_beside(axes)
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["γ"]
    assert not legend.get_frame_on()
    bare = Figure().subplots()
    figures.legend_beside(bare)
    assert bare.get_legend() is None
