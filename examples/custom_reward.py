"""A reward of your own, beside the ready-made terms; every part is reported in ``info``."""

from dataclasses import dataclass

import gymnasium as gym
import numpy as np

from coopenv import rewards
from coopenv.arrays import FloatArray
from coopenv.transition import Transition


@dataclass(frozen=True, kw_only=True)
class Upright:
    """Penalise turning away from the x-axis: r = −weight · |sin θ|, the same for all agents."""

    weight: float = 0.1  # [reward / step]

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        angle = transition.next_state.pose[:, 2]  # (world,) [rad]
        return transition.per_agent(-self.weight * np.abs(np.sin(angle)))


reward = rewards.RewardSum(
    {
        "progress": rewards.Progress(),
        "success": rewards.Success(weight=10.0),
        "squeeze": rewards.InternalForce(weight=0.02),
        "share": rewards.LoadShare(weight=0.05, wanted=(0.7, 0.3)),  # the first one leads
        "upright": Upright(),
    }
)

env = gym.make("coopenv/BeamTransport-v0", reward=reward)
env.reset(seed=0)
for _ in range(5):
    _, total, _, _, info = env.step(env.action_space.sample())
    print(f"{total:+.3f} =", {name: round(part, 3) for name, part in info["reward_terms"].items()})
