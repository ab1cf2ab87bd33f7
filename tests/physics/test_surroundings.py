"""What surroundings give: all momentum is accounted for, as pymunk solved, and at its place."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp

from coopenv import Body, Box, Hands, Scene
from coopenv.physics.surroundings import WHEEL, acting
from coopenv.physics.world import World
from tests.helpers import OPEN_ROOM
from tests.physics.held import Held

DT = 0.02  # [s]
NARROW = Scene(size=(3.0, 2.6), obstacles=(Box(center=(0.9, 0.9), size=(0.5, 0.4)),))
WALKER = Body.walker(linear_drag=6.0, angular_drag=3.0, inertia=2.0)
NODES, WEIGHTS = leggauss(24)


def worlds(bodies, scene, *, substeps=1, dt=DT, seed=0):
    """Bodies near the middle, each with its own twist."""
    made = World(bodies, [scene] * len(bodies), dt=dt, substeps=substeps)
    random = np.random.default_rng(seed)
    made.place(np.arange(len(bodies)), random.uniform(-0.1, 0.1, (len(bodies), 3)))
    return made, random


def turned_impulse(body, angle, spin, wrench, time):
    """∫ R(θ) f dt of a force held in the object frame, by quadrature of the free turn."""
    rate = body.angular_drag / body.inertia
    at = time * (1 + NODES) / 2
    coasted = -np.expm1(-rate * at) / rate if rate else at
    pushed = (at - coasted) / rate if rate else at**2 / 2
    angle = angle + coasted * spin + pushed * wrench[2] / body.inertia
    x = (np.cos(angle) * wrench[0] - np.sin(angle) * wrench[1]) @ WEIGHTS
    y = (np.sin(angle) * wrench[0] + np.cos(angle) * wrench[1]) @ WEIGHTS
    return np.array([x, y]) * time / 2


def rotated(angle, vector):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (0.0, -9.81)], ids=["flat", "upright"])
@pytest.mark.parametrize("friction", [0.0, 0.8])
def test_agents_surroundings_weight_and_drag_explain_every_change_of_momentum(gravity, friction):
    scene = Scene(size=NARROW.size, obstacles=NARROW.obstacles, gravity=gravity, friction=friction)
    bodies = [
        Body.beam(length=1.2, mass=3.0, linear_drag=drag, angular_drag=drag / 2, friction=0.7)
        for drag in (0.0, 5.0, 40.0)
    ]
    many, random = worlds(bodies, scene)
    touched, wrench = 0, np.zeros((3, 3))
    for step in range(300):
        if step % 20 == 0:
            wrench = random.uniform(-1, 1, (3, 3)) * [40, 40, 8]
        pose, twist = many.pose, many.twist
        many.step(wrench)
        for k, body in enumerate(bodies):
            gave = DT * many.given[k]
            impulse = turned_impulse(body, pose[k, 2], twist[k, 2], wrench[k], DT)
            impulse += rotated(many.pose[k, 2], gave) + body.mass * DT * np.array(gravity)
            impulse -= body.linear_drag * (many.pose - pose)[k, :2]
            change = body.mass * (many.twist - twist)[k, :2]
            np.testing.assert_allclose(change, impulse, rtol=0, atol=1e-8)  # of the motion
            angular = DT * wrench[k, 2] + gave[2] - body.angular_drag * (many.pose - pose)[k, 2]
            assert body.inertia is not None
            turned = body.inertia * (many.twist - twist)[k, 2]
            np.testing.assert_allclose(turned, angular, rtol=0, atol=1e-10)
            touched += bool(gave.any())
            assert many.given[k, WHEEL] == 0.0
    assert 200 < touched < 900


def test_the_mean_of_a_step_is_that_of_its_substeps():
    """As long as none is under way a body does not know where its control step ends."""
    bodies = [Body.beam(length=1.2), WALKER]
    whole, random = worlds(bodies, NARROW, substeps=4, dt=4 * DT)
    parts, _ = worlds(bodies, NARROW)
    touched = 0
    for _ in range(80):
        wrench = random.uniform(-1, 1, (2, 3)) * [60, 60, 10]
        whole.step(wrench)
        gave = []
        for _ in range(4):
            parts.step(wrench)
            gave.append(parts.given)
        np.testing.assert_allclose(whole.given, np.mean(gave, axis=0), rtol=1e-9, atol=1e-9)
        touched += np.any(whole.contact_impulse)
    assert touched > 10


def test_contacts_give_what_pymunk_solved_at_the_place_where_it_did():
    """Of a contact of one point: its impulse, its moment, and the point itself."""
    body = Body.beam(length=1.2, mass=3.0, linear_drag=0.0, angular_drag=0.0, friction=0.7)
    one, random = worlds([body], Scene(size=NARROW.size, friction=0.5))
    (moving,) = (each for each in one.spaces[0].bodies)
    outline = np.array([body.outline])

    def keep(arbiter, impulses):
        impulses.append((arbiter.total_impulse, arbiter.contact_point_set))

    single, wrench = 0, np.zeros((1, 3))
    for _ in range(400):
        if random.random() < 0.1:
            wrench = random.uniform(-1, 1, (1, 3)) * [40, 40, 8]
        one.step(wrench)
        impulses = []
        moving.each_arbiter(keep, impulses)
        total = np.sum([np.zeros(2), *(np.array(each) for each, _ in impulses)], axis=0)
        gave = DT * rotated(one.pose[0, 2], one.given[0])
        # pymunk's sign is that of the first shape of the pair, which may be the wall's.
        assert min(np.linalg.norm(gave - total), np.linalg.norm(gave + total)) < 1e-9
        if len(impulses) == 1 and len(impulses[0][1].points) == 1 and np.linalg.norm(total) > 1e-3:
            (point,) = impulses[0][1].points
            place = rotated(one.pose[0, 2], acting(one.given[:, :3], np.zeros(1), outline)[1][0])
            ends = np.array([point.point_a, point.point_b]) - one.pose[0, :2]  # apart by overlap
            assert min(np.linalg.norm(ends - place, axis=1)) < 0.01
            single += 1
    assert single > 30


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_what_rests_is_borne_with_its_weight_and_what_else_presses_on_it(substeps):
    """Not but for the drag of a substep's fall: a body that rests meets none."""
    body = Body(mass=4.0)
    scene = Scene(size=(8.0, 5.0), gravity=(0.0, -9.81))
    one = World([body], [scene], dt=DT, substeps=substeps)
    one.place(np.array([0]), np.array([[0.0, -2.45, 0.0]]))
    for _ in range(150):
        one.step(np.array([[0.0, 3.0, 2.0]]))
    wanted = [4.0 * 9.81 - 3.0, -2.0, 0.0]
    np.testing.assert_allclose(one.given[0, 1:], wanted, rtol=0, atol=1e-6)
    assert abs(one.given[0, 0]) < 5e-3  # by friction, while the contact settles


