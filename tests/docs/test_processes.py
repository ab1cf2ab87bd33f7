"""The page on processes names a test for each of its rows, and every test that it names exists."""

import re
from importlib import import_module

import pytest

from tests.docs.snippets import ROOT

TEXT = (ROOT / "docs" / "processes.md").read_text(encoding="utf-8")
NAMED = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", TEXT)
ROWS = [line for line in TEXT.splitlines() if line.startswith("| ") and line.count("|") > 2]


def test_every_row_has_its_test():
    rows = [row for row in ROWS if not row.startswith("| |")]
    assert len(rows) > 12
    for row in rows:
        assert re.search(r"::test_\w+` \|$", row), row


@pytest.mark.parametrize(("file", "name"), sorted(set(NAMED)))
def test_every_test_that_is_named_exists(file: str, name: str):
    module = import_module(file.removesuffix(".py").replace("/", "."))
    assert callable(getattr(module, name, None)), f"{file}::{name}"
