"""A trained policy in the learners' place beside a partner, whatever team it was trained for."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.observation import Sensor
from coopenv.transition import Transition

from ..partners.learned import PolicyPlayer
from ..policy import Seatable, Seedable, forget


class Seated:
    """A `coopenv.agents.policy.Policy` that acts for the learners as a partner would.

    It sees the blocks that its file records. One that moves a whole team sees all agents, and what
    it would do with the others is left out.

    Parameters
    ----------
    policy
        A trained one.
    config
        Of an environment with a partner.

    Raises
    ------
    InvalidInput
        If it cannot see there what it was trained on, was trained for other actions or another
        team, or sees through sensors.
    """

    def __init__(self, policy: Seatable, config: TransportConfig):
        self._config = config
        self._seat = policy.as_partner(config, config.learners)
        if any(isinstance(entry, Sensor) for entry in self._seat.observe):
            raise InvalidInput(
                "policy must see without sensors to be seated beside a partner, got one that was "
                "trained with them; enter one that was trained beside a partner as a function"
            )
        self._player = self._of(1)

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, learner, action_size)``."""
        if len(self._player.kind) != len(obs):
            self._player = self._of(len(obs))
        return self._player.actions(transition)

    def reset(self, mask: BoolArray) -> None:
        """Forget the episodes of the worlds that ``mask`` ``(world,)`` marks."""
        forget(self._seat.policy, mask)

    def seed_episodes(self, seeds: IntArray, worlds: IntArray | None = None) -> None:
        """Seeds ``(world,)`` of the episodes that begin now, in every world or in ``worlds``."""
        if isinstance(self._seat.policy, Seedable):
            self._seat.policy.seed_episodes(np.asarray(seeds), worlds)

    def _of(self, num_worlds: int) -> PolicyPlayer:
        return PolicyPlayer(self._seat, self._config, num_worlds, self._config.learners)
