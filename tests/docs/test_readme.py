"""The README's code runs, top to bottom, and says what is true."""

import inspect
import re
from pathlib import Path
from typing import Any

import pytest

from coopenv.agents import settings
from coopenv.agents.partners import PARTNERS
from coopenv.envs.registry import find_config
from tests.helpers import IDS

README = Path(__file__).parents[2] / "README.md"


def run(blocks: list[str]) -> dict[str, Any]:
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, str(README), "exec"), names)
    return names


def test_every_python_block_of_the_readme_runs():
    pytest.importorskip("stable_baselines3")
    text = README.read_text().replace("learn(200_000, progress_bar=True)", "learn(1)")
    text = text.replace(
        'PPO("MlpPolicy", venv)', 'PPO("MlpPolicy", venv, n_steps=8, batch_size=16)'
    )
    text = text.replace("num_worlds=64", "num_worlds=2")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(blocks) >= 6
    names = run(blocks)
    assert names["split"].internal[:, 0] == pytest.approx([1.0, -1.0])
    assert names["split"].relative_cost == pytest.approx(0.5)
    assert names["wrench"].load_share(names["applied"], names["grips"]).force.tolist() == [1.0, 0.0]
    assert names["core"].num_worlds == 1024


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
    assert all(re.search(rf"\b{name}\b", inspect.getsource(settings)) for name in PARTNERS)


def test_the_keywords_and_blocks_of_the_table_are_the_ones_that_exist():
    from dataclasses import fields

    from coopenv import BLOCKS, TransportConfig

    table = README.read_text().split("| keyword | |")[1].split("\n\n")[0]
    rows = [line.split("|") for line in table.splitlines() if line.startswith("| `")]
    keywords = {name for row in rows for name in re.findall(r"`(\w+)`", row[1])}
    assert keywords == {field.name for field in fields(TransportConfig)}
    blocks = next(row[2] for row in rows if "observe" in row[1])
    assert set(re.findall(r"`(\w+)`", blocks)) == set(BLOCKS)
