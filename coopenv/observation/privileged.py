"""The ``body`` block: what is carried and by whom, for critics that may know more than actors."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.transition import Transition


def privileged(transition: Transition) -> FloatArray:
    """Parameters of the body, then grip and limits of each agent, its own first.

    ``(world, agent, 9 + 4 (n − 1))``; `coopenv.conditions.Conditions.parameters` in order, but
    the grips seen from the centre of mass along the agent's own axes. There its own has no y.
    """
    named, frame = transition.conditions.parameters(), transition.team.frame
    num_worlds, num_agents = frame.shape[:2]
    order = (np.arange(num_agents)[:, None] + np.arange(num_agents)) % num_agents
    x, y = np.moveaxis(named["grips"][:, order], -1, 0)  # (world, agent, other)
    c, s = frame[..., 0, None], frame[..., 1, None]
    limits = named["force_limit"][:, order], named["torque_limit"][:, order]
    team = np.stack([c * x + s * y, c * y - s * x, *limits], axis=-1)
    body = np.stack([value for value in named.values() if value.ndim == 1], axis=-1)
    every = body[:, None].repeat(num_agents, axis=1)
    flat = team.reshape(num_worlds, num_agents, -1)
    return np.concatenate([every, flat[..., :1], flat[..., 2:]], axis=-1)
