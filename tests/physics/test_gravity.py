"""Gravity in the plane: free fall as calculus says, rest that is rest, no energy from contacts."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coopenv import Body, Box, Scene, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.physics.shard import COLLISION_SLOP
from coopenv.physics.world import SHARD_SIZE, World

G = 9.81  # [m/s²]
DT = 0.05  # [s]
UPRIGHT = Scene(size=(8.0, 5.0), gravity=(0.0, -G))
FLOOR = -2.5  # [m]


def placed(*pose, body=None, scene=UPRIGHT, substeps=2, twist=(0.0, 0.0, 0.0)):
    one = World([body or Body()], [scene], dt=DT, substeps=substeps)
    one.place(np.array([0]), np.array([pose], dtype=float))
    one.twist = np.array([twist], dtype=float)
    return one


def after(one, steps, wrench=(0.0, 0.0, 0.0)):
    for _ in range(steps):
        one.step(np.array([wrench], dtype=float))
    return one.pose[0], one.twist[0]


def potential(world):
    """Kinetic and potential energy over the floor ``(world,)`` [J]."""
    mass = np.array([body.mass for body in world.bodies])
    inertia = np.array([body.inertia for body in world.bodies])
    vx, vy, spin = world.twist.T
    height = world.pose[:, 1] - FLOOR
    return mass * (vx**2 + vy**2) / 2 + inertia * spin**2 / 2 + mass * G * height


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_body_falls_on_its_parabola(substeps):
    free = Body(linear_drag=0.0, angular_drag=0.0)
    hall = Scene(size=(90.0, 90.0), gravity=(1.5, -G))
    one = placed(0, 30, 0.3, body=free, scene=hall, substeps=substeps, twist=(2.0, 1.0, 0.5))
    pose, twist = after(one, 40)
    np.testing.assert_allclose(pose, [2 * 2 + 1.5 * 2, 30 + 2 - G * 2, 0.3 + 1.0], atol=1e-11)
    np.testing.assert_allclose(twist, [2 + 1.5 * 2, 1 - 2 * G, 0.5], atol=1e-11)


def test_under_drag_a_body_comes_to_the_speed_at_which_drag_bears_it():
    body = Body(mass=2.0, linear_drag=8.0)
    _, twist = after(placed(0, 70, 0, body=body, scene=Scene(size=(9, 150), gravity=(0, -G))), 100)
    assert twist[1] == pytest.approx(-2.0 * G / 8.0, abs=1e-7)


def test_gravity_and_a_wrench_together_agree_with_a_tight_numerical_solution():
    body, force, torque = Body(), np.array([20.0, 60.0]), 3.0

    def rate(_, state):
        angle, vx, vy, spin = state[2:]
        c, s = np.cos(angle), np.sin(angle)
        ax = (c * force[0] - s * force[1] - body.linear_drag * vx) / body.mass
        ay = (s * force[0] + c * force[1] - body.linear_drag * vy) / body.mass - G
        return vx, vy, spin, ax, ay, (torque - body.angular_drag * spin) / body.inertia

    begin = [0.5, 1.0, 0.2, 0.3, -0.1, 0.4]
    wanted = solve_ivp(rate, (0, 1.5), begin, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    one = placed(*begin[:3], twist=begin[3:], scene=Scene(size=(90.0, 90.0), gravity=(0.0, -G)))
    pose, twist = after(one, 30, (*force, torque))
    np.testing.assert_allclose([*pose, *twist], wanted, atol=1e-8)


@pytest.mark.parametrize(("substeps", "steps"), [(1, 1000), (2, 10_000), (5, 1000)])
def test_a_body_that_rests_on_the_floor_rests_for_ten_thousand_steps(substeps, steps):
    one = placed(0.3, FLOOR + 0.05, 0.0, substeps=substeps)
    pose, _ = after(one, 500)
    later, twist = after(one, steps)
    assert np.abs(twist).max() < 1e-9
    assert np.abs(later - pose).max() < 1e-9
    overlap = FLOOR - (later[1] - 0.05)
    assert 0 <= overlap <= COLLISION_SLOP * 1.0001
    assert one.contact_impulse[0] == pytest.approx(one.bodies[0].mass * G * DT, rel=0.05)
    assert one.contact_shift[0] < 1e-9


def test_a_slope_holds_a_body_by_friction_or_lets_it_slide_by_coulombs_law():
    # The floor is level and gravity leans: by 20°, whose tangent is 0.364.
    lean = np.radians(20)
    slope = Scene(size=(60.0, 5.0), gravity=(G * np.sin(lean), -G * np.cos(lean)))
    rough = Body(friction=0.5, linear_drag=0.0, angular_drag=0.0)
    one = placed(-20, FLOOR + 0.049, 0, body=rough, scene=slope)
    at, _ = after(one, 200)
    later, twist = after(one, 500)
    assert np.abs(twist).max() < 1e-9
    assert at[0] == pytest.approx(-20, abs=2e-3)
    np.testing.assert_allclose(later, at, atol=1e-9)
    smooth = Body(friction=0.2, linear_drag=0.0, angular_drag=0.0)
    _, twist = after(placed(-20, FLOOR + 0.049, 0, body=smooth, scene=slope), 40)
    wanted = 2.0 * G * (np.sin(lean) - 0.2 * np.cos(lean))
    assert twist[0] == pytest.approx(wanted, rel=0.01)


def test_a_body_pushed_over_an_edge_falls_off_it():
    shelf = Scene(size=(8, 5), gravity=(0, -G), obstacles=(Box(center=(-2, -2), size=(4, 1)),))
    one = placed(-0.2, -1.45, 0.0, scene=shelf)
    held, _ = after(one, 100)
    np.testing.assert_allclose(held, [-0.2, -1.451, 0], atol=1e-3)
    pose, _ = after(one, 60, (40.0, 0.0, 0.0))
    pose, twist = after(one, 200)
    assert pose[0] > 1.0
    assert pose[1] == pytest.approx(FLOOR + 0.05, abs=2e-3)
    assert np.abs(twist).max() < 1e-6


@pytest.mark.parametrize(("seed", "substeps"), [(0, 1), (1, 2), (2, 5)])
def test_bodies_that_fall_among_boxes_never_gain_energy_and_come_to_rest(seed, substeps):
    generator, count = np.random.default_rng(seed), 64
    boxes = Box(center=(1.5, -1.5), size=(1, 2)), Box(center=(-2, -2), size=(0.5, 1), angle=0.4)
    bodies = [
        Body.beam(
            length=generator.uniform(0.5, 2), width=generator.uniform(0.05, 0.5),
            mass=generator.uniform(1, 30), friction=generator.uniform(0.1, 2),
            linear_drag=0.0, angular_drag=0.0,
        )
        for _ in range(count)
    ]  # fmt: skip
    scene = Scene(size=(8.0, 5.0), gravity=(0.0, -G), obstacles=boxes)
    worlds = World(bodies, [scene] * count, dt=DT, substeps=substeps)
    place = np.column_stack(
        [generator.uniform(-2.5, 2.5, count), generator.uniform(0.6, 1.3, count)]
    )
    worlds.place(np.arange(count), np.column_stack([place, generator.uniform(-3, 3, count)]))
    worlds.twist = generator.normal(0, 1, (count, 3))
    start = before = potential(worlds)
    for _ in range(300):
        worlds.step(np.zeros((count, 3)))
        energy = potential(worlds)
        weight = np.array([body.mass for body in bodies]) * G
        # What the parting of overlaps lifts, an impact paid for while it sank in.
        assert (energy - before <= weight * worlds.contact_shift + 0.005 * start).all()
        assert (energy <= start * (1 + 1e-12)).all()
        before = energy
    assert np.abs(worlds.twist).max() < 1e-6


def test_a_world_with_weight_leaves_worlds_without_alone():
    count = 8
    generator = np.random.default_rng(3)
    pose = np.column_stack([generator.uniform(-1.5, 1.5, (count, 2)), np.zeros(count)])
    level = Scene(size=(8.0, 5.0))
    alone = World([Body()] * count, [level] * count, dt=DT, substeps=2)
    mixed = World([Body()] * count, [level, UPRIGHT] * (count // 2), dt=DT, substeps=2)
    for worlds in (alone, mixed):
        worlds.place(np.arange(count), pose)
    for _ in range(200):
        wrench = np.repeat(generator.uniform(-40, 40, (count, 1)), 3, axis=1)
        for worlds in (alone, mixed):
            worlds.step(wrench)
    np.testing.assert_allclose(mixed.pose[::2], alone.pose[::2], atol=1e-9)
    assert count < SHARD_SIZE  # both are of one space


def test_a_body_placed_anew_does_not_remember_what_bore_it():
    one, fresh = placed(0, FLOOR + 0.05, 0), placed(1, 1.0, 0.2)
    after(one, 50)
    one.place(np.array([0]), np.array([[1.0, 1.0, 0.2]]))
    for worlds in (one, fresh):
        after(worlds, 5)
    np.testing.assert_array_equal(one.pose, fresh.pose)
    np.testing.assert_array_equal(one.twist, fresh.twist)


def test_what_bears_a_body_goes_with_its_state_into_any_space():
    count = SHARD_SIZE + 2
    bodies, scenes = [Body()] * count, [UPRIGHT] * count
    many = World(bodies, scenes, dt=DT, substeps=2)
    height = np.where(np.arange(count) % 2, FLOOR + 0.05, 1.0)  # every other one falls first
    many.place(np.arange(count), np.column_stack([0 * height, height, 0 * height]))
    for _ in range(60):
        many.step(np.zeros((count, 3)))
    begin, last = np.array([1, 0]), np.array([count - 1, 3])
    state = many.get_state(last)
    for _ in range(50):
        many.set_state(state, begin, [Body()] * 2, [UPRIGHT] * 2, anew=False)
        many.step(np.zeros((count, 3)))
        state = many.get_state(begin)
    np.testing.assert_allclose(many.pose[begin], many.pose[last], atol=1e-6)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"gravity": -9.81},
            r"scene\.gravity must be two numbers, got -9\.81; pass \(x, y\) in m/s²",
        ),
        ({"gravity": (0.0, np.nan)}, r"scene\.gravity must be finite"),
        ({"gravity": (0.0, -1e7)}, r"scene\.gravity must be within 1e\+06 m/s²"),
        ({"normal_gravity": -1.0}, r"scene\.normal_gravity must be zero or positive"),
    ],
)
def test_a_gravity_that_breaks_its_rule_is_refused(values, message):
    with pytest.raises(InvalidInput, match=message):
        Scene(**values)


def test_a_body_on_wheels_is_refused_in_an_upright_plane():
    with pytest.raises(InvalidInput, match=r"scene\.gravity must be \(0, 0\) for a body on wheels"):
        TransportConfig(body=Body.walker(), scene=UPRIGHT)