def test_a_body_pressed_against_a_wall_is_held_with_just_that():
    body = Body.beam()
    one = World([body], [Scene(size=(6.0, 6.0))], dt=DT, substeps=2)
    one.place(np.array([0]), np.array([[2.9, 0.0, np.pi / 2]]))
    for _ in range(400):
        one.step(np.array([[0.0, -20.0, 6.0]]))
    np.testing.assert_allclose(one.given[0, 1:], [20.0, -6.0, 0.0], rtol=0, atol=1e-6)
    assert abs(one.given[0, 0]) < 5e-3  # by friction, while the contact settles
    there, place = acting(one.given[:, :3], one.given[:, WHEEL], np.array([body.outline]))
    np.testing.assert_array_equal(there[0, 2], 0.0)
    np.testing.assert_allclose(place[0], [-0.3, -0.05], atol=1e-4)  # the centre of pressure


def test_a_wall_without_friction_gives_only_what_is_across_it():
    body = Body.beam(friction=0.0)
    one = World([body], [Scene(size=(20.0, 6.0))], dt=DT, substeps=2)
    one.place(np.array([0]), np.array([[-8.0, 2.95, 0.0]]))
    slid = 0
    for _ in range(200):
        one.step(np.array([[15.0, 12.0, 0.0]]))
        slid += one.given[0, 1] != 0.0
        assert abs(one.given[0, 0]) < 1e-6
    assert slid > 150
    assert one.twist[0, 0] > 1.0
    np.testing.assert_allclose(one.given[0, 1:3], [-12.0, 0.0], atol=1e-5)


