"""Worlds that are drawn, and their pictures."""

import numpy as np

from coopenv import Transport
from coopenv.render import Renderer
from coopenv.render.canvas import Picture
from coopenv.transition import Transition

SQUEEZE = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]  # both push towards the centre of mass


def started(**keywords) -> Transport:
    """A world with the object in the middle and the goal beside it."""
    core = Transport(num_worlds=1, **keywords)
    core.reset(seed=0, pose=(0.0, 0.0, 0.3), goal=(0.4, 1.4, 0.0))
    return core


def stepped(action, **keywords) -> Transport:
    core = started(**keywords)
    core.step(np.asarray(action)[None])
    return core


def last(core: Transport) -> Transition:
    assert core.transition is not None
    return core.transition


def picture(core: Transport, **keywords) -> Picture:
    return Renderer(core.bodies, core.scenes, **keywords).picture(last(core))
