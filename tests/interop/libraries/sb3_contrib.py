"""sb3-contrib: RecurrentPPO keeps a state a world through our resets."""

import json
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import sb3_contrib
import torch
from sb3_contrib import RecurrentPPO

from coopenv.agents import sb3

IDS = ["coopenv/BeamTransport-v0", "coopenv/WalkerAvoid-v0"]


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view in IDS:
        learn(view)
    checked = "RecurrentPPO learns, and acts alike from a file, with the state of each world"
    version = sb3_contrib.__version__
    told = {"library": "sb3-contrib", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def learn(view: str) -> None:
    """A short training, and the same actions from a file."""
    venv = sb3.make_vec_env(view, 4, seed=0, horizon=20)
    model = RecurrentPPO(
        "MlpLstmPolicy", venv, n_steps=32, batch_size=64, n_epochs=1, seed=0,
        policy_kwargs={"lstm_hidden_size": 16, "net_arch": [16]},
    )  # fmt: skip
    start = [weight.detach().clone() for weight in model.policy.parameters()]
    model.learn(256)
    moved = zip(start, model.policy.parameters(), strict=True)
    assert any(not torch.equal(before, after) for before, after in moved)
    assert all(torch.isfinite(weight).all() for weight in model.policy.parameters())
    assert len(model.ep_info_buffer) > 0
    with TemporaryDirectory() as folder:
        model.save(f"{folder}/model")
        again = RecurrentPPO.load(f"{folder}/model")
    np.testing.assert_array_equal(*(acted(one, venv) for one in (model, again)))


def acted(model: RecurrentPPO, venv: Any) -> np.ndarray:
    """Actions of 25 steps from one seed, beyond the end of an episode."""
    venv.seed(3)
    obs, state, begun = venv.reset(), None, np.ones(venv.num_envs, dtype=bool)
    taken = []
    for _ in range(25):
        action, state = model.predict(obs, state, episode_start=begun, deterministic=True)
        obs, _, begun, _ = venv.step(action)
        taken.append(action)
    return np.stack(taken)


if __name__ == "__main__":
    main()
