"""The page of promises names a test for each, and every test that it names is collected."""

import re
from importlib import import_module

import pytest

from tests.docs.snippets import ROOT

TEXT = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
NAMED = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`( \(slow\))?", TEXT)
HEAD = "| promise | test |\n|---|---|\n"
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for table in TEXT.split(HEAD)[1:]
    for line in table.partition("\n\n")[0].splitlines()
]


def test_every_promise_has_its_test():
    assert len(ROWS) > 40
    for row in ROWS:
        assert len(row) == 2, row
        assert re.fullmatch(r"(`tests/[\w/]+\.py::test_\w+`( \(slow\))? ?)+", row[1]), row[0]


@pytest.mark.parametrize("file", sorted({file for file, *_ in NAMED}))
def test_every_test_that_is_named_is_collected(file: str):
    try:
        module = import_module(file.removesuffix(".py").replace("/", "."))
    except pytest.skip.Exception:
        pytest.skip(f"{file} needs an extra")
    for named, name, slow in NAMED:
        if named == file:
            assert name.startswith("test_")
            test = getattr(module, name, None)
            assert callable(test), f"{file}::{name}"
            marks = {mark.name for mark in getattr(test, "pytestmark", [])}
            assert ("slow" in marks) == bool(slow), f"{file}::{name}"


def test_every_part_says_what_is_not_guaranteed():
    for part in TEXT.split("\n## ")[1:]:
        title = part.partition("\n")[0]
        if title not in ("The command line", "Known gaps"):
            assert "Not guaranteed" in part, title
