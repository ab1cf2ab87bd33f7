"""The reward-shaping grid: its page shows the runs that were saved, and says what they say."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning import shaping
from benchmarks.pages import filled
from coopenv.agents.experiments.file import load
from tests.agents.experiments.test_grid import EXAMPLE


def run(seed, price="none", share="", **measured):
    values = {**dict.fromkeys(shaping.KEPT, 1.0), **measured}
    return shaping.Run(action="wrench", price=price, share=share, seed=seed, measured=values)


def test_the_page_shows_the_runs_that_were_saved():
    shown = filled(shaping.PAGE, shaping.tables(shaping.saved()))
    assert shown == shaping.PAGE.read_text(encoding="utf-8")


def test_the_runs_are_those_of_the_file_of_examples():
    cells = load(EXAMPLE)[0].cells()
    asked = {(cell.levels["action"], cell.levels["reward"], cell.seed) for cell in cells}
    found = [(one.action, f"{one.price}{one.share}", one.seed) for one in shaping.saved()]
    assert len(found) == len(set(found))
    assert set(found) == asked


def test_what_a_price_changes_is_its_difference_to_none_with_the_same_share():
    runs = [run(seed, success_rate=1.0) for seed in range(3)]
    runs += [run(seed, "effort", success_rate=0.5 + 0.1 * seed) for seed in range(3)]
    runs += [run(seed, "effort", "_80_20", success_rate=0.0) for seed in range(3)]
    mine = shaping.of(runs, "wrench", "effort", "", "success_rate")
    others = shaping.of(runs, "wrench", "none", "", "success_rate")
    found = shaping.difference(mine, others)
    assert found.value == pytest.approx(-40.0)  # [%]
    assert found.low >= -50.0
    assert found.high <= -30.0
    assert found.text(0, sign="+").startswith("-40 [")


def test_runs_without_success_have_no_time_and_do_not_hide_those_that_have():
    runs = [run(0, success_time=np.nan), run(1, success_time=2.0)]
    assert shaping.of(runs, "wrench", "none", "", "success_time").tolist() == [2.0]
    nobody = shaping.of(runs[:1], "wrench", "none", "", "success_time")
    assert shaping.estimate(nobody).text(2) == "–"


def test_the_picture_has_a_line_a_reward_in_every_panel(tmp_path):
    pytest.importorskip("matplotlib")
    panels = shaping.shown([run(seed) for seed in range(2)])
    assert len(panels) == len(shaping.ACTIONS) * len(shaping.PICTURED)
    assert {len(lines) for lines in panels.values()} == {2 * len(shaping.PRICES)}
    shaping.draw(panels, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
