"""The picture holds what there is to see, however many rows there are."""

import numpy as np
import pytest

from coopenv.logs import Layout, analyse, read
from coopenv.logs.envelope import Envelope
from coopenv.logs.figure import panels
from tests.logs import cases


@pytest.mark.parametrize("rows", [1, 7, 100, 3001])
@pytest.mark.parametrize("chunk", [1000, 64])
def test_no_extreme_is_lost_however_many_rows_are_merged(rows, chunk):
    values = np.random.default_rng(0).normal(size=(2, rows))
    values[1, rows // 3 : rows // 2] = np.nan
    envelope = Envelope(bins=20)
    x = np.arange(float(rows))
    for first in range(0, rows, chunk):
        part = slice(first, first + chunk)
        envelope.add(x[part], values[:, part])
    places, low, high, mean = envelope.curves()
    assert len(places) <= 40 or rows <= 40
    assert np.nanmin(low, axis=1).tolist() == np.nanmin(values, axis=1).tolist()
    assert np.nanmax(high, axis=1).tolist() == np.nanmax(values, axis=1).tolist()
    assert (np.diff(places) > 0).all()
    drawn = np.isfinite(mean)
    assert (low[drawn] <= mean[drawn] + 1e-12).all()
    assert (mean[drawn] <= high[drawn] + 1e-12).all()
    if rows <= 40:
        np.testing.assert_array_equal(mean, values)


@pytest.mark.parametrize(
    ("count", "dimension", "twist"), [(2, 2, True), (1, 2, False), (3, 3, True), (12, 2, False)]
)
def test_every_panel_has_its_columns_and_a_unit(count, dimension, twist, tmp_path):
    columns = cases.planar(4, count) if dimension == 2 else cases.spatial(4, count)
    layout = Layout()
    if dimension == 2:
        layout = Layout(grips=tuple(np.random.default_rng(0).normal(size=2 * count).tolist()))
    if not twist:
        layout = Layout(grips=layout.grips, columns=dict.fromkeys(("vx", "vy", "omega"), ""))
    analysis = analyse(read(cases.save(columns, tmp_path / "a.npz"), layout))
    made = panels(count, dimension, twist)
    assert len(made) == 12 + 2 * twist
    for panel in made:
        assert panel.curves
        assert all(name in analysis.columns for curve in panel.curves for name in curve.columns)
        assert "[" in panel.label or "share" in panel.label or "γ" in panel.label
    drawn = {name for panel in made for curve in panel.curves for name in curve.columns}
    assert {"internal_force_level", "internal_torque_level", "relative_cost"} <= drawn
    assert {"f1x", "internal_f1y", "manipulation_t1z", f"force_load_share_{count}"} <= drawn


def test_later_trials_are_drawn_after_earlier_ones(tmp_path):
    pytest.importorskip("matplotlib")
    from coopenv.logs.figure import Picture

    columns = cases.planar(30) | {"trial": np.repeat([1, 2, 3], 10)}
    columns["time"] = np.tile(np.arange(5.0, 15.0), 3)
    recording = read(cases.save(columns, tmp_path / "a.npz"), Layout(grips=cases.BEAM))
    picture = Picture("trials")
    for rows in (slice(0, 10), slice(10, 17), slice(17, 30)):
        part = recording.take(rows)
        picture.add(part, analyse(part))
    x = picture._envelope.curves()[0]
    assert x.tolist() == [*range(5, 15), *range(14, 24), *range(23, 33)]
    assert picture._axis.starts == [14.0, 23.0]
    picture.draw(tmp_path / "a.png")
    drawn = (tmp_path / "a.png").read_bytes()
    assert drawn.startswith(b"\x89PNG")
    width, height = np.frombuffer(drawn, dtype=">u4", count=2, offset=16).tolist()  # [px]
    assert (width, height) == (1500, 115 * (1 + 2 * 7))  # seven rows of panels
