"""Target of a training run: the success on held-out episodes at which it ends."""

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.config import TransportConfig

from ..evaluate import run_episodes
from ..evaluation import success_of
from ..learned import SB3Policy
from ..seeds import STOPPING
from .progress import Progress

EPISODES = (50, 500)  # of a check; the larger number only if the smaller leaves a chance
PROMISING = 0.5  # share of the target that the exploring policy reaches before anything is checked


class Reached(Exception):
    """The policy has reached its target; says with what success."""


class Target:
    """Checks between two updates whether a policy's mean actions succeed often enough.

    The lower end of the 95 % interval has to reach the target, so that it also holds on other
    episodes than these, which are neither trained on nor in any evaluation.

    Parameters
    ----------
    rate
        Success rate to reach, in ]0, 1[.
    *configs
        The environment, or that of each size of team, in all of which it has to be reached.
    """

    def __init__(self, rate: float, *configs: TransportConfig):
        self._rate, self._configs = rate, configs

    def check(self, model: BaseAlgorithm, progress: Progress) -> None:
        """Raise `Reached` if the target is."""
        newest = progress.window[-1] if progress.window else []
        successes = [episode["success"] for episode in newest]
        if not successes or np.mean(successes) < PROMISING * self._rate:
            return
        few, many = EPISODES
        _, (_, high) = self._tested(model, few)
        if high < self._rate:
            return
        success, (low, _) = self._tested(model, many)
        if low >= self._rate:
            where = " in the team that does it least" if len(self._configs) > 1 else ""
            raise Reached(
                f"{success:.1%} of {many} held-out episodes succeed{where} (95 % interval from "
                f"{low:.1%}) after {progress.steps:,} steps"
            )

    def _tested(self, model: BaseAlgorithm, episodes: int) -> tuple[float, tuple[float, float]]:
        """Success and its interval where they are lowest."""
        policy = SB3Policy(model)
        seen = [
            run_episodes(policy, config, episodes=episodes, seed=STOPPING, num_worlds=episodes)
            for config in self._configs
        ]
        return min(map(success_of, seen))
