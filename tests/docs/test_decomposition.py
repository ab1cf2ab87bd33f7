"""The page on methods says what the code does."""

import re

from benchmarks import methods
from coopenv import wrench


def test_the_table_is_what_the_code_prints():
    # else: python -m benchmarks.methods --write
    assert methods.PAGE.read_text(encoding="utf-8") == methods.page()


def test_every_method_is_explained():
    text = methods.PAGE.read_text(encoding="utf-8")
    explained = re.findall(
        r"^\| `(\w+)` \| \w", text.split("<!-- table -->")[0], flags=re.MULTILINE
    )
    assert explained == list(wrench.METHODS)


def test_every_solver_is_in_the_table_of_solvers():
    text = methods.PAGE.read_text(encoding="utf-8")
    table = text.split("| for | `solver=` |")[1].split("\n\n")[0]
    named = re.findall(r"^\|[^|]*\| `(\w+)` \|", table, flags=re.MULTILINE)
    assert set(named) == set(wrench.SOLVERS)


def test_the_literals_of_the_paper_are_in_the_table():
    table = {row[0].strip("`"): row[1:] for row in methods.rows()}
    assert table["optimal"][:6] == ["0", "0", "1", "0", "0", "4.472"]
    assert table["moore_penrose"][:5] == ["1", "0", "2", "0.35", "-0.35"]
    assert table["nonsqueezing"][:5] == ["1", "0", "2", "0.7", "-0.7"]
    assert table["virtual_linkage"][3:5] == ["0", "0"]
    assert table["one_dimensional"][:4] == ["0", "0", "1", "—"]
    assert table["point_mass"][5:7] == ["4.472", "7.948"]
    assert table["max_internal"][5:7] == ["5.584", "9.695"]
    assert table["constraint_violation"][0] == "0.667 (footnote 2)"
