"""Parts of an object wrench that agents have, in a batch of worlds whose teams change."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.conditions import Team
from coopenv.config import ACTIONS, TransportConfig
from coopenv.wrench.grasp import grasp_matrix

from ..controllers.hand_motions import HandMotions
from .way import Way


class Parts:
    """Each agent's part of an object wrench: the pseudoinverse's (eq. 7).

    Where hands carry out the actions, that of hands whose references move as one rigid body.

    Parameters
    ----------
    config
        Of the environment.
    num_worlds
        Worlds stepped together.
    motions
        Of the hands, if there are any.
    """

    def __init__(self, config: TransportConfig, num_worlds: int, motions: HandMotions | None):
        shape = num_worlds, config.num_agents
        self._width, self._motions = ACTIONS[config.action], motions
        self._wheels = np.array([body.nonholonomic for body in config.bodies(num_worlds)])
        self._grips, self._hands = np.full((*shape, 2), np.nan), np.zeros((*shape, 0))
        self._way: Way | None = None
        self.straight = np.zeros((*shape, 3, 3))  # (world, agent, 3, 3)
        self.on_way = self.straight  # likewise, of who knows a way
        if motions is not None:
            self._hands, self.on_way = np.zeros((*shape, 6)), self.straight.copy()

    def hold(self, worlds: IntArray, team: Team) -> None:
        """Let ``team`` hold the object in ``worlds``; one row each."""
        held = np.array_equal(self._grips[worlds], team.grips)
        if not (held and np.array_equal(self._hands[worlds], team.hands)):
            self._find(worlds, team.grips, team.hands)

    def walk(self, way: Way) -> None:
        """Part on the way of those who know one as ``way`` says."""
        self._way = way
        self._part_on_way()

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """Who holds in ``worlds``, one row each."""
        return {"grips": self._grips[worlds], "hands": self._hands[worlds]}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._find(worlds, state["grips"], state["hands"])

    def _find(self, worlds: IntArray, grips: FloatArray, hands: FloatArray) -> None:
        self._grips[worlds], self._hands[worlds] = grips, hands
        if self._motions is None:
            self.straight[worlds] = _pseudoinverse(grips, self._width)
            self._part_on_way()
            return
        free = np.zeros(len(worlds), dtype=np.bool_)
        self.straight[worlds] = self._motions.parts(grips, hands, free)
        self.on_way[worlds] = self._motions.parts(grips, hands, self._wheels[worlds])

    def _part_on_way(self) -> None:
        if self._way is not None and self._motions is None:
            self.on_way = self._way.parts(self._grips, self.straight)


def _pseudoinverse(grips: FloatArray, width: int) -> FloatArray:
    """``(world, agent, 3, 3)`` of the pseudoinverse, for actions of ``width`` numbers."""
    num_worlds, num_agents = grips.shape[:2]
    columns = [3 * i + j for i in range(num_agents) for j in range(width)]
    parts = np.linalg.pinv(grasp_matrix(grips)[..., columns])
    allocation = np.zeros((num_worlds, num_agents, 3, 3))
    allocation[:, :, :width] = parts.reshape(num_worlds, num_agents, width, 3)
    return allocation
