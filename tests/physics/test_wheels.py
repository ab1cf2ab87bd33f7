"""Bodies on wheels: their exact motion, and what contacts do to them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from coopenv import Body, Box, Scene, Transport
from coopenv.errors import InvalidInput
from coopenv.physics import contacts, motion
from coopenv.physics.coefficients import coefficients
from coopenv.physics.world import World
from tests.helpers import OPEN_ROOM

WALKER = Body.walker()
LIGHT = Body.walker(mass=8.0, inertia=0.5, linear_drag=6.0, angular_drag=2.0)
DT = 0.05  # [s]


def placed(*pose, body=WALKER, scene=OPEN_ROOM, substeps=2):
    one = World([body], [scene], dt=DT, substeps=substeps)
    one.place(np.array([0]), np.array([pose], dtype=float))
    return one


def walker_table():
    """The walker's coefficient table, substeps of 25 ms."""
    mass, inertia, drag, angular_drag = (np.array([v]) for v in (25.0, 4.17, 1.0, 100.0))
    return coefficients(mass, inertia, drag, angular_drag, 0.025, np.array([True]))


def slip(pose, twist):
    """Sideways speed ``(world,)`` [m/s]."""
    return np.cos(pose[:, 2]) * twist[:, 1] - np.sin(pose[:, 2]) * twist[:, 0]


def rolled(body, wrench, seconds, *, start=(0.0, 0.0, 0.0), speed=0.0, spin=0.0):
    """Pose and twist at the end, by a tight numerical solution of the constrained motion."""
    force, _, torque = wrench

    def rate(_, state):
        angle, u, w = state[2:]
        forward = (force - body.linear_drag * u) / body.mass
        turning = (torque - body.angular_drag * w) / body.inertia
        return u * np.cos(angle), u * np.sin(angle), w, forward, turning

    begin = [*start, speed, spin]
    x, y, angle, u, w = solve_ivp(
        rate, (0, seconds), begin, "DOP853", rtol=3e-14, atol=1e-14, max_step=0.05
    ).y[:, -1]
    return np.array([x, y, angle, u * np.cos(angle), u * np.sin(angle), w])


@pytest.mark.parametrize("body", [WALKER, LIGHT], ids=["walker", "light"])
@pytest.mark.parametrize("substeps", [1, 2, 5])
@pytest.mark.parametrize("wrench", [(15.0, 0.0, 60.0), (-20.0, 7.0, -3.0), (4.0, -50.0, 0.0)])
def test_a_held_wrench_drives_it_as_the_constrained_equations_of_motion_say(body, substeps, wrench):
    if body is LIGHT:
        wrench = wrench[0], wrench[1], wrench[2] / 30
    one = placed(0.5, -1.0, 0.7, body=body, substeps=substeps)
    for _ in range(80):
        one.step(np.array([wrench]))
    wanted = rolled(body, wrench, 4.0, start=(0.5, -1.0, 0.7))
    np.testing.assert_allclose([*one.pose[0], *one.twist[0]], wanted, rtol=0, atol=1e-9)


def test_at_its_terminal_speed_and_spin_it_goes_round_the_analytic_arc():
    force, torque = 1.2, 40.0
    u, w = force / WALKER.linear_drag, torque / WALKER.angular_drag  # 1.2 m/s, 0.4 rad/s
    table = walker_table()
    x, y, angle, vx, vy, spin = 0.0, 0.0, 0.3, u * np.cos(0.3), u * np.sin(0.3), w
    for _ in range(400):  # 10 s
        dx, dy, turn, vx, vy, spin = motion.roll(
            table, 0, motion.Motion(angle, vx, vy, spin, force, 0.0, torque)
        )
        x, y, angle = x + dx, y + dy, angle + turn
    end = 0.3 + 10 * w
    arc = u / w * np.array([np.sin(end) - np.sin(0.3), np.cos(0.3) - np.cos(end)])
    np.testing.assert_allclose([x, y, angle], [*arc, end], rtol=0, atol=1e-10)
    np.testing.assert_allclose([vx, vy, spin], [u * np.cos(end), u * np.sin(end), w], atol=1e-12)


