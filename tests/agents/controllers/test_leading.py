"""Scripted walkers, doorways and tracking by hand: one step's wish in a state that is made up."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Reference, TrackingTask, Transport, TransportConfig
from coopenv.agents.controllers.doorway import DoorwayController
from coopenv.agents.controllers.impedance import Gains, ImpedanceController
from coopenv.agents.controllers.tracking import TrackingController
from coopenv.agents.controllers.walker import WalkerController, WalkerGains
from coopenv.envs.registry import find_config
from coopenv.tasks import passage
from tests.helpers import OPEN_ROOM, TRIO

AVOID, DOOR = "coopenv/WalkerAvoid-v0", "coopenv/BeamDoorway-v0"


def at(core, pose, twist=(0, 0, 0), goal=None, time=0.0):
    """The core's transition with another state of its only world."""
    assert core.transition is not None
    state = core.transition.next_state
    made = replace(
        state,
        pose=np.array([pose], float),
        twist=np.array([twist], float),
        goal=state.goal if goal is None else np.array([goal], float),
        time=np.array([time]),
    )
    return replace(core.transition, next_state=made)


def started(env=None, **keywords):
    config = TransportConfig(**keywords) if env is None else find_config(env, keywords)
    core = Transport(config=config)
    core.reset(seed=0)
    return core, config


WALK = WalkerGains(approach=1.0, speed=0.8, spin=0.9, braking=0.5, heading=2.0, arrival=0.5)


@pytest.mark.parametrize(
    ("pose", "goal", "speed", "spin"),
    [
        ((0, 0, 0), (0.5, 0, 0), 0.5, 0.0),  # approach · left
        ((0, 0, 0), (3, 0, 0), 0.8, 0.0),  # at its most
        ((0, 0, 0.1), (0.5, 0, 0.3), 0.5 * np.cos(0.1), -2 * 0.1 - 0.5 * 0.3),
        ((0, 0, -0.2), (0.5, 0, 0.3), 0.5 * np.cos(0.2), 2 * 0.2 - 0.5 * 0.3),
        ((0, 0, 3.0), (0.5, 0, np.pi), -0.5 * np.cos(np.pi - 3), 2 * (np.pi - 3)),  # backwards
        ((0, 0, np.pi / 2 + 0.01), (0.5, 0, 0), 0.0, -0.9),  # first it turns
        # The way lies at 0.5 rad: 0.2 to turn to it, and 0.3 more at its end
        ((1, 1, 0.3), (1 + 0.5 * np.cos(0.5), 1 + 0.5 * np.sin(0.5), 0.8),
         0.5 * np.cos(0.2), 2 * 0.2 - 0.5 * 0.3),
        ((0, 0, 0.2), (0.03, 0.04, 0.5), 0.03 * np.cos(0.2) + 0.04 * np.sin(0.2), 0.6),  # is there
    ],
)  # fmt: skip
def test_a_walker_is_led_by_the_polar_law(pose, goal, speed, spin):
    core, config = started("coopenv/WalkerTurn-v0", scene=OPEN_ROOM, torque_limit=200.0)
    controller = WalkerController(config, gains=WALK)
    twist, acceleration = controller.wanted_motion(at(core, pose, goal=goal))
    heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
    np.testing.assert_allclose(twist[0], [*speed * heading, spin], atol=1e-12)
    assert acceleration == 0.0


def test_a_walker_brakes_for_the_goal_and_slows_with_a_turn_that_is_too_fast():
    core, config = started("coopenv/WalkerTurn-v0", scene=OPEN_ROOM, torque_limit=200.0)
    quick = WalkerGains(approach=9.0, speed=5.0, spin=0.4, braking=0.5, heading=2.0, arrival=0.5)
    controller = WalkerController(config, gains=quick)
    twist, _ = controller.wanted_motion(at(core, (0, 0, 0), goal=(1.0, 0, 0)))
    assert twist[0, 0] == pytest.approx(1.0)  # √(2 · 0.5 · 1)
    twist, _ = controller.wanted_motion(at(core, (0, 0, -0.4), goal=(1.0, 0, 0)))
    assert twist[0, 2] == pytest.approx(0.4)  # of 0.8 wanted: half the speed as well
    assert np.hypot(*twist[0, :2]) == pytest.approx(0.5 * np.cos(0.4))


