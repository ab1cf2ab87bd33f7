"""The benchmark of actions' cost: that its rows and ratios are of the kinds on the page."""

import pytest

pytest.importorskip("rich")

from benchmarks.pages import cells
from benchmarks.speed import actions


def test_motions_and_impedances_stand_beside_wrenches_of_the_same_run(monkeypatch):
    monkeypatch.setattr(actions, "REPEATS", 1)
    monkeypatch.setattr(actions, "STEPS", 3)
    row = actions.compare(2)
    assert len(row) == len(actions.COLUMNS)
    assert all(float(cell) > 0 for cell in row)


def test_the_page_has_the_motion_at_256_worlds_within_its_target():
    columns, *rows = cells(actions.PAGE, "actions")
    assert columns == actions.COLUMNS
    (row,) = [row for row in rows if row[0] == "256"]
    assert float(row[columns.index("motion / wrench")]) <= actions.TARGET
