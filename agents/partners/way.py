"""The way of a task that a walking partner plans along: what its scripted controller aims for."""

from dataclasses import replace

from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.transition import Transition

from ..controllers import find_guide
from ..controllers.guidance import Gains
from ..controllers.walker import WalkerController, WalkerGains

PACE = Gains(approach=2.0, speed=0.7, spin=1.0)  # of the way; each person scales it by own gains
_WHEELS = WalkerGains(speed=PACE.speed, spin=PACE.spin)


class Way:
    """Next points of the way to any goal, in a batch of worlds.

    Parameters
    ----------
    config
        Of the environment; its task's controller knows the way
        (`coopenv.agents.controllers.find_guide`).

    Raises
    ------
    InvalidInput
        If the controller cannot lead this body.
    """

    def __init__(self, config: TransportConfig):
        gains = _WHEELS if isinstance(find_guide(config), WalkerController) else PACE
        self._controller = find_guide(config, gains=gains)

    def ahead(self, transition: Transition, goal: FloatArray) -> FloatArray:
        """Where who walks at `PACE` wants the object next, ``(world, 3)``, on its way to ``goal``.

        Towards it, the wanted velocity is ``PACE.approach`` times the way there.
        """
        state = replace(transition.next_state, goal=goal)
        twist, _ = self._controller.wanted_motion(replace(transition, next_state=state))
        return state.pose + twist / PACE.approach

    def parts(self, grips: FloatArray, pseudoinverse: FloatArray) -> FloatArray:
        """Each agent's part ``(world, agent, 3, 3)`` of an object wrench.

        What the ``pseudoinverse`` gives it, but on wheels agent 0 pushes and the last agent turns.
        """
        if isinstance(self._controller, WalkerController):
            return self._controller.parts(grips)
        return pseudoinverse
