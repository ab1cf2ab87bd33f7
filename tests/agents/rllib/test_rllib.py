"""Trainings with RLlib of one iteration, where it is installed: `make rllib-test`."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("ray.rllib", reason="RLlib has an environment of its own: make rllib-test")

import torch
from ray.rllib.core.rl_module.rl_module import RLModule  # pyright: ignore[reportMissingImports]

from coopenv import Transport
from coopenv.agents import load
from coopenv.agents.evaluate import evaluate
from coopenv.agents.features import scale_of_features
from coopenv.agents.provenance import Provenance
from coopenv.agents.rllib import RLlibConfig, train
from coopenv.agents.settings import EnvironmentChoice

SMALL: dict[str, Any] = {
    "steps": 128,
    "batch_size": 128,
    "minibatch_size": 64,
    "epochs": 1,
    "worlds": 2,
    "hidden": (8,),
    "episodes": 3,
}
CASES = [
    ("coopenv/BeamTransport-v0", None, "shared", 0),
    ("coopenv/WalkerAvoid-v0", None, "own", 1),  # a process that collects, as on a cluster
    ("coopenv/BeamTransport-v0", "discrete", "shared", 0),
]


@pytest.mark.parametrize(("env", "action", "policies", "runners"), CASES)
def test_an_iteration_leaves_a_policy_that_acts_as_rllibs_and_is_evaluated_as_any_other(
    env, action, policies, runners, tmp_path, monkeypatch
):
    monkeypatch.setenv("RAY_worker_niceness", "0")
    choice = EnvironmentChoice(env=env, action=action, horizon=20)
    rows = []
    config = RLlibConfig(
        environment=choice, policies=policies, runners=runners, out=tmp_path, **SMALL
    )
    _, seen = train(config, rows.append)
    assert [row["steps"] for row in rows] == [pytest.approx(128, abs=4)]
    assert np.isfinite(rows[-1]["return"])

    again: Any = load(tmp_path / "policy.npz")
    assert evaluate(again, choice.config(), episodes=3, name="rllib") == seen
    record = Provenance.read(tmp_path / "policy.npz")
    assert record is not None
    assert record.env == env
    assert record.config() == choice.config()

    core = Transport(num_worlds=4, config=choice.config())
    obs, _ = core.reset(seed=0)
    names = ["shared"] * 2 if policies == "shared" else ["agent_0", "agent_1"]
    scale, mine = np.array(scale_of_features(core), dtype=np.float32), again.form.network
    rows_of = [torch.tensor(obs[:, agent] * scale) for agent in range(2)]
    place = tmp_path / "checkpoint" / "learner_group" / "learner" / "rl_module"
    theirs = np.stack(
        [
            _said(RLModule.from_checkpoint(str(place / name)), seen)
            for name, seen in zip(names, rows_of, strict=True)
        ],
        axis=1,
    )
    rows_mine = obs.reshape(-1, mine.features)
    if action == "discrete":
        found = mine.ratings(rows_mine, 1).reshape(theirs.shape)
    else:
        found, theirs = mine.mean(rows_mine).reshape(4, 2, -1), np.clip(theirs[..., :3], -1, 1)
    np.testing.assert_allclose(found, theirs, atol=1e-5)


def _said(module, seen: torch.Tensor) -> np.ndarray:
    """What RLlib's module gives: means and spreads of actions, or scores."""
    with torch.no_grad():
        return module.forward_inference({"obs": seen})["action_dist_inputs"].numpy()
