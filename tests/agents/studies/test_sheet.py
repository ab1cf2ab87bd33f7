"""The sheet of one trial: panels in columns, none over another, each with its legend."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.studies import sheet
from coopenv.agents.studies.figures import MOTION_PANELS
from tests.agents.studies.test_figures import TRIAL


@pytest.mark.parametrize(
    "columns",
    [
        [MOTION_PANELS[:3]],
        [MOTION_PANELS[:1], MOTION_PANELS[1:2]],
        [MOTION_PANELS[:2], MOTION_PANELS[2:4], MOTION_PANELS[4:6]],
    ],
    ids=["one column", "one row", "more columns than rows"],
)
def test_panels_stand_below_and_beside_each_other_within_the_sheet(columns, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(sheet, "save_figure", lambda figure, path: seen.append((figure, path)))
    sheet.draw_sheet(TRIAL, columns, tmp_path / "x.png", marks=[0.25, 0.5])
    ((figure, path),) = seen
    assert path == tmp_path / "x.png"
    figure.draw_without_rendering()
    panels = np.reshape(figure.axes, (-1, len(columns))).T
    page = figure.get_window_extent()
    right = 0.0
    for axes_of, panels_of in zip(panels, columns, strict=True):
        assert [axes.get_ylabel() for axes in axes_of] == [label for label, _ in panels_of]
        assert [axes.get_xlabel() for axes in axes_of] == [""] * (len(axes_of) - 1) + ["time [s]"]
        left, right, top = right, 0.0, page.y1
        for axes, (_, curves_of) in zip(axes_of, panels_of, strict=True):
            drawn = [np.asarray(line.get_ydata()) for line in axes.lines[:-2]]
            for line, curve in zip(drawn, curves_of(TRIAL), strict=True):
                np.testing.assert_array_equal(line, curve.values)
            assert [line.get_xdata()[0] for line in axes.lines[-2:]] == [0.25, 0.5]  # the marks
            panel, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
            assert left <= axes.get_tightbbox().x0
            assert panel.x1 <= legend.x0
            assert panel.y1 <= top
            top, right = panel.y0, max(right, legend.x1)
        assert right <= page.x1
        assert axes_of[-1].get_tightbbox().y0 >= page.y0
    assert figure.get_suptitle() == TRIAL.title
