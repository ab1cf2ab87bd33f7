"""A claim's verdict follows from its number."""

import csv
from math import nan

import pytest

from coopenv.agents.studies.claims import Claim, claim_table, markdown, save_claims
from coopenv.errors import InvalidInput

HOLDS = Claim.zero("ours is zero", "Fig. 13", 3e-13, within=1e-9, unit="N")
FAILS = Claim(
    text="a | b differ", source="V-C", measured=0.02, relation="<", bound=0.01, why="too few"
)


@pytest.mark.parametrize(
    ("measured", "relation", "holds"),
    [
        (1.0, "≤", True),
        (1.0, "<", False),
        (1.0, "≥", True),
        (1.0, ">", False),
        (nan, "≤", False),
        (nan, ">", False),
    ],
)
def test_the_rule_decides(measured, relation, holds):
    claim = Claim(text="", source="", measured=measured, relation=relation, bound=1.0)
    assert claim.holds == holds
    assert claim.verdict == ("holds" if holds else "does not hold")


def test_a_rule_must_be_one():
    with pytest.raises(InvalidInput, match="relation"):
        Claim(text="", source="", measured=0.0, relation="=", bound=1.0)
    with pytest.raises(InvalidInput, match="bound"):
        Claim(text="", source="", measured=0.0, relation="<", bound=nan)


def test_tables_show_number_rule_and_verdict(tmp_path):
    rich = pytest.importorskip("rich.console")
    console = rich.Console(width=160, record=True, file=(tmp_path / "console").open("w"))
    console.print(claim_table([HOLDS, FAILS], "beam"))
    printed = console.export_text()
    for word in ("beam", "ours is zero", "3e-13 N", "≤ 1e-09 N", "does not hold", "too few"):
        assert word in printed
    assert save_claims([HOLDS, FAILS], tmp_path / "claims") == ["claims.md", "claims.csv"]
    lines = (tmp_path / "claims.md").read_text().splitlines()
    assert lines[0] == "| claim | source | measured | rule | verdict | why |"
    assert lines[3].startswith("| a \\| b differ | V-C | 0.02 | < 0.01 | does not hold |")
    with (tmp_path / "claims.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == ["holds", "does not hold"]


def test_a_column_without_content_is_left_out():
    assert "why" not in markdown([HOLDS.row()])
