"""Searches over settings: their budget, seeds of their own, and going on after a kill."""

import json
import sys
from math import log10

import pytest

pytest.importorskip("optuna")
pytest.importorskip("matplotlib")

from coopenv.agents.experiments import Search
from coopenv.agents.experiments.cell import FORMAT, RESULT
from coopenv.agents.seeds import evaluation_seeds, training_seeds
from coopenv.errors import InvalidInput, MissingExtra
from tests.agents.experiments.cases import ENVIRONMENT, small

SPACE = {
    "learning_rate": {"low": 1e-4, "high": 1e-2, "log": True},
    "epochs": {"low": 1, "high": 4},
    "hidden": {"choices": [[8], [16, 16]]},
}
GRID = {"reward": ["task", "harmony"], "algorithm": ["ppo", "random"]}


class Runs:
    """Stands for runs: the best learning rate is 1e-3; interrupted after so many trials."""

    def __init__(self, until: int = 99, failing: bool = False):
        self.trials, self.until, self.failing = [], until, failing

    def __call__(self, cells, out):
        if len(self.trials) == self.until:
            raise KeyboardInterrupt
        self.trials.append(cells)
        if self.failing:
            return {cells[0].folder: "diverged"}
        for cell in cells:
            success = 1 - abs(log10(cell.training.learning_rate) + 3) / 2
            (out / cell.folder).mkdir(parents=True)
            content = {"format": FORMAT, "evaluation": {"success_rate": success}}
            (out / cell.folder / RESULT).write_text(json.dumps(content))
        return {}


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    experiment = small(tmp_path_factory.mktemp("searched"), grid=GRID)
    runs = Runs()
    return experiment, runs, Search(space=SPACE).run(experiment, 6, runs)


def test_a_search_has_as_many_trials_as_it_was_given(searched):
    experiment, runs, _ = searched
    assert len(runs.trials) == 6
    assert all(len(cells) == 2 * 2 for cells in runs.trials)  # rewards, seeds of the search
    assert {cell.algorithm for cells in runs.trials for cell in cells} == {"ppo"}
    assert len(list(experiment.out.glob("search/ppo/trial_*/trial.json"))) == 6


def test_the_best_trial_makes_the_settings_of_the_grid(searched):
    experiment, runs, (tuned, found) = searched
    rates = [cells[0].training.learning_rate for cells in runs.trials]
    best = min(rates, key=lambda rate: abs(log10(rate) + 3))
    assert found["ppo"]["learning_rate"] == best
    learners = [cell for cell in tuned.cells() if cell.learns]
    assert {cell.training.learning_rate for cell in learners} == {best}
    assert {cell.training.hidden for cell in learners} <= {(8,), (16, 16)}
    assert [cell.folder for cell in tuned.cells()] == [cell.folder for cell in experiment.cells()]


def test_a_search_shares_no_seed_with_the_grid(searched):
    experiment, runs, _ = searched

    def worlds(cells):
        training = [training_seeds(cell.training.seed, cell.training.num_worlds) for cell in cells]
        evaluation = [evaluation_seeds(cell.evaluation, cell.episodes) for cell in cells]
        return {seed for seeds in training + evaluation for seed in seeds}

    grid = worlds(experiment.cells())
    assert not grid & worlds([cell for cells in runs.trials for cell in cells])


def test_a_search_that_is_killed_comes_to_the_same_end(searched, tmp_path):
    experiment = small(tmp_path, grid=GRID)
    search = Search(space=SPACE)
    with pytest.raises(KeyboardInterrupt):
        search.run(experiment, 6, Runs(until=4))
    rest = Runs()
    tuned, found = search.run(experiment, 6, rest)
    assert len(rest.trials) == 2
    assert found == searched[2][1]
    assert [cell.digest() for cell in tuned.cells()] == [
        cell.digest() for cell in searched[2][0].cells()
    ]


@pytest.mark.parametrize(
    ("changes", "objective"),
    [({"environment": {**ENVIRONMENT, "horizon": 50}}, "success_rate"), ({}, "wasted_cost")],
)
def test_trials_of_another_experiment_or_objective_are_not_taken_for_its_own(
    changes, objective, tmp_path
):
    space = {"epochs": SPACE["epochs"]}
    Search(space=space).run(small(tmp_path, grid={}), 1, Runs())
    with pytest.raises(InvalidInput, match="no other search"):
        Search(space=space, objective=objective).run(small(tmp_path, grid={}, **changes), 1, Runs())


def test_a_search_may_be_made_in_some_settings_only(tmp_path):
    runs = Runs()
    search = Search(space={"epochs": SPACE["epochs"]}, seeds=1, only={"reward": ["harmony"]})
    search.run(small(tmp_path, grid=GRID), 1, runs)
    assert [cell.levels["reward"] for cell in runs.trials[0]] == ["harmony"]


def test_without_an_axis_of_algorithms_the_settings_are_those_of_all_cells(tmp_path):
    experiment = small(tmp_path, grid={"reward": ["task"]})
    tuned, found = Search(space={"epochs": SPACE["epochs"]}).run(experiment, 2, Runs())
    assert {cell.training.epochs for cell in tuned.cells()} == {found["ppo"]["epochs"]}


def test_a_search_of_which_nothing_comes_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="none of 2"):
        Search(space=SPACE).run(small(tmp_path, grid={}), 2, Runs(failing=True))


def test_a_search_without_optuna_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[search\]"):
        Search(space=SPACE).run(small(tmp_path), 1, Runs())
