"""Files of trained policies of any of the algorithms, as ``coopenv benchmark`` reads them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box
from torch import nn

from coopenv import TransportConfig
from coopenv.agents.algorithms.models import writable
from coopenv.agents.policy import Policy
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.trained.form import Form, write_form
from coopenv.config import ACTIONS
from coopenv.observation import Observation

SUFFIXES = {"sac": ".zip", "recurrent": ".zip", "mappo": ".npz"}
_LEARNED, _SPREAD = ".params.", ".state_independent_scale"  # in names of weights of an actor


def file_of(folder: Path, name: str, task: str, seed: int) -> Path:
    """Of a run's policy; entered as ``FOLDER/sac_{task}_0.zip``."""
    return folder / f"{name}_{task}_{seed}{SUFFIXES[name]}"


def keep(policy: Policy, path: Path, config: TransportConfig, *, seed: int, steps: int) -> None:
    """Write a policy with the record of its environment and of its control steps."""
    joint = isinstance(policy, SB3Policy)
    record = Provenance.of_environment(config, "joint" if joint else "shared")
    record = replace(record, training={**record.training, "seed": seed, "steps": steps})
    path.parent.mkdir(parents=True, exist_ok=True)
    if not joint:
        (actor,) = (each for each in vars(policy).values() if isinstance(each, nn.Module))
        write_form(plain(actor, config, record), path)
        return
    SB3Policy(writable(policy.model), notes=record.to_notes()).save(path)


def plain(actor: nn.Module, config: TransportConfig, record: Provenance) -> Form:
    """An actor of `examples.train_torchrl`, which every agent runs, in plain numbers."""
    weights = {name: value.numpy(force=True) for name, value in actor.state_dict().items()}
    (scale,) = (name for name in weights if name.endswith(".scale"))
    (spread,) = (name for name in weights if name.endswith(_SPREAD))
    layers = [name.removesuffix(".weight") for name in weights if name.endswith(".weight")]
    layers.sort(key=lambda name: int(name.rpartition(_LEARNED)[2]))
    activations = [*["tanh"] * (len(layers) - 1), "identity"]
    seen = Observation(config.observe, config.num_agents)
    limit = np.ones(ACTIONS[config.action], dtype=np.float32)
    return Form.of(
        {
            "scale": scale,
            "layers": [
                [f"{name}.weight", f"{name}.bias", activation]
                for name, activation in zip(layers, activations, strict=True)
            ],
            "output": "clip",
            "spread": spread,
        },
        (Box(seen.low, seen.high, dtype=np.float32), Box(-limit, limit, dtype=np.float32)),
        weights,
        algorithm="examples.train_torchrl:ClipPPOLoss",
        normalization=None,
        blueprint={},
        notes=record.to_notes(),
    )