def test_from_rest_it_follows_the_integral_of_its_closed_form_speed_and_angle():
    force, torque, seconds = 12.0, 70.0, 3.0
    rate, spin_rate = 1.0 / 25.0, 100.0 / 4.17

    def speed(t):
        return force / 1.0 * -np.expm1(-rate * t)

    def angle(t):
        return torque / 100.0 * (t + np.expm1(-spin_rate * t) / spin_rate)

    def integral(part):
        return quad(lambda t: speed(t) * part(angle(t)), 0, seconds, epsabs=1e-13)[0]

    one = placed(0, 0, 0)
    for _ in range(60):
        one.step(np.array([[force, 0.0, torque]]))
    wanted = [integral(np.cos), integral(np.sin), angle(seconds)]
    np.testing.assert_allclose(one.pose[0], wanted, rtol=0, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_it_never_slips_sideways(seed):
    generator = np.random.default_rng(seed)
    bodies, scene = [WALKER, LIGHT] * 3, Scene(size=(5.0, 5.0))
    many = World(bodies, [scene] * 6, dt=DT, substeps=2)
    many.place(np.arange(6), np.column_stack([generator.uniform(-1, 1, (6, 2)), np.arange(6.0)]))
    for _ in range(6):
        wrench = generator.uniform(-1, 1, (6, 3)) * (30.0, 30.0, 50.0)
        for _ in range(15):  # long enough to run into the walls
            many.step(wrench)
            np.testing.assert_allclose(slip(many.pose, many.twist), 0.0, atol=1e-12)


def test_work_becomes_motion_and_heat():
    one, force, torque = placed(0, 0, 0, substeps=1), 20.0, 80.0
    worked, heat, before = 0.0, 0.0, np.zeros(2)
    rate, spin_rate = 1.0 / 25.0, 100.0 / 4.17
    for _ in range(100):
        one.step(np.array([[force, 0.0, torque]]))
        after = np.array([np.hypot(*one.twist[0, :2]), one.twist[0, 2]])
        # Path and heat of a speed that goes to its limit v + a exp(−k t) within the step.
        for was, limit, decay, drag, push in (
            (before[0], force / 1.0, rate, 1.0, force),
            (before[1], torque / 100.0, spin_rate, 100.0, torque),
        ):
            off, faded = was - limit, -np.expm1(-decay * DT) / decay
            worked += push * (limit * DT + off * faded)
            squares = -np.expm1(-2 * decay * DT) / (2 * decay)
            heat += drag * (limit**2 * DT + 2 * limit * off * faded + off**2 * squares)
        before = after
    motion_energy = 25.0 * before[0] ** 2 / 2 + 4.17 * before[1] ** 2 / 2
    assert worked == pytest.approx(motion_energy + heat, rel=1e-10)


def test_a_force_across_it_only_turns_it():
    core = Transport(body=WALKER, scene=OPEN_ROOM, force_limit=30.0, torque_limit=50.0)
    core.reset(seed=0, pose=(0, 0, 0), goal=(9, 9, 0))
    for _ in range(40):
        core.step([[[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]])
    pose = core.world.pose[0]
    np.testing.assert_array_equal(pose[:2], 0.0)
    # 30 N across the rear handle, 0.5 m behind the wheels, turns it clockwise against the drag.
    assert pose[2] == pytest.approx(-15.0 / 100.0 * (2.0 - 4.17 / 100.0), rel=1e-6)


def test_bodies_with_and_without_wheels_share_a_batch():
    slippery = Body.walker(nonholonomic=False)
    bodies = [WALKER, slippery, LIGHT, Body()]
    wrench = np.tile([10.0, -3.0, 20.0], (40, 4, 1))
    together = World(bodies, [OPEN_ROOM] * 4, dt=DT, substeps=2)
    for held in wrench:
        together.step(held)
    for k, body in enumerate(bodies):
        alone = placed(0, 0, 0, body=body)
        for held in wrench[:, k]:
            alone.step(held[None])
        np.testing.assert_allclose(together.pose[k], alone.pose[0], rtol=0, atol=1e-11)
    sideways = np.abs(slip(together.pose, together.twist))
    assert (sideways[[0, 2]] < 1e-12).all()
    assert (sideways[[1, 3]] > 0.1).all()


def test_a_world_changes_to_wheels_when_it_is_furnished_so():
    one = placed(0, 0, 0, body=Body.walker(nonholonomic=False))
    one.furnish(np.array([0]), [WALKER], [OPEN_ROOM])
    one.place(np.array([0]), np.zeros((1, 3)))
    one.step(np.array([[0.0, 30.0, 0.0]]))
    assert not one.twist.any()


@pytest.mark.parametrize("substeps", [1, 2, 10])
def test_driven_head_on_at_a_wall_it_stops_and_hands_over_its_momentum(substeps):
    one = placed(0, 0, 0, scene=Scene(size=(4.0, 4.0)), substeps=substeps)
    for _ in range(30):
        one.step(np.array([[10.0, 0.0, 0.0]]))
    momentum, given_up, begun = 25.0 * one.twist[0, 0], 0.0, one.pose[0, 0]
    for _ in range(60):
        one.step(np.zeros((1, 3)))
        given_up += one.contact_impulse[0]
    drag = 1.0 * (one.pose[0, 0] - begun)
    assert given_up == pytest.approx(momentum - drag, rel=5e-3)
    np.testing.assert_allclose(one.twist[0], 0.0, atol=5e-4)  # what the solver leaves
    assert one.pose[0, 0] == pytest.approx(1.5, abs=5e-3)


@pytest.mark.parametrize("angle", [0.2, 0.5, 1.0, 1.4])
def test_driven_at_an_angle_it_neither_enters_the_wall_nor_gains_energy(angle):
    one = placed(0, 0, angle, scene=Scene(size=(40.0, 4.0)))
    for _ in range(40):  # up to about 1.5 m/s; the front corner meets the wall with it
        one.step(np.array([[20.0, 0.0, 0.0]]))
    energies, outside = [], []
    c, s = np.cos, np.sin
    for _ in range(150):
        one.step(np.zeros((1, 3)))
        vx, vy, spin = one.twist[0]
        energies.append(12.5 * (vx * vx + vy * vy) + 4.17 / 2 * spin * spin)
        heading = one.pose[0, 2]
        reach = 0.5 * (abs(s(heading)) + abs(c(heading)))
        outside.append(one.pose[0, 1] + reach - 2.0)
    assert (np.diff(energies) < 1e-9).all()
    assert max(outside) < 0.05  # what a substep of its speed sinks in
    assert outside[-1] < 5e-3


def test_a_box_at_its_side_cannot_be_felt_while_it_rolls_past():
    beside = Scene(size=(20.0, 8.0), obstacles=(Box(center=(3.0, 1.02), size=(1.0, 1.0)),))
    free, passing = placed(0, 0, 0), placed(0, 0, 0, scene=beside)
    for _ in range(120):
        for one in (free, passing):
            one.step(np.array([[10.0, 0.0, 0.0]]))
    assert passing.contact_impulse[0] == 0.0
    np.testing.assert_allclose(passing.pose, free.pose, atol=1e-9)


def test_contacts_of_a_rolling_body_take_the_approach_out_of_it():
    # A free body's answer to a frictionless impulse P at r is (P/m, r × P / J). Scaled for wheels,
    # the contact point must lose the same normal velocity.
    generator = np.random.default_rng(3)
    for _ in range(200):
        heading, direction = generator.uniform(-np.pi, np.pi, 2)
        arm, normal = (
            generator.uniform(-0.7, 0.7, 2),
            np.array([np.cos(direction), np.sin(direction)]),
        )
        lever = arm[0] * normal[1] - arm[1] * normal[0]
        free = np.array([*(normal / 25.0), lever / 4.17])
        forward = np.array([np.cos(heading), np.sin(heading)])
        along, spin, factor = contacts.yielded(25.0, 4.17, forward @ free[:2], *free)
        lost = free[:2] @ normal + lever * free[2]
        assert along * (normal @ forward) + lever * spin == pytest.approx(lost, rel=1e-9)
        assert factor >= 1.0


def test_only_a_truth_value_puts_a_body_on_wheels():
    with pytest.raises(InvalidInput, match=r"body\.nonholonomic must be True or False, got 'no'"):
        Body(nonholonomic="no")  # pyright: ignore[reportArgumentType]
