"""The walker's tasks: goals it can drive to, a distance that leads it, rules that are kept."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import coopenv
from coopenv import Body, Box, Scene, Transport, WalkerAvoidTask, WalkerTurnTask
from coopenv.errors import InvalidInput
from coopenv.observation import BLOCKS
from coopenv.physics.world import World
from coopenv.tasks import Episode, RollingTask
from coopenv.tasks.nearest import NEAREST, RANGE
from tests.agents.controllers.test_impedance import last
from tests.helpers import CLUTTERED, corners

WALKER = Body.walker()
ROOM = Scene(size=(8.0, 6.0))
TASKS = {"turn": WalkerTurnTask(), "avoid": WalkerAvoidTask()}
EVERY_TASK = pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)

places = st.tuples(*[st.floats(-3, 3)] * 2, st.floats(-np.pi, np.pi))


def episodes(task, scene=ROOM, body=WALKER, count=300):
    generator = np.random.default_rng(0)
    drawn = [task.sample(generator, body, scene) for _ in range(count)]
    return [d if isinstance(d, Episode) else Episode(start=d[0], goal=d[1]) for d in drawn]


def distance(pose, goal, task=None):
    return float((task or RollingTask()).distance(np.array([pose]), np.array([goal]))[0])


@EVERY_TASK
@pytest.mark.parametrize("scene", [ROOM, CLUTTERED], ids=["room", "cluttered"])
def test_starts_and_goals_keep_clear_of_walls_and_obstacles(task, scene):
    for episode in episodes(task, scene, count=100):
        boxes = Scene(size=scene.size, obstacles=(*scene.obstacles, *episode.obstacles))
        outlines = corners(np.array([episode.start, episode.goal]), WALKER)
        assert (np.abs(outlines) <= np.array(scene.size) / 2 - task.clearance + 1e-9).all()
        assert all(boxes.is_clear(outline) for outline in outlines)


@EVERY_TASK
def test_starts_lie_and_look_everywhere(task):
    starts = np.array([episode.start for episode in episodes(task, count=1500)])
    assert abs(np.exp(1j * starts[:, 2]).mean()) < (0.08 if task is TASKS["turn"] else 0.15)
    assert np.abs(starts[:, :2].mean(axis=0)).max() < 0.3
    assert (np.abs(starts[:, 2]) <= np.pi).all()


def test_a_turn_can_be_driven_forwards_within_the_length_and_angle_asked_for():
    task = WalkerTurnTask(path_length=(1.0, 2.0), turn=(0.5, 1.0))
    for episode in episodes(task, count=300):
        away = np.subtract(episode.goal, episode.start)
        turned = np.pi - (np.pi - away[2]) % (2 * np.pi)
        assert 0.5 - 1e-9 <= abs(turned) <= 1.0 + 1e-9
        assert np.hypot(*away[:2]) <= 2.0 + 1e-9
        heading = np.array([np.cos(episode.start[2]), np.sin(episode.start[2])])
        assert heading @ away[:2] > 0


def test_an_obstacle_stands_between_start_and_goal():
    task = WalkerAvoidTask()
    assert task.max_obstacles == 1
    for episode in episodes(task):
        (box,) = episode.obstacles
        start, goal = np.array(episode.start[:2]), np.array(episode.goal[:2])
        line = (goal - start) / np.linalg.norm(goal - start)
        to_box = np.array(box.center) - start
        assert 0 < line @ to_box < np.linalg.norm(goal - start)
        assert abs(line[0] * to_box[1] - line[1] * to_box[0]) <= task.offset + 1e-9
        # Straight on, the walker would run into it.
        way = start + np.linspace(0, 1, 80)[:, None] * (goal - start)
        straight = np.column_stack([way, np.full(80, np.arctan2(line[1], line[0]))])
        outlines = corners(straight, WALKER)
        assert not all(Scene(obstacles=(box,)).is_clear(outline) for outline in outlines)


def test_more_obstacles_are_drawn_where_they_are_asked_for():
    task = WalkerAvoidTask(obstacles=3)
    assert task.max_obstacles == 3
    assert all(len(episode.obstacles) == 3 for episode in episodes(task, count=50))
    core = Transport(num_worlds=4, task=task, body=WALKER, scene=ROOM)
    core.reset(seed=0)
    assert core.conditions.room.count.tolist() == [3] * 4


def test_the_distance_is_a_turn_a_drive_and_a_turn():
    task = RollingTask(angle_weight=0.5, position_tolerance=1e-6)
    quarter = 0.5 * np.pi / 2
    assert distance((0, 0, 0), (2, 0, 0), task) == pytest.approx(2.0)
    assert distance((0, 0, 0), (-2, 0, 0), task) == pytest.approx(2.0)  # backwards
    assert distance((0, 0, 0), (0, 2, 0), task) == pytest.approx(2.0 + 2 * quarter)
    assert distance((0, 0, 0), (0, 2, np.pi / 2), task) == pytest.approx(2.0 + quarter)
    assert distance((0, 0, 0), (0, -2, np.pi / 2), task) == pytest.approx(2.0 + quarter)
    assert distance((0, 0, 0), (0, 0, 1.0), task) == pytest.approx(0.5)


@given(places, places)
def test_the_distance_is_zero_only_at_the_goal_and_never_less_than_the_way(pose, goal):
    found = distance(pose, goal)
    turn = abs(np.pi - (np.pi - (goal[2] - pose[2])) % (2 * np.pi))
    assert found >= np.hypot(goal[0] - pose[0], goal[1] - pose[1]) + 0.5 * turn - 1e-12
    assert distance(goal, goal) == 0.0


@given(places, places, st.floats(-np.pi, np.pi), st.floats(-2, 2), st.floats(-2, 2))
def test_the_distance_does_not_depend_on_where_the_world_has_its_origin(pose, goal, turn, x, y):
    def moved(p):
        c, s = np.cos(turn), np.sin(turn)
        return x + c * p[0] - s * p[1], y + s * p[0] + c * p[1], p[2] + turn

    if np.hypot(goal[0] - pose[0], goal[1] - pose[1]) < 1e-6:
        return  # the way has no direction
    assert distance(moved(pose), moved(goal)) == pytest.approx(distance(pose, goal), abs=1e-6)


@settings(deadline=None)
@given(places, places)
def test_turning_or_rolling_brings_it_nearer_wherever_it_is(pose, goal):
    # No place outside the tolerances where everything a body on wheels can do makes it worse.
    task, here = RollingTask(), distance(pose, goal)
    turn = abs(np.pi - (np.pi - (goal[2] - pose[2])) % (2 * np.pi))
    if np.hypot(goal[0] - pose[0], goal[1] - pose[1]) < 2 * task.position_tolerance and turn < 0.1:
        return
    steps = [
        (pose[0] + go * np.cos(pose[2]), pose[1] + go * np.sin(pose[2]), pose[2] + by)
        for go in (-0.02, -0.001, 0.0, 0.001, 0.02)
        for by in (-0.02, -0.001, 0.0, 0.001, 0.02)
    ]
    assert min(distance(step, goal) for step in steps) < here


@pytest.mark.parametrize(
    ("kind", "values", "said"),
    [
        (
            WalkerTurnTask,
            {"path_length": (3.0, 1.0)},
            r"task\.path_length must be \(low, high\), .*; swap them",
        ),
        (
            WalkerTurnTask,
            {"path_length": 2.0},
            r"task\.path_length must be \(low, high\), .*; give two",
        ),
        (WalkerTurnTask, {"turn": (0.0, 7.0)}, r"task\.turn must not end above 6\.283"),
        (WalkerTurnTask, {"turn": (-1.0, 1.0)}, r"task\.turn must not begin below zero"),
        (WalkerTurnTask, {"position_tolerance": 0.0}, r"task\.position_tolerance must be positive"),
        (
            WalkerAvoidTask,
            {"obstacles": 0},
            r"task\.obstacles must be a whole number of at least 1",
        ),
        (
            WalkerAvoidTask,
            {"obstacle_size": (0.0, 0.5)},
            r"task\.obstacle_size must begin above zero",
        ),
        (WalkerAvoidTask, {"approach": "near"}, r"task\.approach must be an array of numbers"),
        (WalkerAvoidTask, {"offset": -0.1}, r"task\.offset must be zero or positive"),
        (WalkerAvoidTask, {"veer": np.nan}, r"task\.veer must be finite"),
    ],
)
def test_a_value_that_breaks_its_rule_is_refused_by_name(kind, values, said):
    with pytest.raises(InvalidInput, match=said):
        kind(**values)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"task": WalkerTurnTask(path_length=(9.0, 9.5))}, r"task\.path_length must leave room"),
        ({"scene": Scene(size=(1.2, 6.0))}, r"scene\.size must be at least"),
        ({"task": WalkerAvoidTask(approach=(0.5, 2.0))}, r"task\.approach must be at least 1\.30"),
        ({"task": WalkerAvoidTask(beyond=(1.0, 2.0))}, r"task\.beyond must be at least 1\.30"),
        (
            {"task": WalkerAvoidTask(), "scene": Scene(size=(9.0, 2.4))},
            r"scene\.size must leave a way round task\.obstacles",
        ),
    ],
)
def test_what_cannot_be_done_is_refused_at_construction(keywords, said):
    avoids = isinstance(keywords.get("task"), WalkerAvoidTask)
    module = coopenv.walker_avoid_v0 if avoids else coopenv.walker_turn_v0
    with pytest.raises(InvalidInput, match=said):
        module.parallel_env(**keywords)


def test_tasks_come_back_from_json_as_they_were():
    plain = {"path_length": [1.5, 3.0], "turn": [0.5, 1.0]}
    env = coopenv.walker_turn_v0.parallel_env(task=plain)
    assert env.transport.config.task == WalkerTurnTask(path_length=(1.5, 3.0), turn=(0.5, 1.0))
    avoid = coopenv.walker_avoid_v0.parallel_env(task={"obstacles": 2})
    assert avoid.transport.config.task == WalkerAvoidTask(obstacles=2)


def test_hovering_and_going_to_and_fro_earn_nothing():
    core = coopenv.walker_turn_v0.vector_env(num_envs=1).unwrapped.transport
    core.reset(seed=0, pose=(0, 0, 0), goal=(2, 1, 0.5))
    start, earned = last(core).next_state.distance[0], 0.0
    for k in range(240):
        push = 1.0 if k % 40 < 10 or k % 40 >= 30 else -1.0  # there and back again
        *_, info = core.step(np.tile([push, 0.0, 0.0], (1, 2, 1)))
        earned += info["reward_terms"]["progress"][0, 0]
    assert earned == pytest.approx(5.0 * (start - last(core).next_state.distance[0]))


def test_only_the_human_knows_the_goal_past_the_obstacle():
    core = coopenv.walker_avoid_v0.vector_env(num_envs=8).unwrapped.transport
    obs, _ = core.reset(seed=0)
    goal = obs[..., core.observation.blocks["goal"]]
    assert np.abs(goal[:, 0]).max() > 1.0
    assert not goal[:, 1].any()


def read(pose, boxes, body=WALKER):
    core = Transport(body=body, scene=Scene(size=(20.0, 20.0), obstacles=boxes), observe=(NEAREST,))
    obs, _ = core.reset(seed=0, pose=pose, goal=(-8, -8, 0))
    return obs[0]


def test_the_nearest_obstacle_is_seen_in_each_agents_frame():
    box = Box(center=(2.0, 0.3), size=(1.0, 1.0))
    ahead = read((0.0, 0.0, 0.0), (box,))
    np.testing.assert_allclose(ahead, [[1.5, ahead[0, 1], 1.0]] * 2, atol=1e-6)
    left = read((0.0, 0.0, -np.pi / 2), (box,))
    np.testing.assert_allclose(left[1], [-ahead[0, 1], 1.5, 1.0], atol=1e-6)
    facing = read((0.0, 0.0, 0.0), (box,), Body())  # its second end looks back
    np.testing.assert_allclose(facing[1, :2], -facing[0, :2], atol=1e-6)


def test_a_far_obstacle_and_none_read_alike():
    wanted = [[0.0, 0.0, RANGE]] * 2
    far = Box(center=(6.0, 0.0), size=(1.0, 1.0))
    np.testing.assert_array_equal(read((0.0, 0.0, 0.0), (far,)), wanted)
    np.testing.assert_array_equal(read((0.0, 0.0, 0.0), ()), wanted)


def test_the_nearest_block_is_the_tasks_own():
    assert NEAREST.name not in BLOCKS
    assert NEAREST in coopenv.walker_avoid_v0.single_env().transport.config.observe
    only = coopenv.walker_avoid_v0.single_env(observe=("goal", "nearest"))
    assert only.transport.config.observe == ("goal", NEAREST)


def test_episodes_bring_their_obstacles_into_the_physics():
    core = coopenv.walker_avoid_v0.vector_env(num_envs=3).unwrapped.transport
    core.reset(seed=0)
    assert isinstance(core.world, World)
    for k in range(3):
        (box,) = core.scenes[k].obstacles
        np.testing.assert_allclose(core.conditions.room.boxes[k, 0, :2], box.center)


def test_a_layout_is_drawn_as_ever_from_its_seed():
    generator, room = np.random.default_rng(5), Scene(size=(10.0, 10.0))
    episode = WalkerAvoidTask(obstacles=2).sample(generator, Body.walker(), room)
    assert isinstance(episode, Episode)
    assert episode.start == pytest.approx(
        (-3.784021469467831, 4.1859842956999636, -0.6392212767108121), rel=1e-12
    )
    assert episode.plan[3:] == pytest.approx(
        (-2.522296395072168, 2.8880861133945084, 0.4874858533874854, 0.34809180169123183,
         1.4464842155961801, 4.011129117217138, 4.7675917995685975, 0.5172926837917455,
         0.6146635167463523, 3.1389383275783183),
        rel=1e-12,
    )  # fmt: skip
    assert generator.random() == 0.24483522451472206
