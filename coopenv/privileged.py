"""The ``body`` block: what is carried and by whom, for critics that may know more than actors."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.transition import Transition


def privileged(transition: Transition) -> FloatArray:
    """Parameters of the body, then grip and limits of each agent, its own first.

    ``(world, agent, privileged_size)``; `coopenv.conditions.Conditions.parameters` in order.
    """
    named = transition.conditions.parameters()
    x, y = named["grips"][..., 0], named["grips"][..., 1]
    own = np.stack([x, y, named["force_limit"], named["torque_limit"]], axis=-1)
    num_worlds, num_agents = own.shape[:2]
    order = (np.arange(num_agents)[:, None] + np.arange(num_agents)) % num_agents
    team = own[:, order].reshape(num_worlds, num_agents, -1)
    body = np.stack([value for value in named.values() if value.ndim == 1], axis=-1)
    return np.concatenate([body[:, None].repeat(num_agents, axis=1), team], axis=-1)


def privileged_size(num_agents: int) -> int:
    """Features of the block in a team of ``num_agents``."""
    return 6 + 4 * num_agents
