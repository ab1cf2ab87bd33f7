"""The README says what is true. `test_snippets` runs its code."""

import inspect
import re
from pathlib import Path

import pytest

from coopenv.agents.environment import choice
from coopenv.agents.partners import PARTNERS
from coopenv.envs.registry import find_config
from tests.docs.snippets import chains, running
from tests.helpers import IDS

README = Path(__file__).parents[2] / "README.md"


def test_the_first_block_says_what_is_true(tmp_path):
    with running(chains(README)[0], tmp_path) as names:
        pass
    assert names["split"].internal[:, 0] == pytest.approx([1.0, -1.0])
    assert names["split"].relative_cost == pytest.approx(0.5)
    assert max(part.max() for part in names["split"].residuals()) == pytest.approx(0, abs=1e-12)
    load_share = names["wrench"].load_share(names["applied"], names["grips"])
    assert load_share.force.tolist() == [1.0, 0.0]


def test_every_environment_is_in_the_table_and_on_the_page_of_tasks():
    text = README.read_text()
    listed = re.findall(r"^\| `(\w+)` \|.*\| `coopenv\.(\w+)` \|$", text, flags=re.MULTILINE)
    tasks = {
        name.split("/")[1].removesuffix("-v0"): type(find_config(name, {}).task).__name__
        for name in IDS
    }
    assert dict(listed) == tasks
    page = (README.parent / "docs" / "tasks.md").read_text()
    assert set(re.findall(r"^\*\*(\w+)\.\*\*", page, flags=re.MULTILINE)) == set(tasks)


def test_every_partner_is_named():
    (kinds,) = re.findall(r"^Kinds: (.*)\.$", README.read_text(), flags=re.MULTILINE)
    assert set(kinds.split(", ")) == set(PARTNERS)
    assert all(re.search(rf"\b{name}\b", inspect.getsource(choice)) for name in PARTNERS)


def test_the_keywords_and_blocks_of_the_table_are_the_ones_that_exist():
    from dataclasses import fields

    from coopenv import BLOCKS, TransportConfig

    table = README.read_text().split("| keyword | |")[1].split("\n\n")[0]
    rows = [line.split("|") for line in table.splitlines() if line.startswith("| `")]
    keywords = {name for row in rows for name in re.findall(r"`(\w+)`", row[1])}
    assert keywords == {field.name for field in fields(TransportConfig)}
    blocks = next(row[2] for row in rows if "observe" in row[1])
    assert set(re.findall(r"`(\w+)`", blocks)) == set(BLOCKS)
