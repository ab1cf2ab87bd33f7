"""The reward-shaping grid: its page shows the runs that were saved, and says what they say."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning.shaping import answer, picture, runs
from benchmarks.learning.shaping.__main__ import PAGE
from benchmarks.pages import filled
from coopenv.agents.experiments.file import load
from tests.agents.experiments.test_grid import EXAMPLE


def run(seed, price="none", share="", **measured):
    values = {**dict.fromkeys(runs.KEPT, 1.0), **measured}
    return runs.Run(action="wrench", price=price, share=share, seed=seed, measured=values)


def test_the_page_shows_the_runs_that_were_saved():
    shown = filled(PAGE, answer.tables(runs.saved()))
    assert shown == PAGE.read_text(encoding="utf-8")


def test_the_runs_are_those_of_the_file_of_examples():
    cells = load(EXAMPLE)[0].cells()
    asked = {(cell.levels["action"], cell.levels["reward"], cell.seed) for cell in cells}
    found = [(one.action, f"{one.price}{one.share}", one.seed) for one in runs.saved()]
    assert len(found) == len(set(found))
    assert set(found) == asked


def test_what_a_price_changes_is_its_difference_to_none_with_the_same_share():
    made = [run(seed, success_rate=1.0) for seed in range(3)]
    made += [run(seed, "effort", success_rate=0.5 + 0.1 * seed) for seed in range(3)]
    made += [run(seed, "effort", "_80_20", success_rate=0.0) for seed in range(3)]
    mine = runs.of(made, "wrench", "effort", "", "success_rate")
    others = runs.of(made, "wrench", "none", "", "success_rate")
    found = answer.difference(mine, others)
    assert found.value == pytest.approx(-40.0)  # [%]
    assert found.low >= -50.0
    assert found.high <= -30.0
    assert found.text(0, sign="+").startswith("-40 [")


def test_runs_without_success_have_no_time_and_do_not_hide_those_that_have():
    made = [run(0, success_time=np.nan), run(1, success_time=2.0)]
    assert runs.of(made, "wrench", "none", "", "success_time").tolist() == [2.0]
    nobody = runs.of(made[:1], "wrench", "none", "", "success_time")
    assert answer.estimate(nobody).text(2) == "–"


def test_the_picture_has_a_line_a_reward_in_every_panel(tmp_path):
    pytest.importorskip("matplotlib")
    panels = answer.shown([run(seed) for seed in range(2)])
    assert len(panels) == len(answer.ACTIONS) * len(answer.PICTURED)
    assert {len(lines) for lines in panels.values()} == {2 * len(answer.PRICES)}
    picture.draw(panels, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
