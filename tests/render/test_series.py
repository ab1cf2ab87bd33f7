"""Time series beside a film: what is past is bright, and nothing that happened is thinned away."""

import numpy as np
import pytest

pytest.importorskip("pygame")

from coopenv.errors import InvalidInput
from coopenv.render.look import AGENTS, INTERNAL
from coopenv.render.series import Panel, Series, measure_panels, round_numbers

TIME = np.linspace(0.0, 2.0, 41)


def series(*curves, time=TIME, span=(0.0, 1.0)) -> Series:
    panel = Panel("γ", np.array(curves), (INTERNAL, AGENTS[0])[: len(curves)], span)
    return Series(time, [panel], width=300, height=120, unit=1.0)


def columns_of(picture, color=INTERNAL) -> np.ndarray:
    """Where across a picture a colour is, below the title."""
    return np.flatnonzero((picture[30:] == color).all(axis=-1).any(axis=0))


def test_a_curve_is_bright_up_to_the_cursor_and_pale_beyond():
    drawn = series(np.full(41, 0.5))
    first, middle, last = (columns_of(drawn.picture(row)).max() for row in (0, 20, 40))
    start = columns_of(drawn.picture(40)).min()
    assert first < start + 8  # the dot alone
    assert middle == pytest.approx((start + last) / 2, abs=8)
    assert last > 280


def test_what_is_undefined_leaves_a_gap():
    values = np.full(41, 0.5)
    values[15:25] = np.nan
    there = columns_of(series(values).picture(40))
    assert np.diff(there).max() == pytest.approx(11 / 40 * (there.max() - there.min()), abs=8)
    assert np.diff(columns_of(series(np.full(41, 0.5)).picture(40))).max() == 1


@pytest.mark.parametrize("row", [0, 51_234, 99_999])
def test_a_spike_of_one_row_among_many_shows(row):
    time = np.linspace(0.0, 100.0, 100_000)
    values = np.zeros(len(time))
    flat = series(values, time=time).picture(0)
    values[row] = 1.0
    spiked = series(values, time=time).picture(0)
    assert (flat[28:60] != spiked[28:60]).any()


def test_a_value_beyond_the_span_is_cut_off_in_the_picture_and_told_in_numbers():
    least, far = (series(np.full(41, value)).picture(40) for value in (1.5, 1e9))
    assert not len(columns_of(far[:, :280]))
    assert (far[:28] != least[:28]).any()  # the number


def test_one_row_that_lasts_no_time_is_drawn():
    assert len(columns_of(series([0.5], time=np.zeros(1)).picture(0)))


def test_curves_of_other_rows_are_refused():
    for time in (TIME[:3], TIME[:0]):
        with pytest.raises(InvalidInput, match="a value for each time"):
            series(np.zeros(41)[: 41 * (len(time) > 0)], time=time)


def test_the_measures_have_a_panel_each_and_agents_their_colours():
    level, share = np.zeros(5), np.zeros((5, 3))
    panels = measure_panels(level, level, level, share, share)
    assert [panel.label for panel in panels] == [
        "γ", "F_I [N]", "T_I [N·m]", "force load share", "torque load share",
    ]  # fmt: skip
    assert panels[3].curves.shape == (3, 5)
    assert panels[3].colors == AGENTS[:3]


def test_round_numbers_stand_at_both_ends_of_a_scale():
    assert round_numbers(0.0, 10.0, 5) == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]
    assert round_numbers(-1.0, 1.0, 4) == [-1.0, -0.5, 0.0, 0.5, 1.0]