def test_the_spin_is_what_the_drives_torque_makes_against_the_drag():
    core, config = started("coopenv/WalkerTurn-v0", scene=OPEN_ROOM, torque_limit=(500.0, 50.0))
    controller = WalkerController(config, gains=WalkerGains(spin=9.0))
    twist, _ = controller.wanted_motion(at(core, (0, 0, 0), goal=(0, 3, 0)))
    assert twist[0, 2] == pytest.approx(0.9 * 50 / 100)  # drag of 100 N·m·s


def test_the_walkers_wrench_is_inverse_dynamics_of_its_wish():
    core, config = started("coopenv/WalkerTurn-v0", scene=OPEN_ROOM, torque_limit=200.0)
    controller = WalkerController(config, gains=replace(WALK, damping=3.0))
    seen = at(core, (0, 0, 0.1), twist=(0.2, 0.1, -0.3), goal=(0.5, 0, 0.3))
    force, torque = controller.object_wrench(seen)
    speed = 0.2 * np.cos(0.1) + 0.1 * np.sin(0.1)
    want, spin = 0.5 * np.cos(0.1), -0.35
    assert force[0] == pytest.approx(25 * 3 * (want - speed) + 1.0 * speed)
    assert torque[0] == pytest.approx(4.17 * 3 * (spin + 0.3) + 100 * spin)
    applied = controller.applied(seen)[0]
    np.testing.assert_allclose(applied, [[force[0], 0, 0], [0, 0, torque[0]]])
    parts = controller.parts(core.team.grips)[0]
    np.testing.assert_allclose(parts @ (7.0, 5.0, 3.0), [[7, 0, 0], [0, 0, 3]])


def test_with_forces_alone_agent_0_turns_the_walker_by_its_lever():
    core, config = started("coopenv/WalkerTurn-v0", scene=OPEN_ROOM, action="force")
    parts = WalkerController(config).parts(core.team.grips)[0]
    lever = core.team.grips[0, 0, 0]
    np.testing.assert_allclose(parts @ (7.0, 5.0, 3.0), [[7, 3 / lever, 0], [0, 0, 0]])


def test_the_impedance_is_inverse_dynamics_in_the_objects_frame():
    core, config = started(scene=OPEN_ROOM, body=TRIO)
    controller = ImpedanceController(config, gains=Gains(approach=2.0, damping=5.0))
    seen = at(core, (1, 1, np.pi / 2), twist=(0.1, -0.2, 0.3), goal=(1.1, 1.2, np.pi / 2 - 0.2))
    mass, inertia = TRIO.mass, TRIO.inertia or 0.0
    world = np.array([
        mass * 5 * (0.2 - 0.1) + 8 * 0.1, mass * 5 * (0.4 + 0.2) - 8 * 0.2,
        inertia * 5 * (-0.4 - 0.3) + 8 * 0.3,
    ])  # fmt: skip
    wanted = [world[1], -world[0], world[2]]
    np.testing.assert_allclose(controller.object_wrench(seen)[0], wanted, rtol=1e-9)


def test_tracking_feeds_the_reference_forward_and_holds_the_correction_within_the_gains():
    line = Reference(times=(0.0, 2.0), poses=((0, 0, 0), (4, -2, 1)))
    core, config = started(scene=OPEN_ROOM, task=TrackingTask(reference=line), dt=0.1)
    controller = TrackingController(config, gains=Gains(approach=2.0, speed=0.5, spin=0.3))
    seen = at(core, (1.9, -1.1, 0.4), goal=(2, -1, 0.5), time=1.0)
    twist, acceleration = controller.wanted_motion(seen)
    np.testing.assert_allclose(twist[0], [3 + 0.2, -1.5 + 0.2, 0.75 + 0.2], atol=1e-9)
    # 4 (3 s² − 2 s³) with s = t/2: 6 − 6 t at t = 1.05
    np.testing.assert_allclose(acceleration[0], np.array([4, -2, 1]) * (1.5 - 1.5 * 1.05))
    seen = at(core, (3, -1.9, 1.5), goal=(2, -1, 0.5), time=1.0)
    twist, _ = controller.wanted_motion(seen)
    np.testing.assert_allclose(twist[0], [3 - 0.5, -1.5 + 0.5, 0.75 - 0.3], atol=1e-9)


