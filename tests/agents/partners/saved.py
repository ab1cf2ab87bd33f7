"""Files of untrained policies that partners' tests load."""

from pathlib import Path
from typing import Any

from coopenv import TransportConfig
from coopenv.agents import sb3
from tests.agents.learned.cases import untrained
from tests.agents.partners.cases import SEEN


def saved_each(folder: Path) -> dict[str, str]:
    """A file of each kind of control."""
    return {c: saved(folder / f"{c}.zip", control=c) for c in ("joint", "shared", "partner")}


def saved(path: Path, config: TransportConfig = SEEN, control: str = "joint") -> str:
    """The file of an untrained policy of PPO, with the record of its environment."""
    venv = sb3.make_vec_env(config, 2, control=control)
    model = untrained(sb3_ppo(), venv)
    model.policy.log_std.data.fill_(-2.0)  # so that no sample is clipped
    sb3.SB3Policy(model, notes=venv.to_notes()).save(path)
    return str(path)


def sb3_ppo() -> Any:
    import stable_baselines3
    import torch

    torch.set_num_threads(1)
    return stable_baselines3.PPO
