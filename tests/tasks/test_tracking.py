"""The tracking task: its references, what is seen of them, when it is done, what it refuses."""

import dataclasses

import numpy as np
import pytest

from coopenv import Body, Box, Reference, Scene, Sensor, TrackingTask, Transport
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from tests.helpers import CLUTTERED, LOOP, corners

STILL = Reference(times=(0.0, 0.2), poses=((0, 0, 0), (0, 0, 0)))


def config(**keywords):
    return find_config("coopenv/BeamTracking-v0", keywords)


def started(count=100, **keywords):
    core = Transport(num_worlds=count, config=config(**keywords))
    core.reset(seed=0)
    task = core.config.task
    assert isinstance(task, TrackingTask)
    return core, task


def last(core):
    assert core.transition is not None
    return core.transition


def motion(core, task, steps=161):
    """The references ``(step, world, 9)``."""
    times = np.linspace(0, task.total, steps)
    return np.array([task.motion(core.conditions.plan, np.full(core.num_worlds, t)) for t in times])


@pytest.mark.parametrize("name", ["preview", "reference_twist"])
def test_a_noisy_sensor_of_the_reference_reads_zero_where_it_is_not_told(name):
    entry = Sensor(name, noise=0.1, bias=0.1)
    core = Transport(num_worlds=3, config=config(informed=(0,), observe=("goal", entry)))
    obs, _ = core.reset(seed=0)
    read = obs[..., core.observation.blocks[name]]
    assert read[:, 0].all()
    assert not read[:, 1].any()


KINDS = ["minimum_jerk", "rotate", "rotate_translate", "translate", ("rotate", "translate")]


@pytest.mark.parametrize("kind", KINDS)
def test_a_random_reference_stays_in_the_room_and_off_obstacles_within_its_speeds(kind):
    core, task = started(task=TrackingTask(reference=kind), scene=CLUTTERED, count=40)
    path = motion(core, task)
    outlines = corners(path[..., :3], Body())
    assert (np.abs(outlines) <= np.array(CLUTTERED.size) / 2).all()
    assert all(CLUTTERED.is_clear(outline) for outline in outlines.reshape(-1, 4, 2)[::7])
    assert np.hypot(path[..., 3], path[..., 4]).max() <= task.speed + 1e-9
    assert np.abs(path[..., 5]).max() <= task.spin + 1e-9
    np.testing.assert_allclose(path[[0, -1], :, 3:], 0, atol=1e-9)  # from rest to rest


def test_the_kinds_move_what_they_say():
    for kind, moves, turns in (("rotate", 0, 1), ("translate", 1, 0), ("rotate_translate", 1, 1)):
        core, task = started(task=TrackingTask(reference=kind))
        path = motion(core, task)
        assert (np.ptp(path[..., :2], axis=0).max(axis=1) > 0.2).all() == bool(moves)
        assert (np.ptp(path[..., 2], axis=0) > 0.2).all() == bool(turns)
        assert len(np.unique(path[0, :, 0])) == 100


def test_the_goal_is_where_the_reference_is_and_the_distance_the_error():
    core, task = started(task=TrackingTask(reference=LOOP), count=2)
    for step in range(1, 41):
        core.step(np.zeros((2, 2, 3)))
        state = last(core).next_state
        wanted = LOOP.motion(np.array([step * core.dt]))[0, :3]
        np.testing.assert_allclose(state.goal[0], wanted)
        np.testing.assert_allclose(state.distance, task.distance(state.pose, state.goal))
    assert last(core).next_state.goal[0, 0] == pytest.approx(1.0)  # the second row, at 2 s


def test_the_preview_shows_where_the_reference_will_be_in_each_agents_frame():
    core, task = started(
        count=3, task=TrackingTask(preview=(0.5, 1.0)), observe=("preview", "reference_twist")
    )
    obs = np.zeros((3, 2, 11))
    for _ in range(20):
        obs, *_ = core.step(np.random.default_rng(0).uniform(-1, 1, (3, 2, 3)))
    pose, time = last(core).next_state.pose, last(core).next_state.time
    for j, ahead in enumerate(task.preview):
        later = task.goal_at(core.conditions.plan, time + ahead)
        dx, dy, turn = (later - pose).T
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        seen = np.stack([c * dx + s * dy, c * dy - s * dx, np.cos(turn), np.sin(turn)], axis=-1)
        np.testing.assert_allclose(obs[:, 0, 4 * j : 4 * j + 4], seen, atol=1e-6)
        np.testing.assert_allclose(obs[:, 1, 4 * j : 4 * j + 4], seen * (-1, -1, 1, 1), atol=1e-6)
    twist = task.motion(core.conditions.plan, time)[:, 3:6]
    np.testing.assert_allclose(obs[:, 0, 10], twist[:, 2], atol=1e-6)
    np.testing.assert_allclose(
        np.hypot(obs[..., 8], obs[..., 9]).T, [np.hypot(*twist[:, :2].T)] * 2, atol=1e-6
    )


def test_what_an_agent_is_not_told_reads_zero():
    core = Transport(config=config(informed=(1,), observe=("goal", "preview", "reference_twist")))
    obs, _ = core.reset(seed=0)
    for _ in range(10):
        obs, *_ = core.step(np.zeros((1, 2, 3)))
    assert not obs[0, 0].any()
    assert obs[0, 1].all()


