"""The page on architecture shows the folders there are, and the rule that is checked."""

import re
from pathlib import Path

from coopenv.files import toml

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PROJECT = toml.loads((ROOT / "pyproject.toml").read_text())["tool"]


def section(title: str) -> str:
    return TEXT.split(f"## {title}\n")[1].split("\n## ")[0]


def test_every_folder_and_every_module_on_top_is_in_the_tree():
    tree = section("The house")
    folders = {name.rpartition(".")[2] for name in PROJECT["setuptools"]["packages"]}
    named = set(re.findall(r"\b(\w+)/", tree))
    assert folders <= named
    top = {path.stem for path in (ROOT / "coopenv").glob("*.py") if path.stem[-3:] != "_v0"}
    assert top <= set(re.findall(r"\w+", tree))


def test_the_order_of_imports_is_that_of_the_contract():
    shown = re.findall(r"^ {4}(\S.*)$", section("What may import what"), flags=re.MULTILINE)
    layers = PROJECT["importlinter"]["contracts"][0]["layers"]
    assert [set(line.split(", ")) for line in shown] == [
        {re.sub(r"_\w+_v0", "_*_v0", name) for name in layer.split(" | ")} for layer in layers
    ]