def test_nothing_touched_is_exactly_nothing():
    many, random = worlds([Body.beam(), Body(linear_drag=0.0), WALKER], OPEN_ROOM, substeps=3)
    wrench = np.zeros((3, 3))
    for _ in range(50):
        wrench = random.uniform(-1, 1, (3, 3)) * 20
        wrench[2, 1:] = 0.0  # the wheels have nothing to hold
        wrench[2, 0] = 5.0
        many.step(wrench)
        assert not many.given[:2].any()
    many.place(np.array([2]), np.zeros((1, 3)))
    for _ in range(10):
        many.step(wrench)
        assert not many.given.any()
    assert many.twist[2, 0] > 0.0


@pytest.mark.parametrize("substeps", [1, 3])
def test_wheels_hold_what_keeps_a_body_on_its_curve(substeps):
    """∫ (m ω u − f_y) dt over the step, by a tight numerical solution of the constrained motion."""
    force, across, torque = 30.0, -12.0, 4.0

    def rate(_, state):
        u, w, _ = state
        forward = (force - WALKER.linear_drag * u) / WALKER.mass
        turning = (torque - WALKER.angular_drag * w) / 2.0
        return forward, turning, WALKER.mass * w * u - across

    one = World([WALKER], [OPEN_ROOM], dt=0.1, substeps=substeps)
    one.place(np.array([0]), np.array([[0.0, 0.0, 0.4]]))
    state, held = np.zeros(3), 0.0
    for _ in range(12):
        one.step(np.array([[force, across, torque]]))
        before = state[2]
        state = solve_ivp(rate, (0, 0.1), state, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        held = (state[2] - before) / 0.1
        np.testing.assert_allclose(one.given[0], [0, held, 0, held], rtol=0, atol=1e-7)
    assert held > 12.5  # more than what is pushed with: it goes round


@pytest.mark.parametrize("turning", [0.0, 0.6])
def test_wheels_hold_against_hands_as_against_wrenches(turning):
    hands = Hands(stiffness=80.0, damping=10.0, torque_stiffness=8.0, torque_damping=2.0)
    held = Held.of(WALKER, hands, dt=0.002, substeps=1, pose=(0.0, 0.0, 0.3))
    for step in range(250):
        velocity = np.array([0.3, 0.2, turning]) if step < 150 else np.zeros(3)
        held.velocity[0, :, :2] = rotated(held.world.pose[0, 2], velocity)
        held.velocity[0, :, 2] = turning
        before, angle = held.world.twist[0].copy(), held.world.pose[0, 2]
        held.step()
        after, end = held.world.twist[0], held.world.pose[0, 2]
        speeds = np.hypot(*before[:2]), np.hypot(*after[:2])
        assert abs(rotated(-angle, before)[1]) < 1e-12
        assert abs(rotated(-end, after)[1]) < 1e-12
        bent = WALKER.mass * (speeds[0] * before[2] + speeds[1] * after[2]) / 2
        wanted = bent - held.applied[0, :, 1].sum()
        np.testing.assert_allclose(held.world.given[0], [0, wanted, 0, wanted], atol=2e-4)
    assert abs(held.applied[0, :, 1].sum()) > 1.0


def test_what_presses_on_wheels_is_held_by_them():
    """A walker that is pushed along a wall at its side: the wall presses, the wheels press back."""
    body = Body.walker(friction=0.0)
    one = World([body], [Scene(size=(6.0, 2.0))], dt=DT, substeps=2)
    one.place(np.array([0]), np.array([[-1.5, 0.49, 0.03]]))
    pressed = 0
    for _ in range(60):
        before = one.twist[0, 2], one.pose[0, 2]
        one.step(np.array([[40.0, 0.0, 30.0]]))  # turns into the wall
        turned = body.angular_drag * (one.pose[0, 2] - before[1])
        assert body.inertia is not None
        left = body.inertia * (one.twist[0, 2] - before[0]) + turned - 30.0 * DT
        assert one.given[0, 2] * DT == pytest.approx(left, abs=1e-9)
        pressed += bool(one.contact_impulse[0] and one.given[0, WHEEL] > 5.0)
    assert pressed > 10


def convex(random, corners):
    """A convex outline with the centre of mass inside."""
    angle = np.sort((np.arange(corners) + random.uniform(0, 0.8, corners)) * 2 * np.pi / corners)
    return np.stack([np.cos(angle) * 1.3, np.sin(angle) * 0.6], axis=-1)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), corners=st.integers(4, 9), flipped=st.booleans())
