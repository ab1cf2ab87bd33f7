"""How deep energy takes bodies into walls, and what the soak test's watch makes of it."""

import numpy as np
import pytest

pytest.importorskip("tyro")

from benchmarks.soak.actions import held
from benchmarks.soak.watch import DEEPER, DEEPEST, SLACK, Watch
from coopenv import Body, Scene, Transport
from coopenv.envs.registry import find_config
from coopenv.errors import BodyLost
from coopenv.physics.world import World

TOP = Body.walker(mass=4.4, linear_drag=0.0, angular_drag=0.0, friction=1.0)


def spinning(spin, num_worlds=64):
    """Walkers in a small room, without drag, that spin; and a watch over them."""
    keywords = {"body": TOP, "scene": Scene(size=(6.0, 6.0), friction=1.0)}
    keywords |= {"dt": 0.1, "substeps": 10}
    core = Transport(num_worlds=num_worlds, config=find_config("coopenv/WalkerTurn-v0", keywords))
    core.reset(seed=0)
    core.world.twist = np.zeros((num_worlds, 3))
    core.world.twist[:, 2] = spin
    core.step(np.zeros((num_worlds, 2, 3)))
    return core, Watch(core, "spinning")


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_centre_gets_no_deeper_into_a_wall_than_all_energy_takes_it_in_a_substep(seed):
    rng, n, substep = np.random.default_rng(seed), 128, 0.01
    friction = rng.uniform(0.0, 1.0, n)
    drag = {"linear_drag": 0.0, "angular_drag": 0.0}
    bodies = [Body.walker(friction=part, **drag) for part in friction[:64]]
    bodies += [Body.beam(length=1.5, width=0.1, friction=part, **drag) for part in friction[64:]]
    world = World(bodies, [Scene(size=(6.0, 6.0))] * n, dt=substep, substeps=1)
    mass, inertia = np.array([(body.mass, body.inertia) for body in bodies]).T
    pose = np.concatenate([rng.uniform(-2.0, 2.0, (n, 2)), rng.uniform(-3, 3, (n, 1))], axis=1)
    world.place(np.arange(n), pose)
    way, part = rng.uniform(0.02, DEEPEST, n), rng.random(n)  # [m] in a substep; of it by speed
    speed = way * np.sqrt(part) / substep
    spin = way * np.sqrt((1 - part) * mass / inertia) / substep
    world.twist = np.stack([speed * np.cos(pose[:, 2]), speed * np.sin(pose[:, 2]), spin], axis=1)
    deepest = np.full(n, -np.inf)
    for _ in range(60):
        world.step(np.zeros((n, 3)))
        deepest = np.maximum(deepest, np.abs(world.pose[:, :2]).max(axis=1) - 3.0)
    assert (deepest > 0.0).any()
    assert (deepest <= DEEPER * way + SLACK).all()


def test_the_watch_believes_a_body_in_a_wall_whose_spin_may_have_become_speed_and_no_other():
    for spin, believed in ((0.0, False), (40.0, True)):
        core, watch = spinning(spin)
        shown = core.step(np.zeros((64, 2, 3)))
        again = np.zeros(64, dtype=bool)
        watch.look(shown[0], shown[1], shown[4], again)
        core.world.pose[7, 0] = 3.0 + 0.2
        if believed:
            watch.look(shown[0], shown[1], shown[4], again)
        core.world.pose[7, 0] += 1.0 if believed else 0.0
        with pytest.raises(AssertionError, match=r"world 7 is \d\.... m in a wall"):
            watch.look(shown[0], shown[1], shown[4], again)


@pytest.mark.parametrize("action", ["wrench", "motion", "impedance"])
def test_the_watch_tells_energy_that_neither_wrenches_nor_hands_gave(action):
    core = Transport(num_worlds=8, action=action)
    core.reset(seed=0)
    watch, again = Watch(core, "driven"), np.zeros(8, dtype=bool)
    push = np.random.default_rng(0).choice([-1.0, 1.0], core.action_shape)
    shape = (8, *core.action_shape[1:])
    shown = core.step(np.broadcast_to(push, shape))
    for _ in range(20):
        watch.look(shown[0], shown[1], shown[4], again)
        shown = core.step(np.broadcast_to(push, shape))
    watch.look(shown[0], shown[1], shown[4], again)
    core.world.twist[3, 0] += 5.0
    with pytest.raises(AssertionError, match=r"world 3 has .* J, at most"):
        watch.look(shown[0], shown[1], shown[4], again)


@pytest.mark.parametrize(("spin", "explained"), [(0.0, False), (1000.0, True)])
def test_a_lost_body_ends_a_trial_where_its_energy_explains_it_and_fails_it_elsewhere(
    spin, explained
):
    core, watch = spinning(spin)
    shown = core.step(np.zeros((64, 2, 3)))
    watch.look(shown[0], shown[1], shown[4], np.zeros(64, dtype=bool))

    def lose():
        yield from ()
        raise BodyLost("lost", 3)

    if explained:
        assert list(held(lose(), watch)) == []
    else:
        with pytest.raises(BodyLost):
            list(held(lose(), watch))