def doorway(pose, goal=(2.5, 0.0, 0.0), **gains):
    """The wish before a gap of 0.8 m at y = 0.5 in a wall of 0.2 m at x = 0, and the plan."""
    core, config = started(DOOR)
    assert core.transition is not None
    plan = core.conditions.plan.copy()
    plan[0, passage.WALL_X], plan[0, passage.GAP_Y] = 0.0, 0.5
    plan[0, passage.GAP], plan[0, passage.HALF_DEPTH] = 0.8, 0.1
    seen = at(core, pose, goal=goal)
    seen = replace(seen, conditions=replace(core.conditions, plan=plan))
    return DoorwayController(config, gains=Gains(**gains)).wanted_motion(seen)[0][0], plan[0]


def test_in_the_gap_it_goes_on_along_the_axis_and_the_better_in_line_the_faster():
    twist, _ = doorway((0.0, 0.5, 0.0), speed=1.2)
    np.testing.assert_allclose(twist, (1.2, 0, 0), atol=1e-12)
    slack = (0.8 - 0.1) / 2 - 0.02  # [m]; the beam is 0.1 m wide
    twist, _ = doorway((0.0, 0.5 - 0.75 * slack, 0.0), speed=1.2, approach=2.0)
    np.testing.assert_allclose(twist, (0.5 * 1.2 + 0.5 * 0.2, 1.5 * slack, 0), atol=1e-9)
    twist, _ = doorway((0.0, 0.5 + 2 * slack, 0.0), speed=1.2)
    assert twist[0] == pytest.approx(0.2)  # creeps
    twist, _ = doorway((0.0, 0.5, np.pi - 0.01), goal=(-2.5, 0, 0), speed=1.2, approach=2.0)
    assert twist[0] < -1.0  # the other way
    assert twist[2] == pytest.approx(0.02)  # to the nearer of the two angles


@pytest.mark.parametrize(("x", "goal"), [
    (-0.35, (2.5, 0.0, 0.0)), (0.35, (-2.5, 0.0, 0.0)),  # before the gap, either way
    (0.35, (0.35, 0.5, 0.0)), (-0.35, (-0.35, 0.5, 0.0)),  # out of it
])  # fmt: skip
def test_it_turns_the_slower_the_nearer_the_face_of_the_wall_is(x, goal):
    twist, _ = doorway((x, 0.5, np.pi / 2), goal=goal, look_ahead=0.1, margin=0.2, spin=2.0)
    ends = 1.0 * np.sin(0.1) + 0.05 * np.cos(0.1)  # [m] from its centre to its corner, turned
    cramped = 0.1 + ends + 0.2 - 0.35  # [m]; it stands still at 0.3
    assert abs(twist[2]) == pytest.approx(2.0 * (1 - cramped / 0.3))
    assert twist[0] * x > 0  # and makes room


def test_once_it_is_out_it_goes_to_the_goal():
    for place, out in ((1.07, True), (1.05, False)):  # a corner may be back by 0.04 of 0.1 m
        twist, _ = doorway((place, 0.5, 0.0), goal=(place, 0.5, 0.0))
        assert (twist[0] < 0.3) if out else twist[0] == pytest.approx(2.5)
    twist, _ = doorway((1.6, 0.5, 0.0), goal=(1.8, 0.3, 0.2), approach=2.0)
    np.testing.assert_allclose(twist, (0.4, -0.4, 0.4), atol=1e-9)
