"""The page on experiments: its file is accepted, and its table of axes is complete."""

import re

from coopenv.agents.experiments import load
from coopenv.agents.experiments.grid import PROBLEMS
from coopenv.agents.experiments.levels import AXES
from tests.docs.snippets import ROOT, snippets

PAGE = ROOT / "docs" / "experiments.md"


def test_the_file_on_the_page_is_an_experiment(tmp_path):
    (file,) = (each for each in snippets(PAGE) if each.language == "toml")
    path = tmp_path / "page.toml"
    path.write_text(file.code, encoding="utf-8")
    experiment, search = load(path)
    assert len(experiment.cells()) == 2 * 2 * (3 + 1) * 5
    assert search is not None


def test_the_table_of_axes_says_what_their_levels_may_say():
    text = PAGE.read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", text, flags=re.MULTILINE))
    for axis, names in AXES.items():
        if axis not in ("body", "algorithm"):
            assert re.findall(r"`(\w+)`", rows[axis]) == list(names)
    assert f"`{PROBLEMS[0]}` and `{PROBLEMS[1]}`" in text
