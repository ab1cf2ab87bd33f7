"""The walker studies: their claims hold, and break where they should."""

import csv
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.agents.studies.walker import avoid, turn
from coopenv.agents.studies.walker.report import Walk
from coopenv.agents.studies.walker.simulations import RollingPlan, WalkerAvoid, WalkerTurn
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


def test_a_drive_that_lets_go_breaks_them(avoided):
    applied = avoided.applied.copy()
    applied[:, 1] = 0.0
    found = avoid.claims(Walk(replace(avoided, applied=applied)), AVOID)
    assert len([claim for claim in found if not claim.holds]) >= 4  # nothing peaks, nothing jumps


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
