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
