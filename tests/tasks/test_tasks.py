"""The transport task: where episodes start, where they lead, and when they are done."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Box, Scene, Task, Transport, TransportTask
from coopenv.errors import InvalidInput, UnknownName
from coopenv.tasks import DoorwayTask, FurnishedTask, MovingTask, TrackingTask
from tests.helpers import CLUTTERED, corners


def samples(task, body=None, scene=None, count=300):
    """Starts and goals ``(count, 3)`` of many episodes."""
    generator = np.random.default_rng(0)
    body, scene = body or Body(), scene or Scene()
    drawn = np.array([task.sample(generator, body, scene) for _ in range(count)])
    return drawn[:, 0], drawn[:, 1]


@pytest.mark.parametrize("scene", [Scene(), Scene(size=(2.5, 9.0)), CLUTTERED])
@pytest.mark.parametrize("clearance", [0.0, 0.2])
def test_starts_and_goals_keep_clear_of_walls_and_obstacles(scene, clearance):
    for poses in samples(TransportTask(clearance=clearance), scene=scene):
        outlines = corners(poses, Body())
        assert (np.abs(outlines) <= np.array(scene.size) / 2 - clearance + 1e-12).all()
        assert all(scene.is_clear(outline) for outline in outlines)
        assert (np.abs(poses[:, 2]) <= np.pi).all()


def test_starts_and_goals_fill_the_room_at_every_angle():
    for poses in samples(TransportTask(), count=2000):
        assert np.abs(poses[:, :2]).max() > 2.7
        # uniform angles: their first two harmonics vanish, to within sampling noise
        for harmonic in (1, 2):
            assert abs(np.exp(1j * harmonic * poses[:, 2]).mean()) < 4 / np.sqrt(2000)
        assert np.abs(poses[:, :2].mean(axis=0)).max() < 0.2


@pytest.mark.parametrize("apart", [0.0, 0.5, 3.0])
def test_the_goal_is_at_least_the_wanted_distance_away(apart):
    task = TransportTask(min_distance=apart)
    assert task.distance(*samples(task)).min() >= apart


def test_no_episode_is_done_before_it_begins():
    core = Transport(num_worlds=256)
    core.reset(seed=0)
    *_, terminated, _, info = core.step(np.zeros((256, 2, 3)))
    assert not terminated.any()
    assert not info["success"].any()


def test_the_distance_counts_metres_and_weighted_radians_the_short_way_round():
    task = TransportTask(angle_weight=0.5)
    pose = np.array([[0, 0, 0], [0, 0, 3.0], [1, 2, -3.1], [0, 0, 0.2]])
    goal = np.array([[3, 4, 0], [0, 0, -3.0], [1, 2, 3.1], [0, 0, -0.1]])
    wanted = [5.0, 0.5 * (2 * np.pi - 6), 0.5 * (2 * np.pi - 6.2), 0.15]
    np.testing.assert_allclose(task.distance(pose, goal), wanted, atol=1e-14)
    np.testing.assert_allclose(task.distance(goal, pose), wanted, atol=1e-14)
    assert not task.distance(pose, pose).any()


@pytest.mark.parametrize(
    ("away", "twist", "done"),
    [
        ((0, 0, 0), (0, 0, 0), True),
        ((0.09, 0, 0), (0, 0, 0), True),
        ((0.08, 0.08, 0), (0, 0, 0), False),
        ((0, 0, 0.09), (0, 0, 0), True),
        ((0, 0, -0.11), (0, 0, 0), False),
        ((0, 0, 2 * np.pi - 0.05), (0, 0, 0), True),
        ((0, 0, np.pi), (0, 0, 0), False),
        ((0, 0, 0), (0.06, 0.06, 0), True),
        ((0, 0, 0), (0.08, 0.08, 0), False),
        ((0, 0, 0), (0, 0, -0.11), False),
        ((0.09, 0, 0.09), (0.09, 0, 0.09), True),
    ],
)
def test_success_is_the_goal_pose_at_rest_within_every_tolerance(away, twist, done):
    goal = np.array([[1.0, -1.0, 3.1]])
    pose = goal + np.array(away)
    assert TransportTask().success(pose, np.array([twist], dtype=float), goal).tolist() == [done]


def test_an_episode_is_done_when_the_object_rests_at_its_goal():
    core = Transport()
    core.reset(pose=(0.5, 0.5, 1.0), goal=(0.55, 0.5, 1.05))
    *_, terminated, truncated, info = core.step(np.zeros((1, 2, 3)))
    assert (terminated[0], truncated[0], info["success"][0]) == (True, False, True)


def test_a_room_in_which_the_object_cannot_turn_is_refused():
    with pytest.raises(InvalidInput, match=r"scene\.size must be at least 2\.20 m each way"):
        Transport(scene=Scene(size=(6.0, 2.1)))
    Transport(scene=Scene(size=(6.0, 2.1)), task=TransportTask(clearance=0.0))


def test_a_room_full_of_obstacles_is_refused():
    scene = Scene(obstacles=(Box(center=(0, 0), size=(5.9, 5.9)),))
    with pytest.raises(InvalidInput, match=r"scene\.obstacles must leave room for the body"):
        Transport(scene=scene).reset(seed=0)


def test_a_goal_farther_than_the_room_is_refused():
    with pytest.raises(InvalidInput, match=r"task\.min_distance must leave room for a goal"):
        samples(TransportTask(min_distance=20.0), count=1)


@pytest.mark.parametrize("name", ["position_tolerance", "angle_tolerance", "speed_tolerance"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), "near"])
def test_a_tolerance_that_nothing_can_meet_is_refused_by_name(name, value):
    with pytest.raises(InvalidInput, match=rf"task\.{name} must be"):
        TransportTask(**{name: value})


def test_a_task_of_ones_own_is_carried_out():
    class Home(Task):
        """Back to the centre, from one metre away."""

        def check(self, body, scene):
            pass

        def sample(self, generator, body, scene):
            return (1.0, 0.0, float(generator.uniform(-1, 1))), (0.0, 0.0, 0.0)

        def distance(self, pose, goal):
            return np.abs(pose).sum(axis=-1)

        def success(self, pose, twist, goal):
            return pose[:, 0] < 0.9

    core = Transport(task=Home(), num_worlds=2)
    core.reset(seed=0)
    assert core.transition is not None
    np.testing.assert_array_equal(core.transition.state.pose[:, 0], 1.0)
    for _ in range(60):
        pose = core.world.pose
        toward = np.stack([-np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=-1)  # world −x
        push = np.stack([toward, -toward], axis=1)
        *_, info = core.step(np.concatenate([push, np.zeros((2, 2, 1))], axis=-1))
        if info["success"].any():
            return
    raise AssertionError("the task never reported success")


def task_with(**names) -> Any:
    """A new class of tasks with these names in it."""
    return type("Mine", (TransportTask,), names)


@pytest.mark.parametrize(
    ("misspelt", "meant"),
    [
        ("sucess", "success"),
        ("distanse", "distance"),
        ("goals_at", "goal_at"),
        ("accept", "accepts"),
        ("max_obstacle", "max_obstacles"),
        ("block", "blocks"),
        ("move", "moves"),
        ("marking", "markings"),
    ],
)
def test_a_misspelt_hook_raises_when_its_class_is_made(misspelt, meant):
    said = rf"hook of task Mine must be .* got '{misspelt}'; did you mean '{meant}'"
    for value in (lambda self: None, property(lambda self: 1), 1):
        with pytest.raises(UnknownName, match=said):
            task_with(**{misspelt: value})


def test_names_of_its_own_do_not_hurt_a_task():
    mine = task_with(motion=lambda self: 1, total=2.0, _sucess=3, score=property(lambda self: 4))
    assert mine().motion() == 1

    @dataclass(frozen=True, slots=True, kw_only=True)
    class Fields(TransportTask):
        obstacles: int = 1  # a field may be called what it likes
        sucess: float = 0.5

    assert (Fields().obstacles, Fields().sucess) == (1, 0.5)


def test_a_task_that_says_no_more_than_it_must_is_neutral():
    task, plan = TransportTask(), np.zeros((3, 0))
    assert (task.max_obstacles, tuple(task.blocks), task.moves) == (0, (), False)
    assert task.due(plan, np.arange(3.0)).all()
    assert task.accepts(np.arange(3.0)).all()
    assert task.told(2).tolist() == [[True, True]] * 2
    assert tuple(task.markings(plan[0])) == ()
    pose, goal = np.random.default_rng(0).normal(size=(2, 3, 3))
    np.testing.assert_array_equal(task.way(plan, pose, goal), task.distance(pose, goal))
    with pytest.raises(NotImplementedError, match="the goal of TransportTask does not move"):
        task.goal_at(plan, np.zeros(3))


def test_what_a_task_says_of_itself_may_be_a_value_a_field_an_attribute_or_a_property():
    @dataclass(frozen=True, kw_only=True)
    class Field(TransportTask):
        max_obstacles: int = 2

    class Attribute(TransportTask):
        def __init__(self):
            super().__init__()
            object.__setattr__(self, "max_obstacles", 2)

    tasks = (
        task_with(max_obstacles=2)(),
        Field(),
        Attribute(),
        task_with(max_obstacles=property(lambda self: 2))(),
    )
    for task in tasks:
        assert task.max_obstacles == 2


def test_tasks_that_inherit_from_the_old_names_of_hooks_still_work():
    class Both(FurnishedTask, MovingTask, TransportTask):
        max_obstacles = 1

    assert isinstance(Both(), FurnishedTask)
    assert isinstance(DoorwayTask(), FurnishedTask)
    assert isinstance(TrackingTask(), MovingTask)
    assert not isinstance(TransportTask(), MovingTask)
    assert not isinstance(object(), MovingTask)


def test_a_task_without_one_of_the_four_methods_cannot_be_made():
    class Endless(Task):
        def check(self, body, scene):
            pass

        def sample(self, generator, body, scene):
            return (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)

        def distance(self, pose, goal):
            return np.abs(pose).sum(axis=-1)

    with pytest.raises(TypeError, match="success"):
        Endless()  # pyright: ignore[reportAbstractUsage]


def test_a_task_that_only_looks_like_one_is_told_what_to_write():
    class Alike:
        check = sample = distance = success = lambda self, *given: None

    with pytest.raises(InvalidInput, match=r"must be a coopenv\.Task, .*; write class Mine\(coop"):
        Transport(task=Alike())
    with pytest.raises(InvalidInput, match=r"must be a coopenv\.Task, .*; pass TransportTask"):
        Transport(task=TransportTask)


def test_a_task_that_judges_too_few_worlds_is_not_asked_for_the_others():
    """Its answer is read by a kernel, which would go on in whatever memory comes next."""

    class Hasty(TransportTask):
        def success(self, pose, twist, goal):
            return super().success(pose, twist, goal)[:2]

    core = Transport(num_worlds=3, task=Hasty())
    core.reset(seed=0)
    with pytest.raises(ValueError, match="must judge every world"):
        core.step(np.zeros((3, 2, 3)))
