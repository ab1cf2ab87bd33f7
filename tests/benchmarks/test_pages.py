"""Tables on pages: read back as they were written, and kept where nothing was measured anew."""

import pytest

pytest.importorskip("rich")
pytest.importorskip("tyro")

from benchmarks import pages, partners
from benchmarks.learning import tasks


def test_a_table_is_read_back_as_it_was_written(tmp_path):
    rows = [["one", "1.0 %", ""], ["two", "–", "(a) because"]]
    page = tmp_path / "page.md"
    mark = "<!-- it -->\n"
    page.write_text(f"before\n{mark}{mark}after\n", encoding="utf-8")
    pages.fill(page, {"it": pages.markdown(("who", "how much", "why"), rows)})
    assert pages.cells(page, "it") == [["who", "how much", "why"], *rows]
    assert page.read_text(encoding="utf-8").startswith(f"before\n{mark}| who |")


def test_rows_of_environments_that_were_not_trained_stay():
    header, *before = pages.cells(tasks.PAGE, "learning")
    anew = [("WalkerTurn", "scripted", *["x"] * (len(header) - 2))]
    after = tasks.with_others(anew)
    assert [row for row in after if row[0] != "WalkerTurn"] == [
        row for row in before if row[0] != "WalkerTurn"
    ]
    assert [row for row in after if row[0] == "WalkerTurn"] == anew
    assert list(dict.fromkeys(row[0] for row in after)) == list(
        dict.fromkeys(row[0] for row in before)
    )
    assert tasks.with_others([("New", "scripted")])[-1] == ("New", "scripted")


def test_columns_of_environments_that_were_not_measured_stay():
    cell = partners.Cell(success=12.5, relative_cost=0.5, disagreement=0.25)
    made = partners.tables({("robot", "WalkerTurn"): cell})
    for name, shown in (("success", "12.5"), ("relative cost", "0.500"), ("disagreement", "0.25")):
        page = {**partners.on_page(name), ("robot", "WalkerTurn"): shown}
        rows = [
            [kind, *(page[kind, place] for place in partners.PLACES)] for kind in partners.KINDS
        ]
        assert made[name] == pages.markdown(("partner", *partners.PLACES), rows)
