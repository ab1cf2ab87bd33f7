"""Scale of features: a factor for each number that an agent sees, which brings it to order one."""

from collections.abc import Iterable

import numpy as np

from coopenv.observation.blocks import OF_BODY
from coopenv.observation.team import TEAM
from coopenv.observation.view import VIEW, WRENCH_UNIT
from coopenv.transport import Transport


def scale_of_features(transport: Transport) -> list[float]:
    """One factor a feature of one agent.

    What is bounded is divided by its bound (ranges by their reach), wrenches by the limits,
    parameters of the body by what they usually are; other lengths and speeds stay in SI units.
    """
    core = transport
    force, torque = core.config.limits().max(axis=0)
    wrench = [1 / force, 1 / force, 1 / torque]
    known: dict[str, Iterable[float]] = {
        block.name: block.spread(wrench, core.num_agents, "scale")
        for block in (*VIEW, *TEAM)
        if block.unit == WRENCH_UNIT
    }
    usual = core.conditions.parameters()
    body = [1 / (np.abs(usual[name]).max() or 1.0) for name in OF_BODY]
    limits = [1 / force, 1 / torque]
    known["body"] = [*body, 1.0, *limits, *[1.0, 1.0, *limits] * (core.num_agents - 1)]
    bound = np.maximum(np.abs(core.observation.low), np.abs(core.observation.high))
    scale = np.where(np.isfinite(bound) & (bound > 0), 1 / np.maximum(bound, 1e-9), 1.0)
    for name, where in core.observation.blocks.items():
        if name in known:
            scale[where] = list(known[name])
    return scale.tolist()
