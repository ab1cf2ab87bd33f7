"""Actions that hands carry out: motion and impedance."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import Body, Hands, Ranges, Scene, Transport, TransportConfig
from coopenv.agents.controllers import (
    ImpedanceController,
    WalkerController,
)
from coopenv.arrays import FloatArray
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import NEVER, OPEN_ROOM, TRIO, actions, assert_same
from tests.test_partner import Steady

BY_HANDS = ("motion", "impedance")


def started(num_worlds: int = 1, seed: int = 0, **keywords) -> Transport:
    keywords = {"action": "motion", "scene": OPEN_ROOM, "task": NEVER, **keywords}
    core = Transport(num_worlds=num_worlds, **keywords)
    core.reset(seed=seed)
    return core


def stretch_of(core: Transport) -> FloatArray:
    assert core.transition is not None
    stretch = core.transition.stretch
    assert stretch is not None
    return stretch


def after(core: Transport, action, steps: int) -> dict:
    info: dict = {}
    for _ in range(steps):
        *_, info = core.step(action)
    return info


def test_references_held_apart_along_the_beam_load_it_by_half_of_stiffness_times_distance():
    """Each spring is stretched by d/2, and what they pull with cancels: F_I = K d/2 a hand."""
    hands = Hands(stiffness=150.0, speed=0.1)
    core = started(hands=hands)
    outwards = np.array([[(-1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)]])  # x is towards the centre of mass
    after(core, outwards, 8)
    info = after(core, 0 * outwards, 100)
    apart = 2 * 8 * 0.05 * 0.1  # [m]
    stretch = stretch_of(core)
    np.testing.assert_allclose(stretch[0, :, 0], [-apart / 2, apart / 2], atol=1e-9)
    internal = np.linalg.norm(info["internal_wrench"][0, :, :2], axis=-1)
    np.testing.assert_allclose(internal, 150.0 * apart / 2, rtol=1e-6)
    np.testing.assert_allclose(info["relative_cost"], 1.0, rtol=1e-6)
    np.testing.assert_allclose(info["stored_energy"], 150.0 * (apart / 2) ** 2 / 2, rtol=1e-6)


def test_a_common_plan_loads_the_beam_less_the_slower_it_is():
    loads = []
    for speed in (0.1, 0.05):
        core = started(hands=Hands(speed=speed, turn_rate=speed / 0.9))
        together = np.array([[(0.0, 1.0, -1.0), (0.0, 1.0, -1.0)]])  # round the centre, as one
        info = after(core, -together, 60)
        loads.append(float(info["internal_force_level"][0]))
        assert abs(core.world.twist[0, 2]) > 0.5 * speed / 0.9
    assert loads[1] < 0.3 * loads[0]
    assert loads[0] < 0.2  # references go ahead of the axes that their velocity is along
    core = started(hands=Hands(speed=0.1))
    info = after(core, np.array([[(0.6, 0.8, 0.0), (-0.6, -0.8, 0.0)]]), 60)
    assert float(info["internal_force_level"][0]) < 1e-9
    np.testing.assert_allclose(np.hypot(*core.world.twist[0, :2]), 0.1, rtol=1e-3)


def test_a_hand_moves_as_fast_as_its_own_speed_says():
    hands = Hands(speed=(0.2, 0.4), turn_rate=(0.3, 0.6), stiffness=1e-6, damping=1e-6)
    core = started(hands=hands, body=Body(linear_drag=1e9, angular_drag=1e9), torque_limit=100.0)
    info = after(core, np.array([[(-1.0, 0.5, 1.0), (-1.0, 0.5, 1.0)]]), 10)
    assert info["stored_energy"].shape == (1, 2)
    stretch = stretch_of(core)
    gone = 10 * 0.05 * np.array([(-0.2, 0.1, 0.3), (0.4, -0.2, 0.6)])
    np.testing.assert_allclose(stretch[0], gone, rtol=1e-6)


def test_a_hand_that_pushed_a_wall_long_turns_back_at_once():
    core = started(scene=Scene(size=(6.0, 6.0)), hands=Hands(speed=2.0))
    core.reset(seed=0, pose=(0.0, 0.0, 0.0))
    right = np.array([[(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)]])
    info = after(core, right, 150)
    assert info["contact_impulse"][0] > 0.0
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.applied[0, :, 0], 10.0, rtol=1e-6)
    after(core, -right, 2)
    assert core.world.twist[0, 0] < 0.0


@pytest.mark.parametrize("action", BY_HANDS)
def test_stored_energy_is_told_from_the_reset_on(action):
    core = started(3, action=action, body=TRIO)
    _, first = core.reset(seed=1)
    assert not first["stored_energy"].any()
    plan = actions(0, 5, 3, 3, core.action_size)
    for push in plan:
        *_, info = core.step(push)
        assert list(info) == list(first)
        assert core.transition is not None
        spring = np.array([150.0, 150.0, 20.0])
        if action == "motion":
            energy = (spring * np.square(stretch_of(core))).sum(axis=-1) / 2
            np.testing.assert_allclose(info["stored_energy"], energy, rtol=1e-12)
        assert (info["stored_energy"] > 0.0).all()


@pytest.mark.parametrize("action", BY_HANDS)
def test_a_state_goes_on_to_the_bit_in_its_own_worlds_and_in_others(action):
    core = started(6, action=action, hands=Hands(stiffness=(80.0, 160.0)))
    plan = actions(3, 30, 6, 2, core.action_size)
    for push in plan[:10]:
        core.step(push)
    state = core.get_state()
    first = [core.step(push) for push in plan[10:]]
    core.set_state(state)
    for push, wanted in zip(plan[10:], first, strict=True):
        assert_same(core.step(push), wanted)
    other = Transport(num_worlds=2, config=core.config)
    other.set_state(state.take([4, 1]))
    for push, wanted in zip(plan[10:], first, strict=True):
        np.testing.assert_allclose(other.step(push[[4, 1]])[1], wanted[1][[4, 1]], atol=1e-9)


def test_a_new_episode_begins_with_references_on_the_grips():
    core = started(2, action="impedance")
    for push in actions(4, 20, 2, 2, 5):
        core.step(push)
    _, _, _, _, info = core.step(np.zeros((2, 2, 5)), restart=np.array([True, False]))
    assert not info["stored_energy"][0].any()
    assert info["stored_energy"][1].all()
    *_, info = core.step(np.zeros((2, 2, 5)))
    np.testing.assert_allclose(core.world.twist[0], 0.0, atol=1e-15)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_stiffness_and_damping_that_change_never_feed_energy_in(seed):
    """References at rest, stiffness and damping at random or at their bounds in every step."""
    chance = np.random.default_rng(seed)
    drag: dict[str, Any] = {"linear_drag": 0.0, "angular_drag": 0.0} if seed % 2 else {}
    core = started(8, seed % 1000, action="impedance", body=Body(**drag))
    for push in actions(seed % 2**31, 5, 8, 2, 5):
        core.step(push)
    energy = total(core)
    for _ in range(25):
        push = np.zeros((8, 2, 5))
        push[..., 3:] = chance.uniform(-1.5, 1.5, (8, 2, 2))
        core.step(push)
        now = total(core)
        assert (now <= energy * (1 + 1e-8)).all()
        energy = now
    assert (energy > 0.0).all()


def total(core: Transport):
    assert core.transition is not None
    stored, twist = core.transition.stored_energy, core.world.twist
    assert stored is not None
    mass = np.array([body.mass for body in core.bodies])
    inertia = np.array([body.inertia or 0.0 for body in core.bodies])
    moving = mass * np.square(twist[:, :2]).sum(axis=1) + inertia * twist[:, 2] ** 2
    return moving / 2 + stored.sum(axis=1)


def test_force_is_kept_where_stiffness_rises_and_stretch_where_it_falls():
    core = started(action="impedance", hands=Hands(speed=0.1))
    outwards = np.zeros((1, 2, 5))
    outwards[..., 0] = -1.0
    after(core, outwards, 8)
    rest = np.zeros((1, 2, 5))
    after(core, rest, 100)
    assert core.transition is not None
    force, stretch = core.transition.applied.copy(), np.array(core.transition.stretch)
    stiff = rest.copy()
    stiff[..., 3] = 1.0
    after(core, stiff, 1)
    np.testing.assert_allclose(core.transition.applied, force, atol=1e-8)
    np.testing.assert_allclose(stretch_of(core), stretch / 4.0, atol=1e-9)
    after(core, rest, 1)
    np.testing.assert_allclose(stretch_of(core), stretch / 4.0, atol=1e-9)
    np.testing.assert_allclose(core.transition.applied, force / 4.0, atol=1e-8)


def test_zero_is_the_hand_itself_and_one_the_bounds():
    """An impedance of zeros does to the bit what motion does."""
    soft, own = started(4, action="impedance"), started(4)
    for push in actions(7, 20, 4, 2, 3):
        whole = np.concatenate([push, np.zeros((4, 2, 2))], axis=-1)
        np.testing.assert_array_equal(soft.step(whole)[0], own.step(push)[0])
    hands = Hands(stiffness=150 * 4.0, torque_stiffness=20 * 4.0, damping=15.0, torque_damping=2.5)
    bound, firm = started(4, action="impedance"), started(4, hands=hands)
    for push in actions(8, 20, 4, 2, 3):
        ends = np.broadcast_to([1.0, -1.0], (4, 2, 2))
        bound.step(np.concatenate([push, ends], axis=-1))
        firm.step(push)
    np.testing.assert_allclose(bound.world.pose, firm.world.pose, atol=1e-9)


def test_a_partner_gives_wrenches_beside_a_hand():
    core = started(2, partner=Steady(), scene=Scene(size=(10.0, 10.0)))
    info: dict[str, Any] = {}
    for push in actions(9, 20, 2, 1, 3):
        *_, info = core.step(push)
    assert core.transition is not None
    stretch = core.transition.stretch
    assert stretch is not None
    assert not stretch[:, 1].any()
    assert stretch[:, 0].any()
    assert core.transition.applied[:, 1].any()
    assert not info["stored_energy"][:, 1].any()


@pytest.mark.parametrize("action", BY_HANDS)
def test_drawn_stiffness_and_damping_are_those_of_the_hands(action):
    ranges = Ranges(stiffness=(50.0, 300.0), damping=(10.0, 60.0), logarithmic=("stiffness",))
    core = started(64, action=action, randomise=ranges, substeps=4)
    drawn = core.conditions.parameters()
    for name, (low, high) in (("stiffness", (50.0, 300.0)), ("damping", (10.0, 60.0))):
        assert low <= drawn[name].min() < low * 1.2
        assert high * 0.8 < drawn[name].max() <= high
        assert len(np.unique(drawn[name])) == 128
    hands = core.team.hands
    np.testing.assert_allclose(hands[..., 1] / hands[..., 0], 20.0 / 150.0)
    np.testing.assert_allclose(hands[..., 3] / hands[..., 2], 5.0 / 30.0)
    *_, info = core.step(actions(1, 1, 64, 2, core.action_size)[0])
    np.testing.assert_array_equal(info["body/stiffness"], drawn["stiffness"])
    if action == "motion":
        assert core.transition is not None
        spring = hands[..., [0, 0, 1]]
        energy = (spring * np.square(stretch_of(core))).sum(axis=-1) / 2
        np.testing.assert_allclose(info["stored_energy"], energy, rtol=1e-12)


@pytest.mark.parametrize("action", BY_HANDS)
def test_whoever_gives_wrenches_says_so_where_hands_are_to_move(action):
    """Not silently: a wrench in parts of the limits would be taken for a velocity."""
    config = TransportConfig(action=action)
    core = started(action=action)
    assert core.transition is not None
    with pytest.raises(InvalidInput, match=f"got '{action}'"):
        ImpedanceController(config)(np.zeros((1, 2, 22)), core.transition)
    walker = find_config("coopenv/WalkerTurn-v0", {"action": action})
    with pytest.raises(InvalidInput, match=f"got '{action}'"):
        WalkerController(walker)(np.zeros((1, 2, 22)), core.transition)


@pytest.mark.parametrize("kind", ["leader", "follower", "walking", "load_sharing"])
@pytest.mark.parametrize("action", BY_HANDS)
def test_every_sort_of_scripted_partner_drives_beside_hands(action, kind):
    core = started(2, action=action, partner=kind, scene=Scene(size=(10.0, 10.0)))
    for push in actions(2, 15, 2, 1, core.action_size):
        core.step(push)
    assert core.transition is not None
    team = core.team
    given = core.transition.applied[:, 1]
    assert np.isfinite(given).all()
    assert (np.abs(given[:, 2]) <= team.limits[:, 1, 1] + 1e-12).all()
    np.testing.assert_array_equal(core.transition.action[:, 1, 3:], 0.0)
