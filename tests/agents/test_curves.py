"""Learning curves: what the picture shows of the rows, and where."""

import csv

import pytest

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure

from coopenv.agents import curves

RUN = [
    {"steps": 1000.0, "reward": -3.0, "success": 0.0, "relative_cost": 0.5, "reward/wait": -2.0,
     "internal_force_level": 2.0, "internal_torque_level": 0.4, "wasted_cost": 1.5},
    {"steps": 2000.0},
    {"steps": 4000.0, "reward": 5.0, "success": 0.75, "relative_cost": 0.1, "reward/wait": -1.0,
     "reward/goal": 6.0, "internal_force_level": 1.0, "internal_torque_level": 0.2},
]  # fmt: skip


@pytest.fixture
def drawn(tmp_path, monkeypatch, undrawn):
    """A picture of runs: its panels by title."""

    def draw(runs):
        seen, save = [], Figure.savefig

        def watched(figure, *given, **said):
            seen.append(figure)
            return save(figure, *given, **said)

        monkeypatch.setattr(Figure, "savefig", watched)
        undrawn(runs, tmp_path / "curves.png")
        assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")
        return {axes.get_title(): axes for axes in seen[0].axes}

    return draw


def points(axes):
    """Every line by its label."""
    return {line.get_label(): line.get_xydata().tolist() for line in axes.lines}


def test_one_run_is_drawn_where_it_has_numbers_with_its_reward_terms(drawn):
    panels = drawn({"ppo": [RUN]})
    assert [*panels] == [*curves.PANELS, "reward terms, sums over an episode"]
    (line,) = panels["return"].lines
    assert line.get_xydata().tolist() == [[1000.0, -3.0], [4000.0, 5.0]]
    assert panels["return"].get_ylabel() == "return of an episode"
    assert points(panels["disagreement"]) == {
        "F_I [N]": [[1000.0, 2.0], [4000.0, 1.0]],
        "T_I [N·m]": [[1000.0, 0.4], [4000.0, 0.2]],
        "wasted cost [N]": [[1000.0, 1.5]],
    }
    assert not panels["unevenness of the load"].lines
    terms = panels["reward terms, sums over an episode"]
    assert points(terms) == {"goal": [[4000.0, 6.0]], "wait": [[1000.0, -2.0], [4000.0, -1.0]]}
    assert len({line.get_color() for line in terms.lines}) == 2


def test_every_panel_begins_and_ends_with_its_curves_and_has_its_scale(drawn):
    panels = drawn({"ppo": [RUN]})
    for title, axes in panels.items():
        assert axes.get_xlabel() == "control steps"
        if axes.lines:
            assert axes.get_xlim() == (1000.0, 4000.0), title
        assert (axes.get_legend() is not None) == (title in ("disagreement", [*panels][-1]))
    assert panels["success"].get_ylim() == (-0.02, 1.02)
    for title in ("relative cost", "disagreement", "unevenness of the load"):
        assert panels[title].get_ylim()[0] == 0
    axis = panels["return"].xaxis
    assert axis.get_major_formatter()(2000.0) == "2k"


def test_runs_of_one_label_share_its_colour_and_are_explained_once(drawn):
    panels = drawn({"ppo": [RUN, RUN[2:]], "sac": [RUN[::-1]]})
    lines = panels["return"].lines
    colours = [line.get_color() for line in lines]
    assert colours[0] == colours[1] != colours[2]
    legend = panels["return"].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["ppo", "sac"]
    named = [text.get_text() for text in panels["disagreement"].get_legend().get_texts()]
    assert sorted(named) == sorted(
        f"{label}, {name}"
        for label in ("ppo", "sac")
        for name in ("F_I [N]", "T_I [N·m]", "wasted cost [N]")
    )
    styles = {line.get_linestyle() for line in panels["disagreement"].lines}
    assert styles == {*curves.STYLES}
    assert not panels[""].axison  # no reward terms


def test_rows_are_saved_with_all_columns_and_gaps_where_there_is_nothing(tmp_path):
    curves.save_rows(RUN, tmp_path / "curves.csv")
    with (tmp_path / "curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row, wanted in zip(rows, RUN, strict=True):
        assert {name: float(cell) for name, cell in row.items() if cell} == wanted
    assert set(rows[0]) == set().union(*RUN)
