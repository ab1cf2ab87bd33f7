"""Cells of other algorithms than PPO: beside it in a grid, killed, searched, and refused."""

import re
import sys
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")
pytest.importorskip("matplotlib")

from coopenv.agents import curves
from coopenv.agents.algorithms import RecurrentConfig, SACConfig
from coopenv.agents.experiments import Search, check, conduct, load
from coopenv.agents.experiments.cell import Cell
from coopenv.agents.experiments.run import run_cells
from coopenv.agents.experiments.space import distributions_of, space_of
from coopenv.agents.sb3 import SB3Policy
from coopenv.errors import CoopenvError, InvalidInput, MissingExtra
from tests.agents.experiments.cases import TRAINING, files, here, no_pictures, small

SAC: dict[str, Any] = {
    "name": "sac",
    "steps": 256,
    "num_worlds": 4,
    "random_steps": 64,
    "batch_size": 16,
}
GRID = {
    "algorithm": {
        "ppo": {"hidden": [8]},
        "sac": {**SAC, "hidden": [8]},
        "recurrent": {"name": "recurrent", "units": 8},
    }
}


@pytest.fixture(scope="module", autouse=True)
def _undrawn():
    with no_pictures(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(curves, "draw", lambda *given: None)
        yield


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("finished")
    outcome = conduct(small(out, grid=GRID, seeds=1), launch=here, workers=1)
    assert outcome.failures == {}
    return out


def test_ppo_sac_and_recurrent_ppo_are_in_one_report(finished):
    page = (finished / "report" / "report.md").read_text(encoding="utf-8")
    for name in GRID["algorithm"]:
        assert f"| {name} | 1 |" in page
        (folder,) = finished.glob(f"cells/algorithm={name}/*")
        assert SB3Policy.load(folder / "policy.zip").notes["provenance"]
        assert (folder / "curves.csv").read_text().startswith("steps")


def test_a_cell_comes_back_from_its_folder_with_its_recipe(finished):
    for cell in small(finished, grid=GRID, seeds=1).cells():
        assert Cell.load(finished / cell.folder).digest() == cell.digest()
        assert cell.is_finished(finished / cell.folder)
        changed = small(finished, grid=GRID, seeds=1, training={**TRAINING, "epochs": 2}).cells()
        assert {each.digest() for each in changed} & {cell.digest()} == (
            {cell.digest()} if cell.algorithm == "sac" else set()
        )


def test_a_grid_that_is_killed_repeats_the_cell_under_way_alone_and_has_the_same_report(
    finished, tmp_path
):
    worked, told = [], []

    def killed(folder, report):
        if told:
            raise KeyboardInterrupt
        worked.append(folder.parent.name)
        return here(folder, stop if len(worked) == 2 else report)

    def stop(said):
        told.append(said)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        conduct(small(tmp_path, grid=GRID, seeds=1), launch=killed, workers=1)
    told.clear()
    conduct(small(tmp_path, grid=GRID, seeds=1), launch=killed, workers=1)
    assert worked == [f"algorithm={name}" for name in ("ppo", "sac", "sac", "recurrent")]
    assert files(tmp_path) == files(finished)


def idle(folder, report):
    """Do nothing, and call it done."""


def test_the_progress_of_a_grid_counts_the_steps_of_each_algorithm(tmp_path):
    cells = small(tmp_path, grid=GRID, seeds=1, episodes=1).cells()
    assert [cell.steps for cell in cells] == [128, 256, 128]
    told = []
    run_cells(cells, tmp_path, workers=1, launch=idle, show=lambda **n: told.append(n))
    assert told[-1]["done"] == told[-1]["total"] == 512 + 3 * 50


def test_steps_of_sac_know_no_rollout(tmp_path):
    (cell,) = small(tmp_path, grid={"algorithm": "sac"}, seeds=1, training={"steps": 6_000}).cells()
    assert cell.steps == 6_000


def test_an_algorithm_has_steps_of_the_training_and_recurrent_ppo_all_of_it(tmp_path):
    whole: Any = {"steps": 20_000, "num_worlds": 8, "learning_rate": 3e-4, "hidden": (4,)}
    training = {**whole, "hidden": [4]}
    grid = {"algorithm": ["sac", "recurrent"]}
    cells = small(tmp_path, grid=grid, seeds=1, training=training).cells()
    assert [cell.recipe for cell in cells] == [SACConfig(steps=20_000), RecurrentConfig(**whole)]


TEXT = """
[experiment]
seeds = 1

[training]
steps = 30_000

[grid]
action = ["wrench"]

[grid.algorithm.one]
name = "sac"
gradient_steps = 2

[search]
seeds = 1

[search.space.sac]
gradient_steps = { low = 1, high = 4 }
entropy = { choices = [0.02, "auto"] }
"""

MISTAKES = [  # what stands there -> what is written instead, and what is said
    ('name = "sac"', 'name = "sacc"', "did you mean 'sac'"),
    ("gradient_steps = 2", "gradient_step = 2", "did you mean 'gradient_steps'"),
    ("gradient_steps = 2", "epochs = 5", "setting of sac must be one of the known names"),
    ("gradient_steps = 2", "gradient_steps = 0", "gradient_steps must be a whole number"),
    ("gradient_steps = 2", "tau = 1.5", "tau must be at most 1"),
    ("gradient_steps = 2", 'entropy = "much"', "entropy must be a weight or auto"),
    ("gradient_steps = 2", "random_steps = 30_000", "random_steps must be fewer"),
    ('name = "sac"', 'name = "ppo"', "setting of ppo must be one of the known names"),
    ("gradient_steps = { low = 1", "gradient_stps = { low = 1", "did you mean 'gradient_steps'"),
    ("gradient_steps = { low = 1", "gradient_steps = { low = 0", "at least 1"),
    ('choices = [0.02, "auto"]', 'choices = ["much"]', "entropy must be a weight or auto"),
    ('entropy = { choices = [0.02, "auto"] }', "hidden = { low = 1, high = 2 }", "choices"),
    ("steps = 30_000", "learning_rate = 1e-5", "got learning_rate, which none of sac takes"),
    ("steps = 30_000", "steps = 4_000", "random_steps must be fewer"),
    ("[search.space.sac]", "[search.space.recurrent]", "must be of an algorithm of the grid"),
    ("[search.space.sac]", "[search.space.scripted]", "known"),
    (
        "seeds = 1\n\n[search.space",
        "space.epochs = { low = 1, high = 2 }\nseeds = 1\n\n[search.space",
        "epochs must be searched for ppo",
    ),
]


@pytest.mark.parametrize(("right", "wrong", "said"), MISTAKES)
def test_a_mistake_is_told_with_its_line(right, wrong, said, tmp_path):
    text = TEXT.replace(right, wrong, 1)
    line = text[: text.index(wrong)].count("\n") + 1
    if 'name = "ppo"' in wrong:
        line += 1  # that of the setting
        text = text[: text.index("[search]")]
    file = tmp_path / "grid.toml"
    file.write_text(text)
    with pytest.raises(CoopenvError, match=re.escape(said)) as caught:
        load(file)[0].cells()
    assert re.search(rf"line {line}\b", str(caught.value)), str(caught.value)


def test_sac_is_refused_where_actions_are_numbers_of_pushes(tmp_path):
    grid = {"algorithm": ["ppo", "sac"], "action": ["wrench", "discrete"]}
    with pytest.raises(InvalidInput, match=r"numbers for SAC.*action=discrete, algorithm=sac"):
        small(tmp_path, grid=grid, training={**TRAINING, "steps": 6_000}).cells()


def test_recurrent_ppo_without_its_package_is_told_before_the_first_cell(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[contrib\]"):
        conduct(small(tmp_path, grid=GRID), launch=here)
    assert not (tmp_path / "cells").exists()


def test_a_search_has_the_space_of_each_algorithm_and_leaves_the_others(tmp_path):
    pytest.importorskip("optuna")
    file = tmp_path / "grid.toml"
    file.write_text(TEXT)
    experiment, search = load(file)
    assert search is not None
    assert search.algorithms(experiment) == {"one": "sac"}
    found = distributions_of(space_of(search.space, "sac"), "sac")
    assert type(found["gradient_steps"]).__name__ == "IntDistribution"
    (cell,) = search.cells(experiment, "one", {"gradient_steps": 4, "entropy": "auto"})
    assert cell.recipe == SACConfig(steps=30_000, gradient_steps=4, entropy="auto")


def test_a_search_in_which_no_algorithm_of_the_grid_has_a_space_is_refused(tmp_path):
    search = Search(space={"epochs": {"low": 1, "high": 2}})
    experiment = small(tmp_path, grid={"algorithm": {"sac": SAC}}, training={})
    with pytest.raises(InvalidInput, match=r"\[search\.space\.sac\]"):
        check(experiment, search=search, tune=3)


def test_the_best_of_a_search_goes_over_the_level_of_its_algorithm(tmp_path):
    experiment = small(tmp_path, grid={"algorithm": {"one": SAC}}, training={})
    experiment = experiment.over("one", {"hidden": [4, 4]})
    settings = {name: value for name, value in SAC.items() if name != "name"}
    assert {cell.recipe for cell in experiment.cells()} == {SACConfig(**settings, hidden=(4, 4))}
