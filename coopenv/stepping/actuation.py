"""Actuation: what of the agents' commands acts in a step, behind a delay, a lag and a rate limit.

Of component j of agent i's action in step n, u_n clipped to [−1, 1], along the agent's own axes:

    d_n = u_{n − delay}                                  and 0 before there was one
    y_n = d_n + (y_{n−1} − d_n) exp(−dt / T)             T the time constant
    a_n = a_{n−1} + min(max(y_n − a_{n−1}, −r dt), r dt)  r the rate limit

from y = a = 0 at the start of an episode, when nothing is commanded. So y is what a first-order lag
under a command that is held during each step reaches at the step's end, exactly; like a command it
is held during the whole step, which puts it ahead of the continuous lag by less than a step. a_n is
handled as an action is without actuators.
"""

from math import prod
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.compiled import compiled
from coopenv.conditions import Team
from coopenv.config import ACTIONS, TransportConfig
from coopenv.config.actuators import longest_delay
from coopenv.errors import InvalidInput
from coopenv.physics.actuators import DELAY, RATE_LIMIT, TIME_CONSTANT
from coopenv.physics.world import World
from coopenv.stepping.handling import Given, HeldWrenches


class Actuated(HeldWrenches):
    """Commands go through actuators before they are handled, those of driven agents too.

    Parameters
    ----------
    handling
        How what acts moves the worlds.
    config
        Of the environment; it has actuators.
    num_worlds
        Worlds stepped together.
    """

    def __init__(self, handling: HeldWrenches, config: TransportConfig, num_worlds: int):
        assert config.actuators is not None
        self._handling, self._dt = handling, config.dt
        kept = longest_delay(config.actuators, config.randomise) + 1
        shape = config.num_agents, ACTIONS[config.action]
        self._pending = _room((num_worlds, kept, *shape))  # commands, one after the other in a ring
        self._next = np.zeros(num_worlds, dtype=np.int64)  # where in it the next one goes
        self._lagging = np.zeros((num_worlds, *shape))  # behind the lag
        self._acting = np.zeros((num_worlds, *shape))  # and behind the limit

    def begin(self, worlds: IntArray, pose: FloatArray, team: Team) -> None:
        """Nothing is commanded and nothing acts; see `HeldWrenches.begin`."""
        self._handling.begin(worlds, pose, team)
        self._pending[worlds] = self._lagging[worlds] = self._acting[worlds] = 0.0

    def move(self, world: World, action: FloatArray, team: Team) -> Given:
        """See `HeldWrenches.move`; the action told is what was commanded."""
        commanded = np.empty(action.shape)
        _act(
            action, team.actuators, self._dt, self._pending, self._next, self._lagging,
            self._acting, commanded,
        )  # fmt: skip
        return self._handling.move(world, self._acting, team)._replace(action=commanded)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """See `HeldWrenches.get_state`."""
        return {
            **self._handling.get_state(worlds),
            "pending": self._pending[worlds],
            "next": self._next[worlds],
            "lagging": self._lagging[worlds],
            "acting": self._acting[worlds],
        }

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """See `HeldWrenches.set_state`."""
        self._handling.set_state(state, worlds)
        self._pending[worlds], self._next[worlds] = state["pending"], state["next"]
        self._lagging[worlds], self._acting[worlds] = state["lagging"], state["acting"]


def behind_actuators(
    handling: HeldWrenches, config: TransportConfig, num_worlds: int
) -> HeldWrenches:
    """``handling`` behind the actuators of the configuration; without any, as it is."""
    return handling if config.actuators is None else Actuated(handling, config, num_worlds)


def _room(shape: tuple[int, int, int, int]) -> FloatArray:
    """Memory for every command that is under way: (world, delay, agent, a)."""
    try:
        return np.zeros(shape)
    except MemoryError as error:
        raise InvalidInput(
            f"actuators.delay must let its commands fit into memory, got {shape[1] - 1} steps of "
            f"{shape[0]} worlds, {8 * prod(shape) / 1e9:.2g} GB; lower it, or use fewer worlds"
        ) from error


@compiled
def _act(action, actuators, dt, pending, next_, lagging, acting, commanded):
    """One step of all actuators; writes ``commanded``, the clipped action, and what they remember.

    ``action`` is ``(world, agent, a)``, ``actuators`` ``(world, agent, 3)`` as
    `coopenv.Actuators.table`, the rest as in `Actuated`.
    """
    num_worlds, num_agents, width = action.shape
    kept = pending.shape[1]
    for k in range(num_worlds):
        now = next_[k]
        next_[k] = (now + 1) % kept
        for i in range(num_agents):
            due = (now - int(actuators[k, i, DELAY])) % kept
            constant = actuators[k, i, TIME_CONSTANT]
            left = np.exp(-dt / constant) if constant > 0.0 else 0.0
            most = actuators[k, i, RATE_LIMIT] * dt
            for j in range(width):
                commanded[k, i, j] = min(max(action[k, i, j], -1.0), 1.0)
                pending[k, now, i, j] = commanded[k, i, j]
                late = pending[k, due, i, j]
                lagging[k, i, j] = late + left * (lagging[k, i, j] - late)
                change = lagging[k, i, j] - acting[k, i, j]
                if abs(change) > most:
                    acting[k, i, j] += most if change > 0.0 else -most
                else:
                    acting[k, i, j] = lagging[k, i, j]
