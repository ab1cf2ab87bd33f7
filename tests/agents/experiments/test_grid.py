"""Grids: their cells, and mistakes in their files, told with the line before anything runs."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from coopenv import Transport
from coopenv.agents.experiments import load
from coopenv.agents.experiments.grid import Experiment
from coopenv.agents.settings import TrainConfig
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.rewards import InternalForce, LoadShare
from coopenv.wrench import Settings
from tests.agents.experiments.cases import TEXT, small

EXAMPLE = Path(__file__).parents[3] / "examples" / "reward_shaping.toml"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "grid.toml"
    path.write_text(TEXT)
    return path


def test_a_file_makes_every_level_with_every_other_for_every_seed(file):
    experiment, search = load(file)
    cells = experiment.cells()
    assert search is None
    assert len(cells) == (3 * 2 - 1) * 2
    assert len({cell.folder for cell in cells}) == len({cell.digest() for cell in cells}) == 10
    assert cells[0].folder == "cells/reward=none,algorithm=scripted/seed_0"
    assert experiment.out == Path("runs/grid")
    assert {cell.training.seed for cell in cells} == {0, 1}
    assert all(cell.environment.horizon == 60 for cell in cells)


def test_a_level_of_the_reward_has_its_preset_weights_and_terms(file):
    cells: dict[str, Any] = {cell.levels["reward"]: cell for cell in load(file)[0].cells()}
    squeeze, share = cells["squeeze"].environment.terms, cells["share"].environment.terms
    assert squeeze["squeeze"] == InternalForce(settings=Settings(method="moore_penrose"))
    assert share["share"] == LoadShare(wanted=(0.8, 0.2))
    assert share["relative_cost"].weight == 0.5
    assert set(cells["none"].environment.terms) == {"progress", "success", "time"}


def test_levels_go_over_what_all_cells_have(tmp_path):
    grid = {
        "task": {"easy": {"task": {"angle_tolerance": 0.5}, "horizon": 70}},
        "body": {"heavy": {"mass": 12.0}},
        "observation": {"own": "own", "two": ["goal", "twist"]},
        "action": {"soft": {"action": "motion", "hands": {"stiffness": 90.0}}, "push": "force"},
        "control": ["joint", "shared", "partner"],
        "algorithm": {"slow": {"learning_rate": 1e-4, "hidden": [4, 4]}},
    }
    cells = small(tmp_path, grid=grid, seeds=1).cells()
    assert len(cells) == 12
    for cell in cells:
        environment: Any = cell.environment
        assert (environment.task.position_tolerance, environment.task.angle_tolerance) == (0.3, 0.5)
        assert environment.horizon == 70
        assert environment.body.mass == 12.0
        assert environment.action == {"soft": "motion", "push": "force"}[cell.levels["action"]]
        assert (environment.hands is not None) == (cell.levels["action"] == "soft")
        assert (environment.partner is not None) == (cell.levels["control"] == "partner")
        assert cell.training.control == cell.levels["control"]
        assert (cell.training.learning_rate, cell.training.hidden) == (1e-4, (4, 4))
        assert (environment.observe == ("goal", "twist")) == (cell.levels["observation"] == "two")


def test_a_whole_number_may_be_written_as_a_float_and_is_the_same(tmp_path):
    written = {"steps": 3e5, "epochs": 3.0, "num_worlds": 64.0, "rollout": 32.0}
    (floats,) = small(tmp_path, grid={}, seeds=1, training={**written, "hidden": [8.0]}).cells()
    numbers = {name: int(value) for name, value in written.items()}
    (wholes,) = small(tmp_path, grid={}, seeds=1, training={**numbers, "hidden": [8]}).cells()
    assert floats.digest() == wholes.digest()
    assert repr(floats.training) == repr(wholes.training)


def test_what_a_result_depends_on_changes_the_mark_of_a_cell_and_nothing_else_does(tmp_path):
    (cell,) = small(tmp_path, grid={}, seeds=1).cells()
    for same in (cell.at(tmp_path / "b"), replace(cell, wandb="x")):
        assert same.digest() == cell.digest()
    other = replace(cell, training=replace(cell.training, epochs=3))
    for changed in (other, replace(cell, episodes=4), replace(cell, continues=True)):
        assert changed.digest() != cell.digest()


def test_a_level_may_need_one_of_another_axis(tmp_path):
    """The energy of hands cannot be priced where there are none."""
    grid = {"reward": {"stored": {"terms": {"e": {"kind": "StoredEnergy"}}}}, "action": ["motion"]}
    assert len(small(tmp_path, grid=grid).cells()) == 2
    both = {**grid, "action": ["motion", "wrench"]}
    with pytest.raises(InvalidInput, match="tells of hands"):
        small(tmp_path, grid=both).cells()
    excluded = small(tmp_path, grid=both, exclude=[{"reward": "stored", "action": "wrench"}])
    assert len(excluded.cells()) == 2


MISTAKES = [  # what stands there -> what is written instead, and what is said
    ('kind = "LoadShare"', 'kind = "LodShare"', "did you mean 'LoadShare'"),
    ('kind = "LoadShare"', 'kid = "LoadShare"', "did you mean 'kind'"),
    ("epochs = 1", "epochs = 1e30", "epochs must be at most"),
    ("batch_size = 16", "batch_size = 1e30", "batch_size must be at most"),
    ("hidden = [8]", "hidden = [1e30]", "hidden must be"),
    ('method = "moore_penrose"', 'method = "moore"', "did you mean 'moore_penrose'"),
    ("wanted = [0.8, 0.2]", "wanted = [0.8, 0.1, 0.1]", "2 agents"),
    ("wanted = [0.8, 0.2]", "wnted = [0.8, 0.2]", "did you mean 'wanted'"),
    ("wanted = [0.8, 0.2]", "weight = inf", "finite"),
    ("seeds = 2", "seed = 2", "did you mean 'seeds'"),
    ("seeds = 2", "seeds = [1, 1]", "once"),
    ("seeds = 2", "seeds = [1000]", "at most 999"),
    ("episodes = 3", "episodes = 0", "at least 1"),
    ('name = "tiny"', "name = 4", "a text"),
    ("horizon = 60", "horizn = 60", "did you mean 'horizon'"),
    ("horizon = 60", "horizon = -1", "at least 1"),
    ("horizon = 60", 'env = "coopenv/Beam-v0"', "did you mean"),
    ("horizon = 60", 'env = "os:coopenv/BeamLift-v0"', "without a module"),
    ("horizon = 60", "body = { mass = -4 }", "positive"),
    ("horizon = 60", 'observe = ["goal", "twst"]', "did you mean 'twist'"),
    ("epochs = 1", "epochs = 0", "at least 1"),
    ("epochs = 1", "n_epochs = 1", "did you mean 'epochs'"),
    ("epochs = 1", 'control = "jont"', "did you mean 'joint'"),
    ("steps = 128", "steps = 16", "one rollout"),
    ("hidden = [8]", "hidden = [0]", "at least 1"),
    ('algorithm = ["scripted",', 'algorithm = ["scriptd",', "did you mean 'scripted'"),
    ("[grid.reward.share]", "[grid.rewrd.share]", "did you mean 'reward'"),
    ('preset = "harmony"', 'preset = "harmonie"', "did you mean 'harmony'"),
    ("relative_cost = 0.5", "relativ_cost = 0.5", "did you mean 'relative_cost'"),
    ("relative_cost = 0.5", 'relative_cost = "much"', "must be a number"),
    ('none = "task"', '"no ne" = "task"', "names a folder"),
    ('none = "task"', "none = 3", "must be a table"),
    ('reward = "squeeze"', 'reward = "squeze"', "did you mean 'squeeze'"),
    ("[training]", "[trainig]", "did you mean 'training'"),
    ("seeds = 2", 'problems = [["task"]]', "known: action"),
    ('algorithm = ["scripted",', 'algorithm = [{ name = "ppo" },', "must have a name"),
    ("seeds = 2", "seeds = ", "TOMLDecodeError"),
]


@pytest.mark.parametrize(("right", "wrong", "said"), MISTAKES)
def test_a_mistake_is_told_with_its_line(right, wrong, said, file):
    text = TEXT.replace(right, wrong)
    assert text.count(wrong) == 1
    line = text[: text.index(wrong)].count("\n") + 1
    file.write_text(text)
    with pytest.raises(CoopenvError, match=re.escape(said)) as caught:
        load(file)[0].cells()
    assert re.search(rf"line {line}\b", str(caught.value)), str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_grid_without_a_cell_names_the_line_of_what_excludes_them(file):
    text = f"{TEXT}\n[[exclude]]\nalgorithm = 'scripted'\n\n[[exclude]]\nalgorithm = 'random'\n"
    file.write_text(text)
    line = text[: text.index("[[exclude]]")].count("\n") + 1
    with pytest.raises(InvalidInput, match=rf"all of them excluded.*\.toml, line {line}\)"):
        load(file)[0].cells()


SEARCHES = [  # under [search]; the line that is wrong comes last
    ("seeds = 0", "at least 1"),
    ('objective = "succes_rate"', "did you mean 'success_rate'"),
    ('objective = ["success_rate"]', "must be one of the known names"),
    ("only = { algorithm = ['random'] }", "known: reward"),
    ("only = { reward = ['nothing'] }", "known: none, share, squeeze"),
    ("space.epoch = { low = 1, high = 2 }", "did you mean 'epochs'"),
    ("space.epochs = { low = 2, high = 1 }", "below high"),
    ("space.epochs = { low = 1.5, high = 2 }", "whole"),
    ("space.discount = { low = 0.9, high = 1.1 }", "at most 1"),
    ("space.learning_rate = { low = 0.0, high = 0.1, log = true }", "positive"),
    ("space.hidden = { low = 1, high = 2 }", "choices"),
    ("space.batch_size = { choices = [0] }", "at least 2"),
    ("space.batch_size = { chices = [8] }", "did you mean 'choices'"),
    ("space.epochs = { lw = 1, high = 2 }", "did you mean 'low'"),
    ("space.epochs = { low = 1 }", "low and high, or choices"),
    ("space.epochs = { choices = [1], low = 1 }", "choices or a range"),
]


@pytest.mark.parametrize(("wrong", "said"), SEARCHES)
def test_a_mistake_in_the_space_of_a_search_is_told_with_its_line(wrong, said, file):
    file.write_text(f"{TEXT}\n[search]\n{wrong}\n")
    with pytest.raises(CoopenvError, match=re.escape(said)) as caught:
        load(file)
    assert f"line {TEXT.count(chr(10)) + 3}" in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"grid": {"reward": []}}, "at least one level"),
        ({"grid": {"reward": ["task", "task"]}}, "once"),
        ({"grid": {"reward": {"soft": "task", "Soft": "harmony"}}}, "got 'Soft' again"),
        ({"grid": {"reward": [{"preset": "task"}]}}, "must have a name"),
        ({"grid": {"algorithm": {"a": {"name": "random", "epochs": 2}}}}, "learns nothing"),
        ({"exclude": [{"algorithm": "scripted"}, {"algorithm": "random"}]}, "all of them excluded"),
        ({"seeds": 1000, "grid": {"reward": {f"r{k}": "task" for k in range(101)}}}, "100,000"),
        ({"problems": ["tasks"]}, "did you mean 'task'"),
        (
            {
                "grid": {
                    axis: {"a" * 60: "task" if axis == "reward" else {}}
                    for axis in ("task", "body", "reward", "observation")
                }
            },
            "at most 240 letters",
        ),
    ],
)
def test_a_grid_from_python_is_checked_as_well(changes, said, tmp_path):
    with pytest.raises(CoopenvError, match=re.escape(said)):
        small(tmp_path, **changes).cells()


def test_an_experiment_is_at_the_trainers_defaults_where_nothing_is_said(tmp_path):
    (cell,) = Experiment(seeds=[3], out=tmp_path).cells()
    assert cell.training == TrainConfig(seed=3)
    assert cell.learns


@pytest.fixture(scope="module")
def example():
    experiment, search = load(EXAMPLE)
    assert search is not None
    assert len(experiment.seeds) == 5
    return replace(experiment, seeds=1).cells()


def test_the_example_has_eight_prices_alone_and_with_a_share_in_wrenches_and_in_motions(example):
    cells = example
    assert len(cells) == 8 * 2 * 2
    shared = [cell for cell in cells if cell.levels["reward"].endswith("_80_20")]
    assert len(shared) == len(cells) / 2
    assert all(cell.environment.terms["share"].wanted == (0.8, 0.2) for cell in shared)
    alone = {cell.levels["reward"]: cell.environment.terms for cell in cells}
    for name, terms in alone.items():
        if not name.endswith("_80_20"):
            with_share = {k: v for k, v in alone[f"{name}_80_20"].items() if k != "share"}
            assert with_share == dict(terms)


def test_the_examples_difference_of_forces_is_that_along_the_beam(example):
    config = next(cell.environment for cell in example if cell.levels["reward"] == "difference")
    core = Transport(num_worlds=5, config=config)
    core.reset(seed=0)
    core.step(np.random.default_rng(0).uniform(-1, 1, (5, 2, 3)))
    transition = core.transition
    assert transition is not None
    forces = transition.applied[..., 0]  # along the beam, object frame
    price = config.terms["squeeze"](transition)
    expected = -0.05 * np.abs(forces[:, 0] - forces[:, 1])
    np.testing.assert_allclose(price, np.stack([expected, expected], axis=1), atol=1e-12)
