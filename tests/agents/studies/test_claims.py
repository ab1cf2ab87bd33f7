"""A claim's verdict follows from its number."""

import csv
import io
from math import nan

import pytest

from coopenv.agents.studies.claims import Claim, claim_table, markdown, plain_table, save_claims
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


def printed(table, width: int = 80) -> str:
    rich = pytest.importorskip("rich.console")
    console = rich.Console(width=width, file=io.StringIO())
    console.print(table)
    return console.file.getvalue()


def test_a_claim_is_read_at_80_columns_without_a_parted_number():
    claims = [
        Claim(text=17 * "a long claim ", source="beyond the paper", measured=5.551e-17,
              relation="≤", bound=1e-9, unit="N, N·m", why=12 * "because it is so "),
        Claim(text="short", source="Figs. 12-13", measured=-0.5912, relation=">", bound=0.0,
              unit="% of time"),
    ]  # fmt: skip
    seen = printed(claim_table(claims, "claims"))
    assert all(len(line) <= 80 for line in seen.splitlines())
    for whole in ("5.551e-17 N, N·m", "≤ 1e-09 N, N·m", "-0.5912 % of time", "> 0 % of time"):
        assert whole in seen
    assert "…" not in seen
    assert len(seen.splitlines()) < 25


def test_other_rows_are_read_at_80_columns_without_a_parted_number():
    rows = [
        {"on": "dominance", "effect": "method × guide", "F": "F(4, 44) = 128.39",
         "p": "1.07e-19", "ε (Greenhouse-Geisser)": "0.488", "p corrected": "1.19e-10",
         "partial η²": "0.880"}
    ]  # fmt: skip
    seen = printed(plain_table(rows, "effects"))
    for whole in ("F(4, 44) = 128.39", "1.07e-19", "0.488", "1.19e-10", "0.880", "dominance", "η²"):
        assert whole in seen
    assert all(len(line) <= 80 for line in seen.splitlines())
    assert "…" not in seen
