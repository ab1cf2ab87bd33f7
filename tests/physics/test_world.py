"""The physics of many worlds: free motion, walls, and worlds that leave each other alone."""

import pickle

import numpy as np
import pymunk
import pytest
from scipy.integrate import solve_ivp

from coopenv import Body, Box, Scene
from coopenv.errors import BodyLost
from coopenv.physics.scene import WALL_THICKNESS
from coopenv.physics.world import SHARD_SIZE, World
from tests.helpers import CLUTTERED, OPEN_ROOM, corners

DT = 0.05  # [s]
FREE = Body(linear_drag=0.0, angular_drag=0.0, friction=0.0)


def world(body=None, scene=None, *, count=1, substeps=2, dt=DT):
    bodies, scenes = [body or Body()] * count, [scene or Scene()] * count
    return World(bodies, scenes, dt=dt, substeps=substeps)


def placed(*pose, body=None, scene=None, substeps=2):
    one = world(body, scene, substeps=substeps)
    one.place(np.array([0]), np.array([pose], dtype=float))
    return one


def ride(worlds, wrenches):
    """Pose, twist and impulse after every step, ``(step, world, ...)``."""
    seen = []
    for wrench in wrenches:
        worlds.step(wrench)
        seen.append((worlds.pose, worlds.twist, worlds.contact_impulse))
    return tuple(np.array(column) for column in zip(*seen, strict=True))


