"""PPO of Stable-Baselines3 learns to carry a beam; ``coopenv train`` adds logs and checkpoints."""

from dataclasses import dataclass

import torch
import tyro
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy

from coopenv.agents import sb3


@dataclass
class Config:
    """What can be changed: ``python examples/train_ppo.py --reward harmony``."""

    total_steps: int = 600_000  # control steps over all worlds
    num_worlds: int = 256  # stepped together
    control: str = "joint"  # one policy for the team, or "shared": the same one for each agent
    reward: str = "task"  # or "harmony": a price on the relative cost γ as well
    seed: int = 0  # world k is seeded with seed + k
    out: str = "ppo_beam.zip"  # file of the policy


config = tyro.cli(Config)
torch.set_num_threads(1)  # more are slower at this size
venv = sb3.make_vec_env(
    "coopenv/BeamTransport-v0", config.num_worlds, control=config.control, reward=config.reward
)
keywords = sb3.recommended(venv)  # n_steps, batch_size and the like, and how features are scaled
model = PPO("MlpPolicy", venv, seed=config.seed, **keywords)
model.learn(config.total_steps * venv.num_envs // config.num_worlds, progress_bar=True)
sb3.SB3Policy(model).save(config.out)

mean, spread = evaluate_policy(model, venv, n_eval_episodes=100)
print(f"return {mean:.2f} ± {spread:.2f} over 100 episodes; policy in {config.out}")
