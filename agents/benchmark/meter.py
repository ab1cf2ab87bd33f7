"""What a benchmark measures beside an evaluation: efforts, internal power, disagreement."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.config import TransportConfig
from coopenv.info import Info
from coopenv.transition import Transition


class Meter:
    """A `coopenv.agents.evaluate.Watcher` that adds up, by episode, what no `Episodes` has.

    Parameters
    ----------
    config
        Of the environment.
    """

    def __init__(self, config: TransportConfig):
        self._learners, self._driven = list(config.learners), list(config.driven)
        self._sums: dict[str, FloatArray] = {}
        self._done: list[dict[str, FloatArray]] = []

    def add(
        self, transition: Transition, reward: FloatArray, info: Info, running: BoolArray
    ) -> None:
        """See `coopenv.agents.evaluate.Watcher`."""
        force = np.linalg.norm(transition.applied[..., :2], axis=-1)  # (world, agent) [N]
        steps = {
            "steps": np.ones(len(force)),
            "effort": force[:, self._learners].mean(axis=1),
            "internal_power": info["internal_power"],
        }
        if self._driven:
            steps["partner_effort"] = force[:, self._driven].mean(axis=1)
            steps["planned"] = info["partner_has_plan"].astype(np.float64)
            steps["disagreement"] = info["disagreement"]
        for name, values in steps.items():
            total = self._sums.setdefault(name, np.zeros(len(force)))
            total[running] += values[running]

    def end(self, episodes: int) -> None:
        """See `coopenv.agents.evaluate.Watcher`."""
        self._done.append({name: total[:episodes] for name, total in self._sums.items()})
        self._sums = {}

    def means(self) -> dict[str, FloatArray]:
        """``(episode,)`` of each measure, a mean over the episode's steps; NaN where undefined.

        ``effort`` and ``partner_effort`` [N] are of the force that a learner and a driven agent
        give, ``internal_power`` [W] passes between agents, and ``disagreement`` [m] is how far from
        the goal the partner's plan is, over the steps in which it has one. What a team without a
        partner has not is left out.
        """
        sums = {name: np.concatenate([part[name] for part in self._done]) for name in self._done[0]}
        steps, planned = sums.pop("steps"), sums.pop("planned", np.zeros(0))
        counts = {name: planned if name == "disagreement" else steps for name in sums}
        with np.errstate(invalid="ignore"):
            return {name: total / counts[name] for name, total in sums.items()}