def test_a_contact_acts_where_it_touches_and_has_no_torque_of_its_own(seed, corners, flipped):
    random = np.random.default_rng(seed)
    outline = convex(random, corners)
    edge, part = random.integers(corners), random.uniform()
    a, b = outline[edge], outline[(edge + 1) % corners]
    touch = a + part * (b - a)
    inwards = np.array([-(b - a)[1], (b - a)[0]])  # corners go round counter-clockwise
    sliding = random.uniform(-0.9, 0.9) * np.array([inwards[1], -inwards[0]])
    force = random.uniform(0.1, 30) * (inwards + sliding)
    if flipped:
        outline = outline[::-1]
    padded = np.concatenate([outline, outline[-1:], outline[-1:]])  # as a batch has it
    torque = touch[0] * force[1] - touch[1] * force[0]
    there, place = acting(np.array([[*force, torque]]), np.zeros(1), padded[None].copy())
    np.testing.assert_allclose(place[0], touch, atol=1e-9)
    np.testing.assert_array_equal(there[0], [*force, 0.0])


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), wheeled=st.booleans())
def test_at_its_place_it_is_the_same_wrench_and_no_farther_off_than_the_body(seed, wheeled):
    random = np.random.default_rng(seed)
    outline = convex(random, 6)
    wrench = random.normal(size=3) * [10, 10, random.choice([0.1, 5.0, 50.0])]
    wheels = random.normal() * 10 if wheeled else 0.0
    there, place = acting(wrench[None], np.array([wheels]), outline[None])
    (x, y), (fx, fy, torque) = place[0], there[0]
    np.testing.assert_allclose([fx, fy, x * fy - y * fx + torque], wrench, rtol=1e-9, atol=1e-9)
    lever = np.hypot(outline[:, 0], outline[:, 1]).max()
    if torque:  # no force of this direction at the body makes as much
        most = (outline[:, 0] * fy - outline[:, 1] * fx) * np.sign(wrench[2])
        assert most.max() <= abs(wrench[2])
        assert abs(torque) == pytest.approx(abs(wrench[2]) - most.max())
    assert np.hypot(x, y) <= 2 * lever


def test_wheels_hold_at_the_centre_of_mass_and_share_the_place_with_a_contact_continuously():
    outline = np.array([WALKER.outline])
    there, place = acting(np.array([[0.0, -7.0, 0.0]]), np.array([-7.0]), outline)
    assert place.tolist() == [[0.0, 0.0]]
    assert there.tolist() == [[0.0, -7.0, 0.0]]
    touch, press = np.array([0.5, 0.2]), np.array([-6.0, 1.0])  # on the front
    torque = touch[0] * press[1] - touch[1] * press[0]
    for held, near in ((1e-9, touch), (1e9, np.zeros(2))):
        wrench = np.array([[press[0], press[1] + held, torque]])
        _, place = acting(wrench, np.array([held]), outline)
        np.testing.assert_allclose(place[0], near, atol=1e-7)


def test_walls_that_hold_a_body_by_its_ends_give_torque_of_their_own():
    outline = np.array([Body.beam().outline])
    there, place = acting(np.array([[0.0, 0.0, 8.0]]), np.zeros(1), outline)
    assert there.tolist() == [[0.0, 0.0, 8.0]]
    assert place.tolist() == [[0.0, 0.0]]
    there, place = acting(np.array([[0.0, 2.0, 8.0]]), np.zeros(1), outline)
    np.testing.assert_allclose(there, [[0.0, 2.0, 6.0]])
    np.testing.assert_allclose(place[0, 0], 1.0)