def test_success_waits_for_the_end_of_the_reference():
    core, _ = started(count=1, task=TrackingTask(reference=STILL))
    ends = [core.step(np.zeros((1, 2, 3)))[2][0] for _ in range(4)]
    assert [bool(end) for end in ends] == [False, False, False, True]


def test_success_asks_for_a_small_mean_error_over_the_whole_episode():
    for tolerance, done in ((0.3, False), (0.6, True)):
        task = TrackingTask(
            reference=STILL,
            mean_tolerance=tolerance,
            position_tolerance=1.0,
            speed_tolerance=2.0,
            spin_tolerance=2.0,
        )
        core, _ = started(count=2, task=task)
        _, info = core.reset(seed=0, pose=(0.5, 0, 0))
        for _ in range(6):
            *_, info = core.step(np.zeros((2, 2, 3)))
            if info["success"].any():
                break
        assert info["success"].tolist() == [done] * 2
    core.reset(seed=0, pose=(0.9, 0, 0))
    _, info = core.reset(
        mask=np.array([True, False]), pose=(0.5, 0, 0)
    )  # counts from its own start
    for _ in range(4):
        *_, info = core.step(np.zeros((2, 2, 3)))
    assert info["success"].tolist() == [True, False]


def test_a_reference_that_leaves_the_room_or_meets_an_obstacle_is_refused():
    with pytest.raises(InvalidInput, match=r"task\.reference must keep the body inside the room"):
        Transport(task=TrackingTask(reference=LOOP), scene=Scene(size=(3.0, 3.0)))
    boxed = Scene(obstacles=(Box(center=(1.0, 1.0), size=(0.2, 0.2)),))
    with pytest.raises(InvalidInput, match=r"task\.reference must .*got x, y, theta = .* at \d"):
        Transport(task=TrackingTask(reference=LOOP), scene=boxed)
    with pytest.raises(InvalidInput, match=r"task\.reference must fit into the room"):
        Transport(task=TrackingTask(reference="rotate"), scene=Scene(size=(2.2, 0.3)))


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"reference": "rotat"}, r"task\.reference must .*did you mean 'rotate'"),
        ({"reference": ("rotate", "minimum_jerk")}, r"task\.reference must be one of"),
        ({"reference": 3}, r"task\.reference must be one of"),
        ({"reference": ()}, r"task\.reference must be one of"),
        ({"reference": {"times": (0, 1)}}, r"task\.reference must have times and poses"),
        ({"reference": "no/such.csv"}, r"reference must be a \.csv or \.npz file that exists"),
        ({"preview": ()}, r"task\.preview must be a sequence"),
        ({"preview": 0.5}, r"task\.preview must be a sequence"),
        ({"preview": (0.0,)}, r"task\.preview must be positive"),
        ({"segments": 0}, r"task\.segments must be a whole number"),
        ({"duration": 0}, r"task\.duration must be positive"),
        ({"speed": -1}, r"task\.speed must be positive"),
        ({"mean_tolerance": 0}, r"task\.mean_tolerance must be positive"),
    ],
)
def test_wrong_values_are_refused_by_name(fields, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        TrackingTask(**fields)


@pytest.mark.parametrize("held", [lambda block: block, lambda block: Sensor(block, noise=0.1)])
def test_a_configuration_whose_task_is_replaced_looks_as_far_ahead_as_the_new_one(held):
    before = config(task=TrackingTask(preview=(0.5,)), observe=("goal", held("preview")))
    task = TrackingTask(preview=(0.1, 0.7))
    after = dataclasses.replace(before, task=task)
    assert after == config(task=task, observe=("goal", held("preview")))
    sizes = [Transport(config=each).reset(seed=0)[0].shape[-1] for each in (before, after)]
    assert sizes[1] == sizes[0] + 4


@pytest.mark.parametrize(
    ("task", "scene", "end", "left"),
    [
        (
            TrackingTask(),
            Scene(),
            (1.2336612692145914, 0.665771634690034, 0.9944999254759884),
            0.3197846543182863,
        ),
        (  # turns on the spot first, off a box
            TrackingTask(reference=("rotate", "translate")),
            Scene(obstacles=(Box(center=(1.0, 1.0), size=(0.5, 0.5)),)),
            (0.722158300250265, 2.004848328087137, -0.659254221569941),
            0.9349610941866503,
        ),
    ],
)
def test_a_reference_is_drawn_as_ever_from_its_seed(task, scene, end, left):
    generator = np.random.default_rng(5)
    episode = task.sample(generator, Body(), scene)
    assert episode.start == pytest.approx((1.1589045986459432, 1.6961914725197662, -0.0962933396))
    assert episode.plan[-3:] == pytest.approx(end, rel=1e-12)
    assert generator.random() == left  # so many numbers were drawn


class Counting:
    """A generator of random numbers that counts how often starts are drawn."""

    def __init__(self):
        self.generator, self.starts = np.random.default_rng(0), 0

    def random(self, count):
        self.starts += count == 3
        return self.generator.random(count)


def test_a_room_that_is_nearly_full_is_refused_before_long():
    walls = tuple(Box(center=(0, side * 1.71), size=(6, 3)) for side in (-1, 1))
    scene, generator = Scene(size=(6.0, 6.0), obstacles=walls), Counting()
    assert scene.is_free(0.0, 0.0)
    with pytest.raises(InvalidInput, match=r"task\.reference must fit into the room"):
        TrackingTask().sample(generator, Body(), scene)  # pyright: ignore[reportArgumentType]
    assert 10_000 < generator.starts <= 30_000
