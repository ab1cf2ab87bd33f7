"""Scripted followers of the benchmark, beside a scripted leader who alone knows the goal."""

import time
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from benchmarks.haptics.cells import Cell, Found, environment, measured
from coopenv import TransportConfig
from coopenv.agents.controllers.active import ActiveFollower
from coopenv.agents.controllers.follower import Follower, Still, released
from coopenv.agents.controllers.impedance import ImpedanceController
from coopenv.agents.controllers.roles import Roles
from coopenv.agents.controllers.straight import Straight
from coopenv.agents.policy import Policy
from coopenv.transition import Transition

Made = tuple[TransportConfig, Policy]


class Nothing:
    """Holds the object and gives no wrench."""

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        return np.zeros((*obs.shape[:2], transition.action.shape[2]))


def _beside(follower: Callable[[TransportConfig], Policy]) -> Callable[[TransportConfig], Made]:
    """The follower of hands beside the leader `Straight`."""

    def made(config: TransportConfig) -> Made:
        return config, Roles(config, {0: Straight(config), 1: follower(config)})

    return made


def _lets_go(config: TransportConfig) -> Made:
    if config.hands is None:
        return config, Roles(config, {0: ImpedanceController(config), 1: Nothing()})
    slack = released(config, (1,))
    return slack, Roles(slack, {0: Straight(slack), 1: Still(slack)})


def _told(config: TransportConfig) -> Made:
    return config, ImpedanceController(config) if config.hands is None else Straight(config)


def _floats(config: TransportConfig) -> Policy:
    return Follower(config, compliance=0.0, turn_compliance=0.0)


def _floats_late(config: TransportConfig) -> Policy:
    return Follower(config, compliance=0.0, turn_compliance=0.0, anticipation=0.0)


def _late(config: TransportConfig) -> Policy:
    return Follower(config, anticipation=0.0)


FOLLOWERS: Mapping[str, Callable[[TransportConfig], Made]] = {
    "keeps still": _beside(Still),
    "floats": _beside(_floats),
    "floats late": _beside(_floats_late),
    "lets go": _lets_go,
    "gives way late": _beside(_late),
    "gives way": _beside(Follower),
    "assists": _beside(ActiveFollower),
    "is told": _told,
}
WITH_WRENCHES = ("lets go", "is told")  # the others need a hand


def possible(cell: Cell) -> bool:
    """Whether there is such a follower with the cell's action."""
    return cell.action == "motion" or cell.follower in WITH_WRENCHES


def run(cell: Cell, episodes: int) -> Found:
    """A cell's held-out episodes."""
    began = time.process_time()
    config, team = FOLLOWERS[cell.follower](environment(cell))
    seen = measured(team, config, episodes)
    return Found.of(cell, seen, time.process_time() - began)
