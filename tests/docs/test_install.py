"""The page on installation asks for what the project asks for."""

import re
from pathlib import Path

from coopenv.files import toml

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")


def test_decomposition_alone_takes_the_versions_that_the_project_takes():
    project = toml.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = {line.partition(";")[0].strip() for line in project["dependencies"]}
    (line,) = (line for line in PAGE.splitlines() if line.startswith('pip install "numpy'))
    asked = re.findall(r'"([^"]+)"', line)
    assert set(asked) <= wanted
    names = [re.split(r"[<>=]", one)[0] for one in asked]
    assert names == ["numpy", "scipy", "numba", "clarabel", "tomli"]


def test_every_extra_of_the_page_exists():
    project = toml.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    rows = re.findall(r"\| `(\w+)`[^|]*\|$", PAGE, re.MULTILINE)
    asked = {*rows, *re.search(r'pip install "\.\[(.*)\]"', PAGE)[1].split(",")}  # pyright: ignore
    assert asked >= {"analysis", "render", "train"}
    assert asked <= set(project["optional-dependencies"])
