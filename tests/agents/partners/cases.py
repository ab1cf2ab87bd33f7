"""What the tests of policies as partners share: environments, a memory, wrenches of an episode."""

from dataclasses import replace
from typing import Any

import numpy as np

from coopenv import Transport, TransportConfig
from coopenv.agents.partners import PARTNERS
from tests.helpers import NEVER, actions

SEEN = TransportConfig(task=NEVER, observe=("goal", "twist", "own_wrench"), horizon=50)
OTHER = replace(SEEN, observe=("time", "partner_wrench"))  # what the learner beside it sees


def acting(name: str) -> dict[str, Any]:
    """Keywords under which a partner of that name can act."""
    return {"action": "motion"} if PARTNERS[name].needs_hands else {}


def wrenches(core: Transport, episodes: int = 3, steps: int = 4, **reset: Any) -> np.ndarray:
    """What agent 1 gives in some episodes, which worlds begin together."""
    given = []
    for k in range(episodes):
        core.reset(**(reset if k == 0 else {}))
        for action in actions(k, steps, core.num_worlds, 1, 3):
            core.step(action)
            assert core.transition is not None
            given.append(core.transition.applied[:, 1])
    return np.array(given)


class Counting:
    """A policy with a memory: how many steps the episode of each world has lasted."""

    def __init__(self, num_worlds: int):
        self.steps = np.zeros(num_worlds)

    def reset(self, mask):
        self.steps = np.where(mask, 0.0, self.steps)

    def __call__(self, obs, transition):
        self.steps = self.steps + 1
        return np.tile(self.steps[:, None, None] / 10, (1, obs.shape[1], 3))
