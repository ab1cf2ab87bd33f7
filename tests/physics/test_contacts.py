"""What contacts do to a body: they take energy, and they forget what is over."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import Body, Scene
from coopenv.physics import collect, contacts
from coopenv.physics.coefficients import coefficients
from coopenv.physics.surroundings import NUM_GIVEN
from coopenv.physics.world import World

SUBSTEP = 0.025  # [s]
MASS, INERTIA = 25.0, 4.17  # [kg], [kg·m²] of the walker
ROOM = Scene(size=(4.0, 4.0))

seeds = st.integers(0, 2**32 - 1)


def energy(twist):
    return (MASS * (twist[0] ** 2 + twist[1] ** 2) + INERTIA * twist[2] ** 2) / 2


def collected(expected, reported, *, wheels):
    """Twist and impulse after a substep, of which pymunk ``reported`` pose and twist.

    ``expected`` is twist and pose without contact.
    """
    one = np.ones(1)
    table = coefficients(
        MASS * one, INERTIA * one, 0 * one, 0 * one, SUBSTEP, np.array([wheels]), one
    )
    pose, twist, impulse, shift = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1), np.zeros(1)
    rows, rooms = np.zeros(1, dtype=np.int64), np.array([[0.0, 0.0, 9.0, 9.0]])
    collect.collect(
        rows, table, rooms, np.array([reported]), np.array([expected]),
        pose, twist, impulse, shift, np.zeros((1, NUM_GIVEN)), True,
    )  # fmt: skip
    return twist[0], impulse[0]


def test_a_contact_that_is_over_neither_holds_nor_drags_a_body_that_touches_again():
    body = Body.beam(length=1.0, width=1.0, mass=1.0, linear_drag=0.0, friction=1.0)
    one = World([body], [ROOM], dt=SUBSTEP, substeps=1)
    one.place(np.array([0]), np.array([[1.499, 0.0, 0.0]]))
    one.twist = np.array([[1.0, 0.5, 0.0]])
    one.step(np.zeros((1, 3)))  # against the wall, and along it
    assert one.contact_impulse[0] > 1.0
    one.twist = np.array([[-2.0, 0.0, 0.0]])
    one.step(np.zeros((1, 3)))  # off it
    assert one.contact_impulse[0] == 0.0
    # Into it again, but pushed so that it is on its way off when it touches.
    leaving, depth = -0.2, 1.505 - one.pose[0, 0]  # [m/s], [m]
    coming = 2 * depth / SUBSTEP - leaving
    one.twist = np.array([[coming, 0.0, 0.0]])
    one.step(np.array([[(leaving - coming) / SUBSTEP, 0.0, 0.0]]))
    assert one.pose[0, 0] == pytest.approx(1.505)
    np.testing.assert_allclose(one.twist[0], [leaving, 0.0, 0.0], rtol=0, atol=1e-12)
    assert one.contact_impulse[0] == 0.0


@settings(max_examples=200, deadline=None)
@given(seeds)
def test_whatever_part_of_a_change_is_taken_adds_no_energy(seed):
    generator = np.random.default_rng(seed)
    before, change = generator.normal(size=(2, 3)) * 10.0 ** generator.uniform(-6, 3, (2, 1))
    part = contacts.spent(MASS, INERTIA, tuple(before), tuple(change))
    assert 0.0 <= part <= 1.0
    assert energy(before + part * change) <= energy(before) * (1 + 1e-12)
    if energy(before + change) <= energy(before):
        assert part == 1.0


def test_a_change_that_adds_energy_is_taken_as_far_as_it_takes_most():
    before, change = np.array([0.3, 0.0, 0.0]), np.array([-1.0, 0.2, 0.4])
    part = contacts.spent(MASS, INERTIA, tuple(before), tuple(change))
    left = [energy(before + other * change) for other in np.linspace(0, 1, 1001)]
    assert energy(before + part * change) == pytest.approx(min(left), rel=1e-4)
    assert contacts.spent(MASS, INERTIA, (1.0, 0.0, 0.0), (0.1, 5.0, 0.0)) == 0.0


@settings(max_examples=200, deadline=None)
@given(seeds)
def test_an_impact_that_stops_a_contact_is_taken_whole(seed):
    generator = np.random.default_rng(seed)
    before, arm = generator.normal(size=3), generator.uniform(-1, 1, 2)
    direction = generator.uniform(-np.pi, np.pi)
    normal = np.array([np.cos(direction), np.sin(direction)])
    lever = arm[0] * normal[1] - arm[1] * normal[0]
    give = 1 / MASS + lever**2 / INERTIA  # [1/kg]
    push = -(before[:2] @ normal + lever * before[2]) / give  # [N·s]
    change = np.array([*(normal * push / MASS), lever * push / INERTIA])
    assert contacts.spent(MASS, INERTIA, tuple(before), tuple(change)) == 1.0


def test_impulses_that_the_solver_did_not_take_back_give_a_free_body_no_energy():
    expected = [0.5, 0.0, 0.1, 1.0, 0.0, 0.0]  # twist, pose
    twist, impulse = collected(expected, [1.0, 0.0, 0.0, 0.6, 0.0, 0.1], wheels=False)
    np.testing.assert_array_equal(twist, expected[:3])
    assert impulse == 0.0
    # Bounced back faster than it came, it is stopped, and the impulse is what stops it.
    twist, impulse = collected([0.5, 0, 0, 1, 0, 0], [1.0, 0, 0, -0.6, 0, 0], wheels=False)
    np.testing.assert_allclose(twist, 0.0, atol=1e-15)
    assert impulse == pytest.approx(MASS * 0.5)


def test_a_body_on_wheels_gains_no_energy_where_the_parting_of_overlaps_turned_it():
    # It rolls along x. Turned by 0.01 rad, it seems to slip, and a box at its side stops that.
    speed, turned = 0.3, 0.01
    arm, normal = np.array([0.3, -0.5]), np.array([np.sin(turned), -np.cos(turned)])
    before = np.array([speed, 0.0, 0.0])
    lever = arm[0] * normal[1] - arm[1] * normal[0]
    give = 1 / MASS + lever**2 / INERTIA
    push = -(before[:2] @ normal + lever * before[2]) / give
    after = before + np.array([*(normal * push / MASS), lever * push / INERTIA])
    assert energy(after) < energy(before)  # of a free body
    twist, _ = collected([*before, 1, 0, 0], [1.0, 0.0, turned, *after], wheels=True)
    assert energy(twist) <= energy(before)


@settings(max_examples=200, deadline=None)
@given(seeds)
def test_no_contact_gives_energy_to_a_body_on_wheels(seed):
    generator = np.random.default_rng(seed)
    heading, turned = generator.uniform(-np.pi, np.pi), generator.uniform(-0.05, 0.05)
    speed, spin = generator.normal(size=2)
    before = np.array([speed * np.cos(heading), speed * np.sin(heading), spin])
    change = generator.normal(size=3) * 10.0 ** generator.uniform(-3, 0)
    after = before + contacts.spent(MASS, INERTIA, tuple(before), tuple(change)) * change
    reported = [1.0, 0.0, heading + turned, *after]
    twist, _ = collected([*before, 1.0, 0.0, heading], reported, wheels=True)
    assert energy(twist) <= energy(before) * (1 + 1e-12)


@pytest.mark.parametrize("body", [Body(), Body.walker()], ids=["beam", "walker"])
def test_a_control_step_is_its_substeps_one_by_one_to_the_bit_also_in_contact(body):
    generator = np.random.default_rng(5)
    whole = World([body] * 8, [ROOM] * 8, dt=2 * SUBSTEP, substeps=2)
    parts = World([body] * 8, [ROOM] * 8, dt=SUBSTEP, substeps=1)
    touched = 0
    for _ in range(40):
        wrench = generator.uniform(-60, 60, (8, 3))
        for _ in range(3):
            whole.step(wrench)
            for _ in range(whole.substeps):
                parts.step(wrench)
            np.testing.assert_array_equal(whole.pose, parts.pose)
            np.testing.assert_array_equal(whole.twist, parts.twist)
            touched += np.count_nonzero(whole.contact_impulse)
    assert touched > 40


def test_what_wheels_hold_does_not_give_way_at_all():
    # All of the change is across the heading and none of it turns: nothing is left to give way.
    assert contacts.yielded(MASS, INERTIA, 0.0, 0.3, -0.4, 0.0) == (0.0, 0.0, 1.0)
    assert contacts.yielded(MASS, INERTIA, 0.0, 0.0, 0.0, 0.0) == (0.0, 0.0, 1.0)
    # Of ‖Δ‖² = 0.25 a millionth may be along; a little more gives way, by what stops the contact.
    held, free = np.sqrt(0.9e-6 * 0.25), np.sqrt(4e-6 * 0.25)
    assert contacts.yielded(MASS, INERTIA, held, 0.3, -0.4, 0.0) == (0.0, 0.0, 1.0)
    along, spin, factor = contacts.yielded(MASS, INERTIA, free, 0.3, -0.4, 0.0)
    assert (along, spin, factor) == pytest.approx((250_000 * free, 0.0, 250_000))


def test_what_gives_way_by_hand():
    # Free: 2 (0.09 + 0.16) + 4 · 0.25 = 1.5; on wheels 2 · 0.04 + 1 = 1.08.
    along, spin, factor = contacts.yielded(2.0, 4.0, -0.2, 0.3, 0.4, 0.5)
    assert factor == pytest.approx(1.5 / 1.08)
    assert (along, spin) == pytest.approx((-0.2 * factor, 0.5 * factor))
    # ⟨v, Δ⟩ = 2 (0.3 − 2) − 4 · 0.5 = −5.4; half of ⟨Δ, Δ⟩ = 2 (0.25 + 4) + 4 = 12.5 is more.
    before = (0.6, 1.0, 0.5)
    assert contacts.spent(2.0, 4.0, before, (0.5, -2.0, -1.0)) == pytest.approx(5.4 / 12.5)
    # 2 (0.3 − 2) = −3.4; half of 2 (0.25 + 4) + 4 · 0.01 is more: spins count with the inertia.
    assert contacts.spent(2.0, 4.0, (0.6, 1.0, 0.0), (0.5, -2.0, 0.1)) == pytest.approx(3.4 / 8.54)


def test_held_wheels_let_a_push_at_their_side_pass_into_the_wall():
    expected = [0.5, 0.0, 0.0, 1.0, 2.0, 0.0]  # rolls along x
    twist, impulse = collected(expected, [1.0, 2.0, 0.0, 0.5, -0.3, 0.0], wheels=True)
    np.testing.assert_allclose(twist, [0.5, 0.0, 0.0], rtol=0, atol=1e-12)
    assert impulse == pytest.approx(MASS * 0.3)
