"""Training by a recipe: its files, beginning anew after a kill, and what it refuses."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")
pytest.importorskip("matplotlib")

from coopenv.agents import curves
from coopenv.agents.algorithms import RECIPES
from coopenv.agents.algorithms.models import model_of
from coopenv.agents.algorithms.train import train_by
from coopenv.agents.episodes import Episodes
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy, make_vec_env
from coopenv.errors import InvalidInput
from tests.agents.algorithms.cases import SMALL, run_in
from tests.agents.training.cases import SHORT


@pytest.fixture(scope="module", autouse=True)
def _undrawn():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curves, "draw", lambda *given: None)
        yield


def trained(name: str, out: Path, **given: Any) -> SB3Policy:
    return train_by(SMALL[name], run_in(out), environment=SHORT, **given)


def episodes_of(policy: SB3Policy) -> Episodes:
    return run_episodes(policy, SHORT, episodes=5, num_worlds=5)


@pytest.fixture(scope="module", params=RECIPES)
def undisturbed(request, tmp_path_factory):
    """Name, folder, policy and rows of a training that nobody disturbed."""
    out, rows = tmp_path_factory.mktemp(request.param), []
    policy = trained(request.param, out, report=rows.append)
    return request.param, out, policy, rows


def test_a_training_leaves_policy_curves_and_logs(undisturbed):
    name, out, _, rows = undisturbed
    assert {path.name for path in out.iterdir()} == {"policy.zip", "curves.csv", "tensorboard"}
    assert list(out.glob(f"tensorboard/{name}_1/events*"))
    assert [row["steps"] for row in rows] == [128, 256, 384, 512]
    with (out / "curves.csv").open(newline="") as file:
        kept = [*csv.DictReader(file)]
    assert [float(row["success"]) for row in kept] == [row["success"] for row in rows]
    assert {"relative_cost", "load_imbalance", "reward/progress"} <= set(rows[-1])


def test_the_policys_file_acts_as_the_policy_did_and_holds_nothing_that_needs_trust(undisturbed):
    _, out, policy, _ = undisturbed
    read = SB3Policy.load(out / "policy.zip")
    mine, theirs = episodes_of(policy), episodes_of(read)
    np.testing.assert_array_equal(mine.reward, theirs.reward)
    np.testing.assert_array_equal(mine.relative_cost, theirs.relative_cost)


def test_the_policys_file_says_environment_recipe_and_seed(undisturbed):
    name, out, *_ = undisturbed
    provenance = Provenance.read(out / "policy.zip")
    assert provenance is not None
    assert provenance.config() == SHORT
    said = provenance.training
    assert (said["algorithm"], said["seed"], said["control"]) == (name, 1, "joint")
    assert said["steps"] == 512


def test_a_training_that_is_killed_begins_anew_and_comes_to_the_same_policy(undisturbed, tmp_path):
    name, out, policy, rows = undisturbed

    def killed(row):
        if row["steps"] >= 256:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        trained(name, tmp_path, report=killed)
    assert not (tmp_path / "policy.zip").exists()
    again = []
    mine = trained(name, tmp_path, report=again.append)
    assert again == rows
    assert (tmp_path / "curves.csv").read_bytes() == (out / "curves.csv").read_bytes()
    np.testing.assert_array_equal(episodes_of(mine).reward, episodes_of(policy).reward)
    assert len([*tmp_path.glob(f"tensorboard/{name}_*")]) == 1  # the log of the killed one is gone


def test_a_training_that_is_finished_is_not_repeated_and_no_other_writes_over_it(
    undisturbed, tmp_path
):
    name, out, policy, _ = undisturbed
    (tmp_path / "policy.zip").write_bytes((out / "policy.zip").read_bytes())
    rows = []
    found = trained(name, tmp_path, report=rows.append)
    assert rows == []
    np.testing.assert_array_equal(episodes_of(found).reward, episodes_of(policy).reward)
    others = {"seed": run_in(tmp_path, seed=2), "control": run_in(tmp_path, control="shared")}
    for what, other in others.items():
        with pytest.raises(InvalidInput, match=rf"no other run.*training\.{what}"):
            train_by(SMALL[name], other, environment=SHORT)


def test_teams_of_several_sizes_are_refused(tmp_path):
    given = run_in(tmp_path, control="shared", teams=(2, 3))
    with pytest.raises(InvalidInput, match="teams must be left out"):
        train_by(SMALL["sac"], given)


def test_sac_counts_control_steps_of_worlds_where_every_agent_is_a_row():
    venv = make_vec_env(SHORT, 4, control="shared")
    model: Any = model_of(SMALL["sac"], venv, seed=0)
    assert (venv.num_envs, model.learning_starts) == (8, 2 * SMALL["sac"].random_steps)
    assert model.buffer_size == 2 * SMALL["sac"].buffer


def test_a_training_of_every_agents_policy_has_as_many_control_steps(tmp_path):
    rows = []
    given = run_in(tmp_path, control="shared")
    train_by(SMALL["sac"], given, environment=SHORT, report=rows.append)
    assert [row["steps"] for row in rows] == [128, 256, 384, 512]


def test_a_training_that_diverges_says_so_and_leaves_no_policy(tmp_path, monkeypatch):
    def broken(row):
        policy: Any = seen[0].policy
        policy.actor.mu.weight.data.fill_(float("nan"))

    seen = []
    from coopenv.agents.algorithms import train as module

    def model_and_watch(*given, **named):
        seen.append(model_of(*given, **named))
        return seen[0]

    monkeypatch.setattr(module, "model_of", model_and_watch)
    with pytest.raises(InvalidInput, match="diverged; lower learning_rate"):
        trained("sac", tmp_path, report=broken)
    assert not (tmp_path / "policy.zip").exists()
