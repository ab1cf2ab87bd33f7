"""Learned followers of the benchmark: PPO with and without memory, and with what is in its reward.

All have the hyperparameters of `benchmarks.learning.settings.of_tables`, and as many rows to learn
from.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import torch
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack

from benchmarks.haptics.cells import Cell, Found, environment, measured
from benchmarks.learning.settings import of_tables
from coopenv import TransportConfig, rewards
from coopenv.agents.learned.sequences import WholeSequences
from coopenv.agents.partners import PARTNERS
from coopenv.agents.policy import Policy
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv, feature_scale
from coopenv.agents.seeds import training_seeds
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import ppo_settings, train
from coopenv.arrays import BoolArray
from coopenv.errors import UnknownName
from coopenv.rewards import PRESETS, RewardSum
from coopenv.transition import Transition

FRAMES = 4  # of a stack
UNITS = 64  # of a recurrent layer
GUIDE = "guiding"  # among the partners


@dataclass(frozen=True, kw_only=True)
class Learner:
    """How one kind of follower learns."""

    memory: str = "none"  # or "frames", "recurrent"
    term: tuple[str, dict[str, float]] | None = None  # of `coopenv.rewards`, beside the task's
    others: Mapping[str, Any] = field(default_factory=dict)  # keywords of the environment

    def environment(self, cell: Cell) -> TransportConfig:
        """What it learns in, and is tested in."""
        return environment(cell, reward=self.reward(), **self.others)

    def reward(self) -> RewardSum:
        """The task's reward, and the term.

        Raises
        ------
        UnknownName
            If there is no such term.
        """
        if self.term is None:
            return PRESETS["task"]
        kind, values = self.term
        if kind not in rewards.__all__:
            raise UnknownName("reward term", kind, rewards.__all__)
        return RewardSum({**PRESETS["task"], kind: getattr(rewards, kind)(**values)})

    @property
    def control(self) -> Literal["shared", "partner"]:
        """As `TrainConfig` has it."""
        return "partner" if "partner" in self.others else "shared"


LEARNERS: Mapping[str, Learner] = {
    "PPO": Learner(),
    "PPO, frames": Learner(memory="frames"),
    "PPO, recurrent": Learner(memory="recurrent"),
    "PPO beside a guide": Learner(others={"partner": GUIDE, "informed": ()}),
    "PPO, γ": Learner(term=("RelativeCost", {"weight": 0.3})),
    "PPO, F_I": Learner(term=("InternalForce", {"weight": 0.01})),
    "PPO, wasted cost": Learner(term=("WastedCost", {"weight": 0.3})),
    "PPO, internal power": Learner(term=("InternalPower", {})),
}


def possible(cell: Cell) -> bool:
    """Whether the term, and the partner, who moves hands, that its learner needs are there."""
    learner = LEARNERS[cell.follower]
    has_term = learner.term is None or learner.term[0] in rewards.__all__
    if learner.control == "partner":
        return has_term and cell.action == "motion" and learner.others["partner"] in PARTNERS
    return has_term


class Stacked:
    """A policy that sees the last observations of each agent, as ``VecFrameStack`` shows them.

    Parameters
    ----------
    policy
        That learned from stacks.
    frames
        In one; before an episode's beginning they are zero.
    """

    def __init__(self, policy: Policy, frames: int):
        self._policy, self._frames = policy, frames
        self._stack = np.zeros(0, dtype=np.float32)

    def reset(self, mask: BoolArray) -> None:
        """See `coopenv.agents.policy.Resettable`."""
        if len(self._stack) == len(mask):
            self._stack[mask] = 0.0

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        size = obs.shape[-1]
        wanted = (*obs.shape[:2], size * self._frames)
        if self._stack.shape != wanted:
            self._stack = np.zeros(wanted, dtype=obs.dtype)
        self.reset(transition.next_state.time == 0)
        self._stack[..., :-size] = self._stack[..., size:]
        self._stack[..., -size:] = obs
        return self._policy(self._stack.copy(), transition)


def run(
    cell: Cell,
    episodes: int,
    policies: Path | None = None,
    tell: Callable[[str], None] = print,
) -> Found:
    """Train a cell's learner and evaluate its mean actions; keep the policy in a folder, if any."""
    began = time.process_time()
    config = LEARNERS[cell.follower].environment(cell)
    policy = learn(cell, config, tell)
    if policies is not None and isinstance(policy, SB3Policy):
        keep(policy, policy_file(cell, policies))
    return Found.of(cell, measured(policy, config, episodes), time.process_time() - began)


def learn(cell: Cell, config: TransportConfig, tell: Callable[[str], None] = print) -> Policy:
    """The policy that a cell's learner comes to in ``config``."""
    assert cell.rows is not None
    assert cell.seed is not None
    learner = LEARNERS[cell.follower]
    with TemporaryDirectory() as folder:
        training = of_tables(
            control=learner.control,
            seed=cell.seed,
            steps=cell.rows // len(config.learners),
            out=Path(folder) / "run",
            fresh=True,
        )
        if learner.memory == "none":
            return train(training, environment=config, tell=tell)
        return _with_memory(learner.memory, training, config)


def policy_file(cell: Cell, folder: Path) -> Path | None:
    """Where a cell's policy is kept; ``None`` of one that sees a stack, as no environment shows."""
    if LEARNERS[cell.follower].memory == "frames":
        return None
    return folder / f"{cell.name}.zip"


def keep(policy: SB3Policy, path: Path | None) -> None:
    """Write a policy with the record of its environment, as ``coopenv benchmark`` reads it."""
    if path is None:
        return
    if isinstance(policy.model.policy, WholeSequences):  # its parent has the same weights
        policy.model.policy_class = RecurrentActorCriticPolicy
    path.parent.mkdir(parents=True, exist_ok=True)
    policy.save(path)


def _with_memory(memory: str, training: TrainConfig, config: TransportConfig) -> Policy:
    """A policy that remembers, of one network for all learners."""
    torch.set_num_threads(training.threads)
    venv = TransportVecEnv(config, training.num_worlds, control="shared")
    frames = FRAMES if memory == "frames" else 1
    settings = ppo_settings(training, rows=venv.num_envs, scale=feature_scale(venv) * frames)
    stacked: VecEnv = VecFrameStack(venv, frames) if frames > 1 else venv
    if memory == "frames":
        model: PPO | RecurrentPPO = PPO("MlpPolicy", stacked, **settings)
    else:
        settings["policy_kwargs"]["lstm_hidden_size"] = UNITS
        model = RecurrentPPO(WholeSequences, stacked, **settings)
    venv.seed(training_seeds(training.seed, training.num_worlds)[0])
    model.learn(training.steps * len(config.learners))
    policy = SB3Policy(model)
    return Stacked(policy, FRAMES) if memory == "frames" else policy