def knocks(seed, steps, count, strength=40.0):
    """Random wrenches ``(step, world, 3)``, each held for twenty steps."""
    generator = np.random.default_rng(seed)
    held = generator.uniform(-strength, strength, (-(-steps // 20), count, 3))
    return np.repeat(held, 20, axis=0)[:steps]


def strewn(seed, count, *, half=1.9):
    generator = np.random.default_rng(seed)
    place = generator.uniform(-half, half, (count, 2))
    return np.column_stack([place, generator.uniform(-np.pi, np.pi, count)])


def test_a_wrench_held_in_the_object_frame_moves_the_body_as_the_equations_of_motion_say():
    body, force, torque = Body(), (15.0, -8.0), 4.0

    def rate(_, state):
        angle, vx, vy, spin = state[2:]
        c, s = np.cos(angle), np.sin(angle)
        ax = (c * force[0] - s * force[1] - body.linear_drag * vx) / body.mass
        ay = (s * force[0] + c * force[1] - body.linear_drag * vy) / body.mass
        return vx, vy, spin, ax, ay, (torque - body.angular_drag * spin) / body.inertia

    begin = [1.0, -2.0, 0.4, 0.0, 0.0, 0.0]
    wanted = solve_ivp(rate, (0, 3.0), begin, "DOP853", rtol=3e-14, atol=1e-14).y[:, -1]
    one = placed(*begin[:3], scene=OPEN_ROOM, substeps=5)
    ride(one, np.tile([*force, torque], (60, 1, 1)))
    np.testing.assert_allclose([*one.pose[0], *one.twist[0]], wanted, rtol=0, atol=1e-10)


def test_a_pure_force_does_not_turn_the_body_and_a_pure_torque_does_not_move_it():
    pushed, turned = placed(0, 0, 0.3, scene=OPEN_ROOM), placed(0, 0, 0.3, scene=OPEN_ROOM)
    ride(pushed, np.tile([10.0, 5.0, 0.0], (100, 1, 1)))
    ride(turned, np.tile([0.0, 0.0, 5.0], (100, 1, 1)))
    assert (pushed.pose[0, 2], pushed.twist[0, 2]) == (0.3, 0.0)
    np.testing.assert_array_equal(turned.pose[0, :2], 0.0)
    np.testing.assert_array_equal(turned.twist[0, :2], 0.0)


def test_a_body_at_rest_stays_at_rest_to_the_bit():
    many = world(count=5)
    pose = strewn(0, 5)
    many.place(np.arange(5), pose)
    poses, twists, impulses = ride(many, np.zeros((50, 5, 3)))
    np.testing.assert_allclose(poses, np.broadcast_to(pose, poses.shape), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(poses[1:], np.broadcast_to(poses[0], poses[1:].shape))
    assert not twists.any()
    assert not impulses.any()


def test_substeps_do_not_matter_without_contact():
    results = []
    for substeps in (1, 2, 50):
        many = world(scene=OPEN_ROOM, count=8, substeps=substeps)
        ride(many, knocks(3, 100, 8, strength=20.0))
        results.append(np.hstack([many.pose, many.twist]))
    for result in results[:-1]:
        np.testing.assert_allclose(result, results[-1], rtol=0, atol=1e-9)


def test_each_world_has_its_own_mass_inertia_and_drag():
    bodies = [
        Body(),
        Body(mass=2.0),
        Body(inertia=0.5),
        Body(linear_drag=0.0),
        Body(angular_drag=40.0),
        Body.beam(length=1.0),
    ]
    wrench = np.tile([10.0, -3.0, 2.0], (40, len(bodies), 1))
    together = World(bodies, [OPEN_ROOM] * len(bodies), dt=DT, substeps=2)
    ride(together, wrench)
    for k, body in enumerate(bodies):
        alone = world(body, OPEN_ROOM)
        ride(alone, wrench[:, :1])
        np.testing.assert_allclose(together.pose[k], alone.pose[0], rtol=0, atol=1e-11)
    assert len(np.unique(together.pose.round(6), axis=0)) == len(bodies)


def test_the_pose_counts_turns():
    one = placed(0, 0, 0, scene=OPEN_ROOM)
    ride(one, np.tile([0.0, 0.0, 40.0], (100, 1, 1)))
    assert one.pose[0, 2] > 4 * np.pi


@pytest.mark.parametrize(
    "body",
    [
        Body(),
        FREE,
        Body(mass=0.05, linear_drag=3.0, angular_drag=3.0),
        Body(mass=5000.0),
        Body(linear_drag=2000.0, angular_drag=2000.0),
        Body.beam(length=0.1, width=0.01, angular_drag=1.0),
    ],
    ids=["beam", "free", "light", "heavy", "stiff", "small"],
)
@pytest.mark.parametrize("substeps", [1, 2, 20])
def test_the_contact_impulse_is_exactly_zero_without_contact(body, substeps):
    many = world(body, OPEN_ROOM, count=32, substeps=substeps)
    _, _, impulses = ride(many, knocks(7, 60, 32, strength=20.0))
    assert not impulses.any()


@pytest.mark.parametrize(("angle", "across"), [(0.0, 0.05), (np.pi / 2, 1.0)])
@pytest.mark.parametrize("substeps", [1, 2, 10])
def test_a_body_stopped_head_on_hands_its_momentum_to_the_wall(angle, across, substeps):
    one = placed(0.0, 2.5 - across, angle, body=FREE, substeps=substeps)
    push = np.array([[20 * np.sin(angle), 20 * np.cos(angle), 0.0]])  # world +y
    ride(one, [push] * 5)
    momentum = FREE.mass * one.twist[0, 1]
    assert momentum == pytest.approx(20 * 5 * DT)
    _, _, impulses = ride(one, np.zeros((60, 1, 3)))
    assert impulses.sum() == pytest.approx(momentum, rel=1e-2)
    assert abs(one.twist[0, 1]) < 0.01


def test_a_body_leaning_on_a_wall_passes_on_what_it_is_pushed_with():
    push = np.tile([0.0, 40.0, 0.0], (100, 1, 1))
    # Drag takes its part of the momentum gained within a substep: 1.3 % here, nothing without it.
    for body, rel in ((FREE, 1e-6), (Body(), 0.02)):
        leaning = placed(0.0, 2.94, 0.0, body=body)
        _, twists, impulses = ride(leaning, push)
        np.testing.assert_allclose(impulses[-20:], 40.0 * DT, rtol=rel)
        np.testing.assert_allclose(twists[-20:], 0.0, atol=1e-5)


def test_a_grazing_end_gives_an_impulse_and_a_spin():
    one = placed(0.0, 2.0, 0.0, body=FREE)
    one.step(np.array([[0.0, 0.0, 0.0]]))
    _, _, impulses = ride(one, np.tile([0.0, 0.0, 5.0], (60, 1, 1)))
    assert impulses.max() > 0.1


def test_friction_slows_a_body_sliding_along_a_wall():
    slid = []
    for friction in (0.0, 0.8):
        one = placed(-1.5, -2.95, 0.0, body=Body(friction=friction, linear_drag=0.0))
        ride(one, np.tile([10.0, -20.0, 0.0], (20, 1, 1)))
        slid.append(one.pose[0, 0] + 1.5)
    assert slid[0] > 0.5
    assert slid[1] < 0.1  # μ N = 16 N holds the 10 N


@pytest.mark.parametrize("scene", [Scene(), CLUTTERED], ids=["room", "cluttered"])
def test_a_beam_at_full_force_never_leaves_the_room(scene):
    count, steps = 256, 200
    many = world(scene=scene, count=count)
    many.place(np.arange(count), strewn(1, count, half=1.5))
    generator = np.random.default_rng(2)
    direction = generator.uniform(-np.pi, np.pi, (5, count))
    torque = 56.0 * generator.choice([-1.0, 0.0, 1.0], (5, count))
    held = np.stack([40 * np.cos(direction), 40 * np.sin(direction), torque], axis=-1)
    poses, _, impulses = ride(many, np.repeat(held, steps // 5, axis=0))
    outside = np.abs(corners(poses, Body())) - np.array(scene.size) / 2
    assert (impulses.sum(axis=0) > 0).mean() > 0.9  # nearly all hit something
    assert outside.max() < 0.2  # [m] an end in full swing, seen between two substeps
    assert (outside.max(axis=(2, 3)) > 0.05).mean() < 0.05


@pytest.mark.parametrize(("mass", "drag"), [(7.7, 0.0), (1.0, 1.0), (0.5, 0.1)])
def test_a_fast_body_does_not_slip_out_along_the_inside_of_a_wall(mass, drag):
    # At 15 m/s a thin beam is wholly inside a wall before it is first seen to touch it.
    count = 64
    many = world(Body(mass=mass, linear_drag=drag), count=count)
    many.place(np.arange(count), strewn(17, count, half=1.5))
    poses, twists, _ = ride(many, knocks(18, 300, count, strength=1.0) * (20.0, 20.0, 4.0))
    assert np.abs(twists[..., :2]).max() > 4.0  # [m/s]
    assert np.abs(poses[..., :2]).max() < 3.0 + WALL_THICKNESS / 2


def test_an_obstacle_stops_a_body():
    scene = Scene(obstacles=(Box(center=(0.0, 1.0), size=(3.0, 0.5)),))
    one = placed(0.0, 0.0, 0.0, scene=scene)
    ride(one, np.tile([0.0, 40.0, 0.0], (100, 1, 1)))
    assert one.pose[0, 1] == pytest.approx(0.75 - 0.05, abs=0.02)


def test_worlds_stand_too_far_apart_to_touch():
    body, scene = Body.beam(length=3.0), Scene(size=(5.0, 9.0))
    many = World([body] * 30, [scene] * 30, dt=DT, substeps=2)
    origin = np.concatenate([shard._origin for shard in many._shards])
    between = np.abs(origin[:, None] - origin[None]).max(axis=-1)[~np.eye(30, dtype=bool)]
    assert between.min() >= max(scene.size) + 2 * WALL_THICKNESS


def test_what_neighbours_do_changes_no_bit_of_a_world_even_in_contact():
    count = 12
    quiet, loud = world(count=count), world(count=count)
    pose = strewn(4, count)
    own = knocks(5, 150, count)
    others = own.copy()
    others[:, 1:] = knocks(6, 150, count)[:, 1:]
    for worlds in (quiet, loud):
        worlds.place(np.arange(count), pose)
    first, second = ride(quiet, own), ride(loud, others)
    assert first[2][:, 0].any()  # world 0 did touch a wall
    for mine, theirs in zip(first, second, strict=True):
        np.testing.assert_array_equal(mine[:, 0], theirs[:, 0])


def test_many_shards_run_to_the_same_bits_every_time():
    count = 2 * SHARD_SIZE + 9
    runs = []
    for _ in range(2):
        many = world(count=count)
        many.place(np.arange(count), strewn(19, count))
        runs.append(ride(many, knocks(20, 40, count)))
    assert runs[0][2].any(axis=0).sum() > count / 3
    for first, second in zip(*runs, strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("count", [7, SHARD_SIZE + 44])
def test_a_world_moves_the_same_in_any_company_without_contact(count):
    pose = strewn(8, count)
    wrenches = knocks(9, 60, count, strength=20.0)
    together = world(scene=OPEN_ROOM, count=count)
    together.place(np.arange(count), pose)
    poses, twists, _ = ride(together, wrenches)
    for k in {0, 1, count // 2, count - 1}:
        alone = world(scene=OPEN_ROOM)
        alone.place(np.array([0]), pose[k : k + 1])
        mine, rates, _ = ride(alone, wrenches[:, k : k + 1])
        np.testing.assert_allclose(poses[:, k], mine[:, 0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(twists[:, k], rates[:, 0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("scene", [Scene(size=(3.0, 3.0)), CLUTTERED], ids=["narrow", "cluttered"])
def test_a_placed_body_moves_as_in_a_new_world_to_the_bit_whatever_it_hit_before(scene):
    count = 48
    used, fresh = world(scene=scene, count=count), world(scene=scene, count=count)
    pose = strewn(10, count, half=0.4)
    ride(used, knocks(11, 100, count))
    for worlds in (used, fresh):
        worlds.place(np.arange(count), pose)
    again, first = ride(used, knocks(12, 100, count)), ride(fresh, knocks(12, 100, count))
    assert (first[2].sum(axis=0) > 0).mean() > 0.5
    for mine, theirs in zip(again, first, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_placing_some_changes_no_bit_of_the_others_even_in_contact():
    count = 48
    left, disturbed = world(count=count), world(count=count)
    ride(left, knocks(13, 60, count))
    ride(disturbed, knocks(13, 60, count))
    moved = np.arange(0, count, 2)
    disturbed.place(moved, strewn(14, len(moved)))
    rest = np.setdiff1d(np.arange(count), moved)
    np.testing.assert_array_equal(disturbed.pose[rest], left.pose[rest])
    first, second = ride(left, knocks(15, 60, count)), ride(disturbed, knocks(15, 60, count))
    assert first[2][:, rest].any()
    for mine, theirs in zip(first, second, strict=True):
        np.testing.assert_array_equal(mine[:, rest], theirs[:, rest])


def test_arrays_once_read_stay_as_they_were():
    one = world(count=3)
    pose, twist, impulse = one.pose, one.twist, one.contact_impulse
    kept = pose.copy(), twist.copy(), impulse.copy()
    ride(one, knocks(16, 5, 3))
    one.place(np.array([1]), np.array([[0.5, 0.5, 0.5]]))
    for now, then in zip((pose, twist, impulse), kept, strict=True):
        np.testing.assert_array_equal(now, then)


def test_an_obstacle_that_reaches_out_of_its_room_touches_no_other_world():
    far = Scene(obstacles=(Box(center=(1.0, 0.0), size=(60.0, 0.4)),))
    both = World([Body()] * 2, [far, Scene()], dt=0.05, substeps=2)
    alone = World([Body()], [Scene()], dt=0.05, substeps=2)
    start = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    both.place(np.arange(2), start)
    alone.place(np.arange(1), start[:1])
    for _ in range(60):
        both.step(np.array([[0.0, -20.0, 0.0]] * 2))
        alone.step(np.array([[0.0, -20.0, 0.0]]))
    np.testing.assert_allclose(both.pose[1], alone.pose[0], atol=1e-9)
    assert both.pose[0, 1] > 0


def test_a_body_that_gets_through_a_wall_is_reported():
    light = Body(mass=0.1, linear_drag=0.0, angular_drag=0.0)
    many = World([light] * 64, [Scene()] * 64, dt=0.05, substeps=2)
    many.place(np.arange(64), np.zeros((64, 3)))
    generator = np.random.default_rng(0)

    def push() -> None:
        for _ in range(300):
            many.step(generator.choice([-20.0, 20.0], (64, 3)))

    with pytest.raises(BodyLost, match="must stay in its room"):
        push()


@pytest.mark.parametrize("lost", [3, SHARD_SIZE + 5])
def test_a_lost_body_is_told_with_the_number_of_its_world(lost):
    many = world(FREE, count=SHARD_SIZE + 8)
    many.twist[lost, 0] = 1e6
    with pytest.raises(BodyLost, match=f"the body of world {lost} must stay") as caught:
        many.step(np.zeros((SHARD_SIZE + 8, 3)))
    assert caught.value.world == lost
    assert pickle.loads(pickle.dumps(caught.value)).world == lost


def test_a_lost_body_is_back_once_it_is_placed_as_in_a_new_world():
    used, fresh = world(FREE), world(FREE)
    used.twist[0] = np.nan
    with pytest.raises(BodyLost):
        used.step(np.zeros((1, 3)))
    for worlds in (used, fresh):
        worlds.place(np.array([0]), np.array([[0.5, 0.0, 0.2]]))
    for mine, theirs in zip(
        ride(used, knocks(3, 60, 1)), ride(fresh, knocks(3, 60, 1)), strict=True
    ):
        assert np.isfinite(mine).all()
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("call", range(6))
def test_worlds_whose_placing_broke_off_are_placed_as_new_ones(call, monkeypatch):
    bodies, scenes, places = [FREE, Body(mass=5.0), FREE], [Scene()] * 3, np.arange(3)
    used, fresh = world(count=3), World(bodies, scenes, dt=DT, substeps=2)
    used.furnish(places, bodies, scenes)
    left, calls = call, {"add": pymunk.Space.add, "remove": pymunk.Space.remove}

    def broken(name, *given):
        nonlocal left
        left -= 1
        if left == -1:
            raise KeyboardInterrupt
        calls[name](*given)

    with monkeypatch.context() as patched:
        for name in calls:
            patched.setattr(pymunk.Space, name, lambda *given, name=name: broken(name, *given))
        with pytest.raises(KeyboardInterrupt):
            used.place(places, strewn(0, 3))
    for worlds in (used, fresh):
        worlds.place(places, strewn(1, 3))
    for mine, theirs in zip(
        ride(used, knocks(2, 40, 3)), ride(fresh, knocks(2, 40, 3)), strict=True
    ):
        np.testing.assert_array_equal(mine, theirs)


def test_parting_an_overlap_gives_no_impulse_and_is_reported_as_a_shift():
    one = World([Body()], [Scene()], dt=0.05, substeps=2)
    start = 2.05  # [m]: the beam's end is 5 cm in the wall
    one.place(np.arange(1), np.array([[start, 0.0, 0.0]]))
    assert one.contact_shift.tolist() == [0.0]
    shifts = []
    for _ in range(40):
        before = one.pose[0].copy()
        one.step(np.zeros((1, 3)))
        moved = np.hypot(*(one.pose[0] - before)[:2])
        shifts.append(one.contact_shift[0])
        assert one.contact_impulse[0] == 0.0
        assert shifts[-1] >= moved - 1e-12  # it rests: all of its way is parting
    assert shifts[0] > 4e-3
    assert sum(shifts) > start - one.pose[0, 0] > 0.045
    assert shifts[-1] < 1e-4 < shifts[1]


def test_a_body_that_is_pressed_against_a_wall_is_shifted_as_far_as_it_sinks_in():
    one = World([Body()], [Scene()], dt=0.05, substeps=2)
    one.place(np.arange(1), np.array([[1.99, 0.0, 0.0]]))
    for _ in range(400):
        one.step(np.array([[20.0, 0.0, 0.0]]))
    rest = one.pose[0].copy()
    one.step(np.array([[20.0, 0.0, 0.0]]))
    assert one.contact_impulse[0] == pytest.approx(20.0 * 0.05, rel=0.02)  # what it is pressed with
    assert np.abs(one.pose[0] - rest).max() < 1e-5
    assert 0 < one.contact_shift[0] < 4e-3  # sinks in and is moved out, substep by substep


@pytest.mark.parametrize("body", [Body(), Body.walker()])
def test_nothing_is_shifted_where_nothing_is_touched(body):
    many = World([body] * 300, [Scene(size=(60.0, 60.0))] * 300, dt=0.05, substeps=3)
    many.place(np.arange(300), np.random.default_rng(0).normal(size=(300, 3)))
    for step in range(40):
        many.step(np.random.default_rng(step).normal(scale=10.0, size=(300, 3)))
        assert not many.contact_shift.any()
        assert not many.contact_impulse.any()


def test_plain_bodies_move_to_the_same_bits_by_the_kernels_for_all_bodies():
    plain, other = world(count=5), world(count=5)
    other._special = True
    other._look_for_special()
    for one in (plain, other):
        one.place(np.arange(5), np.tile([0.3, -0.2, 0.4], (5, 1)))
    wrenches = knocks(0, 60, 5)
    for seen, same in zip(ride(plain, wrenches), ride(other, wrenches), strict=True):
        np.testing.assert_array_equal(seen, same)
    assert plain.contact_impulse.any() or ride(plain, wrenches)[2].any()  # walls were met


@pytest.mark.parametrize(
    ("body", "scene"),
    [
        (Body(nonholonomic=True), Scene()),
        (Body(ground_friction=0.3), Scene()),
        (Body(), Scene(gravity=(0.0, -9.81))),
    ],
)
def test_a_plain_body_that_is_replaced_leaves_nothing_of_how_it_moved(body, scene):
    replaced, from_the_start = world(), world(body, scene)
    replaced.step(np.zeros((1, 3)))
    replaced.furnish(np.array([0]), [body], [scene])
    for one in (replaced, from_the_start):
        one.place(np.array([0]), np.array([[0.3, -0.2, 0.4]]))
    wrenches = knocks(1, 20, 1)
    for seen, same in zip(ride(replaced, wrenches), ride(from_the_start, wrenches), strict=True):
        np.testing.assert_array_equal(seen, same)
