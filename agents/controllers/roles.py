"""Roles: a team in which each agent acts by a policy of its own."""

from collections.abc import Mapping
from numbers import Integral

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, IntArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.transition import Transition
from coopenv.transport import Transport

from ..policy import Policy, Resettable, Seedable, check_environment
from .velocities import check_config


class Roles:
    """A `coopenv.agents.policy.Policy` made of one for each learner.

    Each is asked for the actions of all learners, as by itself, and gives those of its agent; so
    any policy will do that can move the whole team, or every agent by what it sees itself.

    Parameters
    ----------
    config
        Of the environment.
    policies
        By the numbers of the agents that learn, all of them.

    Raises
    ------
    InvalidInput
        If a learner has no policy, one is of somebody else, or one is no policy.
    """

    def __init__(self, config: TransportConfig, policies: Mapping[int, Policy]):
        check_config(config)
        _check(policies, config.learners)
        self.policies = {agent: policies[agent] for agent in config.learners}
        self._different = list({id(policy): policy for policy in policies.values()}.values())

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions of all learners, each by its own policy."""
        given = {id(policy): policy(obs, transition) for policy in self._different}
        parts = [given[id(policy)][:, place] for place, policy in enumerate(self.policies.values())]
        return np.stack(parts, axis=1)

    def reset(self, mask: BoolArray) -> None:
        """Forget the episodes of the worlds that ``mask`` ``(world,)`` marks."""
        for policy in self._different:
            if isinstance(policy, Resettable):
                policy.reset(mask)

    def seed_episodes(self, seeds: IntArray, worlds: IntArray | None = None) -> None:
        """Seeds ``(world,)`` of the episodes that begin now, in every world or in ``worlds``."""
        for policy in self._different:
            if isinstance(policy, Seedable):
                policy.seed_episodes(seeds, worlds)

    def check_environment(self, core: Transport) -> None:
        """Raise `InvalidInput` if one of them says that it cannot act in ``core``."""
        for policy in self._different:
            check_environment(policy, core)


def _check(policies: object, learners: tuple[int, ...]) -> None:
    """Raise `InvalidInput` unless there is a policy for each of the ``learners``, and no other."""
    if not isinstance(policies, Mapping):
        raise InvalidInput(
            f"policies must be a mapping from agents' numbers, got {policies!r:.80}; pass for "
            "example {0: leader, 1: follower}"
        )
    numbers = all(isinstance(agent, Integral) and not isinstance(agent, bool) for agent in policies)
    if not numbers or set(policies) != set(learners):
        raise InvalidInput(
            f"policies must be one for each of the agents {learners}, got some of "
            f"{[*policies]}; leave out those that a partner drives"
        )
    for agent, policy in policies.items():
        if not callable(policy):
            raise InvalidInput(
                f"policies must be called as policy(obs, transition), got {policy!r:.80} for "
                f"agent {agent}; pass a Policy"
            )
