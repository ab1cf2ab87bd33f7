"""The page on learned policies runs, top to bottom, and says what is true."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "policies.md"


def test_its_code_runs_and_both_files_hold_the_same_policy(tmp_path, monkeypatch):
    pytest.importorskip("sb3_contrib")
    monkeypatch.chdir(tmp_path)
    text = PAGE.read_text().replace("num_worlds=64", "num_worlds=2").replace("4_096", "1")
    text = text.replace("batch_size=512", "batch_size=16").replace("episodes=50", "episodes=2")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        exec(compile(block, str(PAGE), "exec"), names)
    again = names["SB3Policy"].load(tmp_path / "runs" / "recurrent" / "policy.zip")
    assert names["evaluate"](again, episodes=2) == names["seen"]


def test_the_algorithms_it_names_are_those_that_act_in_a_box():
    pytest.importorskip("sb3_contrib")
    from tests.agents.learned.cases import ALGORITHMS

    text = re.sub(r"\s+", " ", PAGE.read_text())
    (named,) = re.findall(r"acts in a box \((.*?)\)", text)
    assert set(re.split(r"[,;] ", named)) == set(ALGORITHMS)
    rows = re.findall(r"^\| ((?:\w+, )+\w+) \|", PAGE.read_text(), flags=re.MULTILINE)
    assert {name for row in rows for name in row.split(", ")} == set(ALGORITHMS)
