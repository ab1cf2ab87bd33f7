"""The page on partners shows every kind in every environment, and what is meant to succeed."""

import re

import pytest

pytest.importorskip("rich")

from benchmarks import partners
from benchmarks.partners import KINDS, NOT_MEANT, PLACES, REASONS, Cell, measure, on_page, tables
from coopenv.agents.partners import PARTNERS, default_partner
from tests.helpers import IDS

TEXT = partners.PAGE.read_text(encoding="utf-8")
EVERY_CELL = [(kind, place) for kind in KINDS for place in PLACES]


def text_of(name: str) -> str:
    return TEXT.split(f"<!-- {name} -->\n")[1].rstrip("\n")


def number(cell: str) -> float:
    return float(re.findall(r"[\d.]+", cell)[0])


@pytest.mark.parametrize("name", ["success", "relative cost", "disagreement"])
def test_every_kind_is_in_every_environment(name):
    # else: python -m benchmarks.partners --write
    assert list(on_page(name)) == EVERY_CELL
    measured = {f"coopenv/{place.env}-v0" for place in PLACES.values()}
    assert measured == set(IDS)


def test_letters_reasons_and_defaults_are_those_of_the_code():
    shown = Cell(success=1.0, relative_cost=0.0, disagreement=0.0)
    wanted = tables(dict.fromkeys(EVERY_CELL, shown))
    mask = re.compile(r"\d+\.\d")
    assert mask.sub("#", text_of("success")) == mask.sub("#", wanted["success"])
    assert text_of("reasons") == wanted["reasons"]
    assert set(NOT_MEANT.values()) == set(REASONS)
    assert set(NOT_MEANT) <= set(EVERY_CELL)


def test_who_is_meant_to_succeed_does():
    success = on_page("success")
    for cell in EVERY_CELL:
        if cell not in NOT_MEANT:
            assert number(success[cell]) >= 95.0, cell
    for place in PLACES:  # somebody is meant to, everywhere
        assert ("robot", place) not in NOT_MEANT
        if not place.endswith("drive") and place != "BeamLift":
            assert ("walking", place) not in NOT_MEANT


@pytest.mark.parametrize(
    "cell",
    [
        ("impedance", "BeamDoorway"),
        ("walking", "WalkerTurn"),
        ("follower", "BeamTransport"),
        ("load_sharing", "BeamLift"),
    ],
)
def test_the_page_shows_what_is_measured(cell):
    """Forty episodes, so that it takes seconds: 27 points are more than three standard errors."""
    seen = measure(*cell, episodes=40)
    assert number(on_page("success")[cell]) == pytest.approx(seen.success, abs=27)
    assert number(on_page("relative cost")[cell]) == pytest.approx(seen.relative_cost, abs=0.08)
    assert number(on_page("disagreement")[cell]) == seen.disagreement == 0.0


def test_the_page_says_who_disagrees():
    shown = on_page("disagreement")
    differ = {kind for kind, _ in EVERY_CELL if number(shown[kind, "BeamTransport"]) > 0}
    assert differ == {"stubborn", "population"}


def test_every_partner_and_every_default_is_described():
    listed = re.findall(r"^\| (`\w+`(?:, `\w+`)*) \|", TEXT, flags=re.MULTILINE)
    assert {name for names in listed for name in re.findall(r"\w+", names)} == set(PARTNERS)
    for place in PLACES.values():
        assert f"`{default_partner(place.config(None))}`" in TEXT


def test_every_python_block_of_the_page_runs():
    blocks = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    assert len(blocks) == 1
    for block in blocks:
        names = {}
        exec(compile(block, str(partners.PAGE), "exec"), names)
        assert {"partner_plan", "partner_has_plan", "disagreement", "partner_kind"} <= set(
            names["info"]
        )
