"""Velocities of hands: what grips move with, and a policy that says how fast each hand goes."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, number, positive
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.physics.hands import SPEED, TURN_RATE
from coopenv.transition import Transition


class HandPolicy:
    """A policy of hands; each class says in `velocities` how fast its hands are to go.

    What is beyond a hand's speed or turn rate is scaled down to it, force and turn each by itself,
    so that the direction stays.

    Parameters
    ----------
    config
        Of an environment with hands.
    firmness
        In [−1, 1], with ``action="impedance"``: where stiffness and damping are between their
        bounds.

    Raises
    ------
    InvalidInput
        If no hands carry out the actions, or ``firmness`` breaks its rule or is given with
        ``action="motion"``.
    """

    def __init__(self, config: TransportConfig, *, firmness: float = 0.0):
        check_config(config)
        if config.hands is None:
            raise InvalidInput(
                f"action must be 'motion' or 'impedance' for {type(self).__name__}, which moves "
                f"hands, got {config.action!r}; choose one of them"
            )
        if not -1 <= number(firmness, "firmness") <= 1:
            raise InvalidInput(
                f"firmness must be from -1 to 1, got {firmness!r}; -1 is as soft as hands can be"
            )
        if firmness and config.action != "impedance":
            raise InvalidInput(
                f"firmness must be 0 for action={config.action!r}, got {firmness!r}; with "
                "action='impedance' it says how stiff and damped hands are"
            )
        self.config, self.firmness = config, float(firmness)
        self._learners, self._width = list(config.learners), ACTIONS[config.action]

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)`` in [−1, 1]."""
        state, team = transition.next_state, transition.team
        velocity = self.velocities(transition)
        # A step keeps an action's direction as it is in the middle of it.
        middle = state.pose[:, 2, None] + state.twist[:, 2, None] * transition.dt / 2
        x, y = rotated_back(np.cos(middle), np.sin(middle), velocity[..., 0], velocity[..., 1])
        action = np.full((*velocity.shape[:2], self._width), self.firmness)
        action[..., 0], action[..., 1] = rotated_back(team.frame[..., 0], team.frame[..., 1], x, y)
        action[..., :2] /= team.hands[..., SPEED, None]
        action[..., 2] = np.clip(velocity[..., 2] / team.hands[..., TURN_RATE], -1.0, 1.0)
        speed = np.hypot(action[..., 0], action[..., 1])
        action[..., :2] /= np.maximum(speed, 1.0)[..., None]
        return action[:, self._learners]

    def velocities(self, transition: Transition) -> FloatArray:
        """Velocities ``(world, agent, 3)`` of all hands' references, world frame [m/s, rad/s]."""
        raise NotImplementedError


def levers(transition: Transition) -> FloatArray:
    """From the centre of mass to each grip ``(world, agent, 2)``, world frame [m]."""
    angle, grips = transition.next_state.pose[:, 2, None], transition.team.grips
    x, y = rotated(np.cos(angle), np.sin(angle), grips[..., 0], grips[..., 1])
    return np.stack([x, y], axis=-1)


def carried(twist: FloatArray, lever: FloatArray) -> FloatArray:
    """What grips move with on a body with ``twist``.

    Parameters
    ----------
    twist
        ``(world, 3)`` of the body, world frame [m/s, rad/s].
    lever
        ``(world, agent, 2)``, as of `levers`.

    Returns
    -------
    ``(world, agent, 3)``, world frame [m/s, rad/s].
    """
    out = np.repeat(twist[:, None], lever.shape[1], axis=1)
    out[..., 0] -= twist[:, 2, None] * lever[..., 1]
    out[..., 1] += twist[:, 2, None] * lever[..., 0]
    return out


def in_world(transition: Transition, wrench: FloatArray) -> FloatArray:
    """Wrenches or ways ``(world, agent, 3)`` of the object frame, in the world's axes."""
    angle = transition.next_state.pose[:, 2, None]
    x, y = rotated(np.cos(angle), np.sin(angle), wrench[..., 0], wrench[..., 1])
    return np.stack([x, y, wrench[..., 2]], axis=-1)


def check_config(config: object) -> None:
    """Raise `InvalidInput` unless ``config`` describes an environment."""
    if not isinstance(config, TransportConfig):
        raise InvalidInput(
            f"config must be a TransportConfig, got {config!r:.80}; pass the environment's, such "
            "as core.config"
        )


def gain(value: float, name: str, unit: str) -> float:
    """A gain that is zero or positive.

    Raises
    ------
    InvalidInput
        If it is not; the message has its ``name`` and ``unit``.
    """
    return positive(value, name, unit=unit, or_zero=True)
