"""The page on experiments: its file is accepted, and its table of axes is complete."""

import json
import re

from coopenv.agents.algorithms import RECIPES, SACConfig
from coopenv.agents.algorithms.recipes import plain
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


def test_the_table_of_sacs_settings_says_their_defaults():
    rows = re.findall(r"^\| `(\w+)` \| (.*) \| .* \|$", PAGE.read_text(), flags=re.MULTILINE)
    shown = {
        name: json.loads(value.replace(",0", "0"))
        for name, value in rows
        if name in plain(SACConfig())
    }
    assert shown == plain(SACConfig())


def test_the_example_of_algorithms_is_an_experiment_of_them():
    experiment, search = load(ROOT / "examples" / "algorithms.toml")
    assert search is not None
    assert [cell.algorithm for cell in experiment.cells()][::5] == ["ppo", *RECIPES]
    assert [*search.algorithms(experiment).values()] == ["ppo", *RECIPES]


def test_the_table_of_axes_says_what_their_levels_may_say():
    text = PAGE.read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", text, flags=re.MULTILINE))
    for axis, names in AXES.items():
        if axis not in ("body", "algorithm"):
            assert re.findall(r"`(\w+)`", rows[axis]) == list(names)
    assert f"`{PROBLEMS[0]}` and `{PROBLEMS[1]}`" in text
