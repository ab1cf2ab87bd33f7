"""Scenarios and suites: which environments, episodes and tolerances a benchmark consists of."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from hashlib import sha256
from math import pi
from typing import Any

from coopenv.config import TransportConfig

from ..environment import find_config

EVALUATION = 18  # number of the evaluation: the same starts and goals for whatever is entered
EPISODES = 200  # of each scenario, held out
BUDGET = 2_000_000  # [control steps] of training, where a suite has no other
HALVED, DOUBLED = 0.5, 2.0  # tolerances of place for which success is told as well
PLACE = ("position_tolerance", "angle_tolerance", "height_tolerance", "mean_tolerance")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """An environment in which something entered acts as all the agents that learn."""

    name: str
    env: str  # without "coopenv/" and version
    settings: Mapping[str, Any] = field(default_factory=dict)  # keywords of the environment

    @cached_property
    def config(self) -> TransportConfig:
        """The whole environment."""
        return find_config(f"coopenv/{self.env}-v0", dict(self.settings))

    def within(self, factor: float) -> TransportConfig:
        """The environment with so many times the tolerances of place: distances and angles."""
        task: Any = self.config.task
        there = [entry.name for entry in fields(task) if entry.name in PLACE]
        scaled = {
            name: factor * value for name in there if (value := getattr(task, name)) < pi
        }  # from π on any angle will do
        return replace(self.config, task=replace(task, **scaled))


@dataclass(frozen=True, kw_only=True)
class Suite:
    """Scenarios with a version: what was measured of one version holds of that alone.

    Whoever changes a scenario, the episodes or what an environment is raises the version; a test
    holds the digest of each.
    """

    name: str
    version: int
    title: str
    scenarios: tuple[Scenario, ...]
    episodes: int = EPISODES
    evaluation: int = EVALUATION
    budget: int = BUDGET
    """Control steps that a policy may be trained for, over all worlds and all its seeds. More is
    not refused, but marked, so that it is in no digest."""

    @property
    def label(self) -> str:
        """Name and version, as ``team-1``."""
        return f"{self.name}-{self.version}"

    def digest_of(self, scenario: Scenario) -> str:
        """SHA-256 of a scenario with everything that its figures depend on but the code.

        Entries of the configuration that are null are left out: one that is new and says nothing
        changes nothing.
        """
        content = {
            "config": _without_null(json.loads(scenario.config.to_json())),
            "episodes": self.episodes,
            "evaluation": self.evaluation,
            "tolerances": [HALVED, DOUBLED],
        }
        return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def digest(self) -> str:
        """SHA-256 of all scenarios with their names."""
        each = [[scenario.name, self.digest_of(scenario)] for scenario in self.scenarios]
        return sha256(json.dumps([self.label, *each]).encode()).hexdigest()


def _without_null(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_null(one) for name, one in value.items() if one is not None}
    return [_without_null(one) for one in value] if isinstance(value, list) else value
