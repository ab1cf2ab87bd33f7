"""The walker studies: their claims hold, and break where they should."""

import csv
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.agents.studies.walker import avoid, report, turn
from coopenv.agents.studies.walker.report import Walk
from coopenv.agents.studies.walker.simulations import RollingPlan, WalkerAvoid, WalkerTurn
from coopenv.physics.scene import Box
from tests.agents.studies.printed import files_named

TURN = WalkerTurn(dt=0.02)
AVOID = WalkerAvoid(dt=0.02)


@pytest.fixture(scope="module")
def turned():
    return TURN.run()


@pytest.fixture(scope="module")
def avoided():
    return AVOID.run()


def broken(found) -> set[str]:
    return {claim.text.split(":")[0] for claim in found if not claim.holds}


def test_every_claim_about_the_turn_holds(turned):
    found = turn.claims(Walk(turned))
    assert len(found) == 20
    assert not broken(found)


def test_a_turn_to_the_right_keeps_them_too():
    recording = WalkerTurn(dt=0.02, plan=RollingPlan(turn=-2.0)).run()
    assert not broken(turn.claims(Walk(recording)))


def test_a_drive_that_works_against_the_human_breaks_them(turned):
    applied = turned.applied.copy()
    applied[200, 0, 2] = -3.0  # [N·m] in the middle of the turn
    found = broken(turn.claims(Walk(replace(turned, applied=applied))))
    assert {"ours (optimal)", "ours (pTtTC)", "point mass"} <= found
    assert "the human gives no torque and no force across" in found


def test_every_claim_about_the_obstacle_holds(avoided):
    found = avoid.claims(Walk(avoided), AVOID)
    assert len(found) == 17
    assert not broken(found)


def test_the_forces_are_equal_where_the_resultant_turns_round(avoided):
    at = avoid.equalities(avoided)
    resultant = avoided.applied[..., 0].sum(axis=1)
    assert len(at) >= 1
    assert (resultant[at] * resultant[at - 1] < 0).all()


@pytest.mark.parametrize(
    ("resultant", "turned"),
    [
        ((2, -1, -1, 3), [1, 3]),
        ((2, 0, 1, 2), []),
        ((2, 1, 3, 2), []),
        ((-1, 0, -1, 2), [3]),
        ((2, 0, -1, -1), [2]),  # equal to the last bit in a sample
        ((0, 0, -1, 2), [3]),
    ],
)
def test_forces_are_equal_where_the_resultant_passes_zero_and_not_where_it_touches_it(
    resultant, turned, avoided
):
    applied = np.zeros((4, 2, 3))
    applied[:, 1, 0] = -4.0  # [N] of the drive
    applied[:, 0, 0] = np.add(resultant, 4.0)
    assert avoid.equalities(replace(avoided, applied=applied)).tolist() == turned
    applied[:, 1, 0] *= -1  # which goes along with the human
    applied[:, 0, 0] = np.add(resultant, 4.0)
    assert avoid.equalities(replace(avoided, applied=applied)).tolist() == []


def test_where_forces_are_never_equal_nothing_is_said_of_what_is_before_or_after(avoided):
    applied = avoided.applied.copy()
    applied[:, :, 0] = 5.0, 2.5  # [N]
    found = avoid.claims(Walk(replace(avoided, applied=applied)), AVOID)
    unknown = [claim for claim in found if np.isnan(claim.measured)]
    assert [claim.text.split(" (")[0] for claim in unknown] == [
        "γ is largest where the two forces are equal: apart by",
        "γ peaks each time the two forces are equal",
        "α_f,1 = 1 in the 0.5 s before the forces are first equal",
        "α_f,1 = 0 in the 0.2 s after",
    ]
    assert not any(claim.holds for claim in unknown)


def test_a_drive_that_lets_go_breaks_them(avoided):
    applied = avoided.applied.copy()
    applied[:, 1] = 0.0
    found = avoid.claims(Walk(replace(avoided, applied=applied)), AVOID)
    assert len([claim for claim in found if not claim.holds]) >= 4  # nothing peaks, nothing jumps


def test_the_way_shows_plan_walker_grips_and_obstacles(avoided, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(report, "save_figure", lambda figure, path: seen.append(figure))
    outline = ((-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2))
    post = Box(center=(1.0, 2.0), size=(0.4, 0.6), angle=0.3)
    report.draw_way(
        avoided, tmp_path / "x.png", title="way", outline=outline, obstacles=[post, post], every=2.0
    )
    (axes,) = seen[0].axes
    assert seen[0].get_suptitle() == "way"
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_aspect()) == ("x [m]", "y [m]", 1.0)
    for patch in axes.patches:
        np.testing.assert_allclose(patch.get_xy()[:4], post.vertices)
    assert len(axes.patches) == 2
    plan, way, *walkers = axes.lines
    np.testing.assert_array_equal(plan.get_xydata(), avoided.planned[:, :2])
    np.testing.assert_array_equal(way.get_xydata(), avoided.pose[:, :2])
    shown = [*range(0, len(avoided.time), 100), len(avoided.time) - 1]  # in steps of 0.02 s
    assert len(walkers) == 2 * len(shown)
    for k, shape, hand in zip(shown, walkers[::2], walkers[1::2], strict=True):
        c, s = np.cos(avoided.pose[k, 2]), np.sin(avoided.pose[k, 2])
        turn = np.array([(c, s), (-s, c)])
        corners = np.array([*outline, outline[0]]) @ turn + avoided.pose[k, :2]
        np.testing.assert_allclose(shape.get_xydata(), corners, atol=1e-12)
        place = avoided.grips[:1] @ turn + avoided.pose[k, :2]
        np.testing.assert_allclose(hand.get_xydata(), place, atol=1e-12)
    named = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [name for name in named if name != "obstacle"] == [
        "plan", "centre of mass", "walker, every 2 s", "human's grip",
    ]  # fmt: skip
    assert "obstacle" in named


@pytest.mark.parametrize("name", ["turn", "avoid"])
def test_the_command_prints_its_claims_and_leaves_its_files(name, tmp_path, capsys, monkeypatch):
    pytest.importorskip("tyro")
    monkeypatch.setenv("COLUMNS", "160")
    assert cli.main(["study", f"walker-{name}", "--dt", "0.02", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert ("20 of 20 hold" if name == "turn" else "17 of 17 hold") in printed
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "claims.md", "claims.csv", "time.png", "way.png", "series.csv", "series.npz",
    }  # fmt: skip
    assert files_named(printed, tmp_path) == names
    with (tmp_path / "series.csv").open() as file:
        rows = list(csv.DictReader(file))
    arrays = np.load(tmp_path / "series.npz")
    assert len(rows) == len(arrays["time"]) == 400
    assert float(rows[100]["f1x"]) == pytest.approx(arrays["applied"][100, 0, 0])
    assert np.isfinite([float(row["moore_penrose_F_I"]) for row in rows]).all()
