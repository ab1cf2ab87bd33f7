"""Energy of hands at rest behind actuators: stiffness and damping that change late feed none in."""

import numpy as np

from coopenv import Actuators, Body, Ranges, Scene
from tests.helpers import actions
from tests.stepping.test_handling import started, total

WORLDS, STEPS, EPISODES = 500, 25, 8  # 10⁵ steps of a body
LATEST, SLOWEST = 4, 4.0  # [control steps], [1/s]
CHANGES = 0.3  # how often stiffness or damping is told anew, a step
ROUNDING = 1e-15  # [J]: where friction has stopped all, positions are exact to so much
DRAWN = Ranges(
    mass=(3.0, 15.0),
    length=(1.0, 2.0),
    ground_friction=(0.0, 0.005),
    stiffness=(20.0, 300.0),
    damping=(0.0, 40.0),
    delay=(0, LATEST),
    rate_limit=(SLOWEST, 40.0),
)


def test_hands_at_rest_behind_actuators_never_feed_energy_in_over_a_hundred_thousand_steps():
    """References rest; stiffness and damping are told to be at the one bound or the other."""
    core = started(
        WORLDS, action="impedance", substeps=7, actuators=Actuators(delay=1), randomise=DRAWN,
        body=Body(linear_drag=0.0, angular_drag=0.0), scene=Scene(size=(400.0, 400.0)),
    )  # fmt: skip
    chance = np.random.default_rng(0)
    rest = np.zeros(core.action_shape)
    stopped = LATEST + int(np.ceil(1 / (SLOWEST * core.dt)))  # steps until no reference moves
    fed, lively = 0, 0
    for episode in range(EPISODES):
        core.reset(seed=episode)
        for push in actions(episode, 8, *core.action_shape):
            core.step(push)
        for step in range(stopped + STEPS):
            told = chance.choice([-1.0, 1.0], rest[..., 3:].shape)
            rest[..., 3:] = np.where(chance.random(told.shape) < CHANGES, told, rest[..., 3:])
            before = total(core)
            core.step(rest)
            if step >= stopped:
                fed += int((total(core) > before * (1 + 1e-10) + ROUNDING).sum())
                lively += int((before > 1e-6).sum())
    assert fed == 0
    assert lively > WORLDS * STEPS * EPISODES / 2  # there was energy to be fed
