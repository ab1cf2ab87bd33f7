"""The page on the studies shows what the commands find."""

import re

import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("statsmodels")

from benchmarks import studies
from coopenv.agents.studies.snapshots import report as snapshots
from coopenv.agents.studies.walker import avoid, turn
from coopenv.agents.studies.walker.report import Walk
from coopenv.agents.studies.walker.simulations import WalkerAvoid, WalkerTurn

TEXT = studies.PAGE.read_text(encoding="utf-8")


def on_page(name: str) -> str:
    return TEXT.split(f"<!-- {name} -->\n")[1]


def verdicts(name: str) -> list[tuple[str, str]]:
    """Claim and verdict of each row, which another machine's rounding does not change."""
    rows = [line.strip("| ").split(" | ") for line in on_page(name).splitlines()[2:]]
    return [(row[0], row[4]) for row in rows]


def test_every_table_and_picture_is_there():
    for study, names in studies.TABLES.items():
        for name in names:
            assert len(on_page(f"{study} {name}").splitlines()) > 3, (study, name)
    shown = set(re.findall(r"\]\((studies/.*?\.png)\)", TEXT))
    paths = [path for path in studies.pictures(studies.OUT)]
    assert shown == {f"studies/{path.name}" for path in paths}
    assert all(5_000 < path.stat().st_size < 250_000 for path in paths)


def test_the_traits_are_those_of_the_code():
    assert on_page("people") == studies.people()  # else: python -m benchmarks.studies --write
    assert studies.people().count("\n") == 2 + 12


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("walker-turn claims", lambda: turn.claims(Walk(WalkerTurn().run()))),
        (
            "walker-avoid claims",
            lambda: avoid.claims(Walk(WalkerAvoid().run()), WalkerAvoid()),
        ),
        ("snapshots claims", snapshots.claims),
    ],
)
def test_the_quick_studies_claims_are_what_the_code_finds(name, found):
    assert verdicts(name) == [(claim.text, claim.verdict) for claim in found()]


def test_what_does_not_hold_is_what_the_text_explains():
    failed = [row for name in studies.STUDIES for row in verdicts(f"{name} claims")
              if row[1] != "holds"]  # fmt: skip
    assert [text.split(":")[0] for text, _ in failed] == [
        "point mass",
        "nonsqueezing",
        "eq. 24 as printed names no wrench at which w does not matter (of 878)",
        "agent 1 dominates longer",
    ]
