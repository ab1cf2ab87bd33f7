"""Infos: what is told beside the observation, made when asked for, and in the form of each view."""

from coopenv.info.entries import COST, Info
from coopenv.info.steps import CLIPPED, cost_info, start_info, step_info, with_worlds
from coopenv.info.views import (
    TRIPLES,
    copied,
    copied_when_read,
    is_of_learners,
    mean,
    means,
    of_agents,
    of_team,
    of_vector,
)

__all__ = [
    "CLIPPED",
    "COST",
    "TRIPLES",
    "Info",
    "copied",
    "copied_when_read",
    "cost_info",
    "is_of_learners",
    "mean",
    "means",
    "of_agents",
    "of_team",
    "of_vector",
    "start_info",
    "step_info",
    "with_worlds",
]
