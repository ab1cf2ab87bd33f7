"""Cross-play: what the page shows, whose files a pair is of, and who sits where."""

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning import cross_play
from benchmarks.learning.cross_play import CrossPlay, Pair
from benchmarks.pages import filled
from coopenv.errors import InvalidInput
from tests.agents.training.cases import tiny


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A folder of its own for the pairs, and for runs two policies that learned next to nothing."""
    monkeypatch.setattr(cross_play, "FILE", tmp_path / "pairs.json")
    monkeypatch.setattr(cross_play, "EPISODES", 4)
    monkeypatch.setattr(cross_play, "configured", lambda *given, **_: _config(tmp_path, given[2]))
    return tmp_path


def _config(folder, seed):
    return tiny(folder / f"run_{seed}", seed=seed)


def test_the_page_shows_the_pairs_that_were_measured():
    page, made = cross_play.PAGE, cross_play.table(cross_play.saved())
    assert filled(page, {"cross-play": made}) == page.read_text(encoding="utf-8")


def test_every_policy_of_the_page_was_beside_every_other():
    names = {entered for entered, _ in cross_play.saved()}
    assert set(cross_play.saved()) == {(one, other) for one in names for other in names}


def test_pairs_are_measured_once_and_again_when_a_file_is_another(kept):
    told = []
    asked = CrossPlay(policies=("joint_0", "joint_1"), runs=kept)
    cross_play.measure_all(asked, told.append)
    assert len(told) == 4
    cross_play.measure_all(asked, told.append)
    assert len(told) == 4
    before = cross_play.saved()[("joint_0", "joint_1")].files
    path = cross_play.policy_file("joint_0", kept)
    path.write_bytes(cross_play.policy_file("joint_1", kept).read_bytes())
    cross_play.measure_all(asked, told.append)
    assert len(told) == 7  # all but joint_1 with itself
    after = cross_play.saved()[("joint_0", "joint_1")].files
    assert before != after
    assert after[0] == after[1]


def test_a_table_has_a_row_a_policy_that_is_entered():
    pair = Pair(entered="a_0", beside="b_1", files=("", ""), success=0.5, relative_cost=0.25)
    made = cross_play.table({("a_0", "b_1"): pair})
    assert made.splitlines()[-1] == "| `a_0` | 50.0, 0.250 |"
    assert cross_play.table({}) == cross_play.NONE


@pytest.mark.parametrize("name", ["population", "_0", "population_x"])
def test_a_name_without_partner_or_seed_is_refused(name, tmp_path):
    with pytest.raises(InvalidInput, match="write population_0"):
        cross_play.policy_file(name, tmp_path)
