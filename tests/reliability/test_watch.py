"""What the soak test's watch over steps tells, and what it believes."""

from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("tyro")

from benchmarks.soak import actions
from benchmarks.soak.actions import drive, held
from benchmarks.soak.drawn.features import Drawn
from benchmarks.soak.watch import Watch
from coopenv import Actuators, Body, Hands, Ranges, Scene, Transport, TransportConfig
from coopenv.errors import BodyLost
from coopenv.physics.world import World
from tests.reliability.test_walls import spinning
from tests.test_partner import SteadyPlayer

WORLDS = 16
SLIPPERY = {
    "body": Body.beam(linear_drag=0.0, angular_drag=0.0, friction=0.2),
    "scene": Scene(size=(6.0, 6.0), friction=0.2),
}
SPRINGS = {  # that take little, and would be believed to give much if they moved
    "hands": Hands(damping=0.0, torque_damping=0.0, speed=5.0, turn_rate=5.0),
    "force_limit": 1.0,
    "torque_limit": 1.0,
}
WEAK = {"force_limit": (1e-3, 10.0), "torque_limit": (1e-3, 5.0)}  # who learns


@dataclass(frozen=True)
class ByHand:
    """A partner whose hands go on as they are told."""

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def player(self, config, num_worlds, agents):
        player = SteadyPlayer(np.tile(self.velocity, (num_worlds, len(agents), 1)))
        player.gives = "actions"  # pyright: ignore
        return player


def watched(moving: int, resting: int, twist=(0.0, 0.0, 0.0), **keywords) -> Transport:
    """Worlds looked at over a second or so, in which agents move and rest after that."""
    core = Transport(num_worlds=WORLDS, **{**SLIPPERY, "action": "motion", **keywords})
    shape, watch = (moving + resting, *core.action_shape), Watch(core, "watched")
    plan = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, shape)[::10], 10, axis=0)
    plan = plan[: moving + resting]
    plan[moving:] = 0.0
    again = np.zeros(shape[:2], dtype=np.bool_)
    for number, ride in enumerate(drive(core, 0, plan, again, in_step=True)):
        watch.look(*ride)
        if number == 0:
            core.world.twist += twist
    return core


def bouncing(monkeypatch):
    """Contacts that give five percent of the energy."""
    hold = World.hold

    def more(self, hands):
        hold(self, hands)
        self.twist[self.contact_impulse != 0] *= np.sqrt(1.05)

    monkeypatch.setattr(World, "hold", more)


def hurried(monkeypatch):
    """References that are half as fast again as commanded."""
    changed(monkeypatch, 1.5, 1.0)


def driving(monkeypatch):
    """Dampers that drive."""
    changed(monkeypatch, 1.0, -0.2)


def changed(monkeypatch, faster, damped):
    hold = World.hold

    def other(self, hands):
        spring = hands.spring * [1.0, 1.0, damped, damped]
        hold(self, hands._replace(velocity=faster * hands.velocity, spring=spring))

    monkeypatch.setattr(World, "hold", other)


@pytest.mark.parametrize(
    ("fault", "steps", "keywords"),
    [
        (bouncing, (0, 60, (1.5, 0.0, 0.0)), SPRINGS),
        (hurried, (30, 10), {}),
        (driving, (10, 60), {}),
        (driving, (0, 40, (0.5, 0.0, 0.5)), {"actuators": Actuators(time_constant=0.1)}),
        (driving, (0, 40, (0.5, 0.0, 0.5)), {"partner": ByHand(), **WEAK}),
    ],
    ids=["bouncing", "hurried", "driving", "driving-behind-actuators", "driving-partner"],
)
def test_energy_that_nobody_gave_is_told_where_hands_act(fault, steps, keywords, monkeypatch):
    watched(*steps, **keywords)
    fault(monkeypatch)
    with pytest.raises(AssertionError, match=r"world \d+ has .* J, at most"):
        watched(*steps, **keywords)


@pytest.mark.parametrize("action", ["motion", "impedance"])
def test_commands_that_act_late_slowly_and_gradually_are_believed(action):
    late = Actuators(delay=(0, 4), time_constant=(0.3, 0.0), rate_limit=(None, 3.0))
    watched(10, 40, action=action, actuators=late)


def test_what_hands_of_a_partner_store_is_believed():
    heavy = Body.beam(mass=30.0, linear_drag=0.0, angular_drag=0.0)
    watched(0, 20, partner=ByHand((1.0, 0.0, 0.0)), body=heavy, **WEAK)


def test_gravity_that_an_episode_drew_is_believed():
    scene = Scene(gravity=(0.0, -1.0))
    core = watched(30, 0, action="wrench", scene=scene, randomise=Ranges(gravity=(9.0, 11.0)))
    assert np.hypot(*core.conditions.room.gravity.T).min() >= 9.0


def losing(world: int | None):
    yield from ()
    raise BodyLost("lost", world)


def test_a_lost_body_is_explained_by_the_energy_of_its_own_world_alone():
    core, watch = spinning(0.0, num_worlds=8)
    core.world.twist[2, 2] = 1000.0
    shown = core.step(np.zeros((8, 2, 3)))
    watch.look(shown[0], shown[1], shown[4], np.zeros(8, dtype=bool))
    assert list(held(losing(2), watch)) == []
    assert watch.lost == 2
    for world in (5, None):
        with pytest.raises(BodyLost):
            list(held(losing(world), watch))


def test_speed_explains_no_lost_body_once_it_is_gone_and_nothing_overlaps():
    core, watch = spinning(1000.0, num_worlds=4)
    again = np.zeros(4, dtype=bool)
    for spin, explained in ((1000.0, True), (0.0, False)):
        core.world.place(np.arange(4), np.zeros((4, 3)))
        core.world.twist[:, 2] = spin
        for _ in range(2):  # the second begins as the first ended
            shown = core.step(np.zeros((4, 2, 3)))
            watch.look(shown[0], shown[1], shown[4], again)
        assert watch.may_lose(1) == explained


def test_a_trial_that_a_lost_body_cut_short_is_counted(monkeypatch, tmp_path):
    for limit, cut in ((1e12, 1), (10.0, 0)):
        config = TransportConfig(force_limit=limit)
        drawn = Drawn("coopenv/BeamTransport-v0", config, 2)
        monkeypatch.setattr(actions, "any_environment", lambda *_, drawn=drawn, **__: drawn)
        monkeypatch.setattr(actions, "WORLD_STEPS", 60)
        counts = actions.trial(1, tmp_path)
        assert counts["cut_short"] == cut
        assert (counts["steps"] < 60) == bool(cut)
