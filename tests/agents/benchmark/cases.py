"""A small suite, and policies of somebody's own, for the tests of the benchmark."""

import numpy as np

from coopenv.agents.benchmark import Scenario, Suite
from coopenv.agents.controllers import ImpedanceController
from coopenv.agents.partners import Lagging, Leader
from coopenv.errors import InvalidInput

SMALL = Suite(
    name="team",
    version=7,
    title="a small one",
    episodes=4,
    scenarios=(
        Scenario(name="alone", env="BeamTransport", settings={"horizon": 60}),
        Scenario(
            name="beside",
            env="BeamTransport",
            settings={"horizon": 20, "partner": Lagging(partner=Leader(), delay=2)},
        ),
    ),
)


def sighted(obs):
    """A policy of the observation alone."""
    return np.tanh(obs[..., :3])


def steered(obs, transition):
    """A policy that reads the state."""
    return np.zeros((*obs.shape[:2], transition.action.shape[2]))


def made(config):
    """The scripted controller, made for each scenario."""
    return ImpedanceController(config)


def short(obs):
    """Gives too few numbers."""
    return np.zeros((*obs.shape[:2], 2))


def broken(obs):
    """Breaks off."""
    raise ZeroDivisionError("no weight")


def undefined(obs):
    """Gives what is no number."""
    return np.full((*obs.shape[:2], 3), np.nan)


def team_only(config):
    """Says where it cannot act."""
    if config.partner is not None:
        raise InvalidInput("config must have no partner, got one; leave it out")
    return sighted


def three(obs, transition, memory):
    """Takes what nobody gives."""


def nothing(config):
    """Makes nothing that acts."""


number = 3


counted: list[int] = []  # worlds of each reset that `Counting` was told of


class Counting:
    """Remembers how many steps its episodes have had; fails after so many."""

    def __init__(self, config):
        self.resets, self.steps = 0, 0

    def reset(self, mask):
        counted.append(len(mask))
        self.resets, self.steps = self.resets + 1, 0

    def __call__(self, obs):
        self.steps += 1
        return np.full((*obs.shape[:2], 3), 0.1 * min(self.resets, 5))


class Failing(Counting):
    """Breaks off in the fifth step of an episode."""

    def __call__(self, obs):
        if self.steps == 4:
            raise ZeroDivisionError("no weight left")
        return Counting.__call__(self, obs)
