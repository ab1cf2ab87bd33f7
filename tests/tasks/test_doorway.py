"""The doorway task: its layouts, the way through them, who knows what, and what it refuses."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Box, DoorwayTask, Scene, Transport, TransportTask
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from coopenv.tasks.passage import GAP, GAP_Y, HALF_DEPTH, STANDOFF, WALL_X
from tests.helpers import CLUTTERED, TRIO, corners

HALL = Scene(size=(7.0, 4.0))


def config(**keywords):
    return find_config("coopenv/BeamDoorway-v0", keywords)


def started(count=200, **keywords):
    core = Transport(num_worlds=count, config=config(**keywords))
    core.reset(seed=0)
    assert core.transition is not None
    return core, core.transition.next_state


def made(**fields: Any) -> DoorwayTask:
    return DoorwayTask(**fields)


def refused(said, body=None, scene=HALL, **fields):
    with pytest.raises(InvalidInput, match=said):
        Transport(task=DoorwayTask(**fields), scene=scene, body=body or Body())


def test_a_room_in_which_few_layouts_are_free_is_drawn_at_every_reset():
    # a box that leaves about one layout in sixty: what one draw found, two hundred find
    narrow = Scene(size=(7.0, 4.0), obstacles=(Box(center=(0.0, -0.7), size=(0.2, 2.6)),))
    core, state = started(scene=narrow)
    assert len(state.pose) == 200
    assert core.conditions.plan[:, GAP_Y].min() > 0.85


def test_every_episode_has_a_layout_of_its_own_within_the_ranges():
    core, _ = started()
    plan = core.conditions.plan
    for column, (low, high) in ((GAP, (0.6, 0.9)), (GAP_Y, (-1.0, 1.0)), (WALL_X, (-0.2, 0.2))):
        values = plan[:, column]
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < values.max() <= high
    before = plan.copy()
    core.reset(mask=np.arange(200) < 100)
    assert (core.conditions.plan[:100] != before[:100]).any(axis=1).all()
    np.testing.assert_array_equal(core.conditions.plan[100:], before[100:])


def test_the_wall_leaves_just_the_gap():
    core, _ = started(count=20)
    for scene, plan in zip(core.scenes, core.conditions.plan, strict=True):
        below, above = (box.vertices for box in scene.obstacles)
        assert below[:, 1].min() == pytest.approx(-2.0)
        assert above[:, 1].max() == pytest.approx(2.0)
        assert above[:, 1].min() - below[:, 1].max() == pytest.approx(plan[GAP])
        assert (above[:, 1].min() + below[:, 1].max()) / 2 == pytest.approx(plan[GAP_Y])
        for box in (below, above):
            assert box[:, 0].min() == pytest.approx(plan[WALL_X] - plan[HALF_DEPTH])
            assert box[:, 0].max() == pytest.approx(plan[WALL_X] + plan[HALF_DEPTH])


def test_the_whole_object_starts_on_one_platform_and_is_to_rest_on_the_other():
    core, state = started()
    task = core.config.task
    assert isinstance(task, DoorwayTask)
    for poses, platform in ((state.pose, task.start_platform), (state.goal, task.goal_platform)):
        outlines = corners(poses, Body())
        assert (outlines >= np.array(platform[0]) + task.clearance - 1e-12).all()
        assert (outlines <= np.array(platform[1]) - task.clearance + 1e-12).all()
        assert np.ptp(poses[:, 2]) > 5.5  # any angle


def test_the_default_gap_has_to_be_passed_lengthwise():
    core, _ = started()
    assert core.conditions.plan[:, GAP].max() < 2 * Body().reach
    assert core.conditions.plan[:, GAP].min() > 0.1 + 2 * 0.05


def test_the_distance_is_the_way_through_the_gap():
    core, _ = started(count=1)
    core.reset(seed=0, pose=(-2.4, 0, 0), goal=(2.4, 0, 0))
    wall, gap_y = core.conditions.plan[0, [WALL_X, GAP_Y]]
    standoff = 0.1 + 1.0 + 0.05  # half the wall, half the beam, clearance
    to_axis = np.hypot(wall - standoff + 2.4, gap_y)
    wanted = to_axis + 2 * standoff + np.hypot(2.4 - wall - standoff, gap_y)
    assert core.transition is not None
    assert core.transition.next_state.distance[0] == pytest.approx(wanted)
    core.reset(seed=0, pose=(-2.4, 0, np.pi / 2), goal=(2.4, 0, np.pi / 2))
    assert core.transition.next_state.distance[0] == pytest.approx(wanted + 0.5 * np.pi)


def test_the_distance_is_zero_at_the_goal_only_and_never_less_than_the_straight_one():
    core, state = started()
    task, plan = core.config.task, core.conditions.plan
    assert isinstance(task, DoorwayTask)
    np.testing.assert_allclose(task.way(plan, state.goal, state.goal), 0, atol=1e-15)
    generator = np.random.default_rng(0)
    pose = np.stack([generator.uniform(-b, b, 200) for b in (3.5, 2.0, np.pi)], axis=-1)
    way, straight = task.way(plan, pose, state.goal), task.distance(pose, state.goal)
    assert (way >= straight - 1e-12).all()
    assert way.min() > 0.01


def test_the_distance_has_no_steps_along_the_way():
    core, state = started(count=50)
    task, plan = core.config.task, core.conditions.plan
    assert isinstance(task, DoorwayTask)
    fraction = np.linspace(0, 1, 2001)[:, None, None]
    through = state.pose + fraction * (state.goal - state.pose)
    ways = np.array([task.way(plan, pose, state.goal) for pose in through])
    steps = np.abs(np.diff(ways, axis=0))
    moved = np.linalg.norm(state.goal - state.pose, axis=1) / 2000
    assert (steps / moved).max() < 12  # a step would be 2000 times its height


def test_it_falls_steadily_on_the_axis_of_the_gap():
    core, state = started(count=50)
    task, plan = core.config.task, core.conditions.plan
    assert isinstance(task, DoorwayTask)
    ways = []
    for along in np.linspace(-1.1, 1.1, 200):
        pose = np.stack([plan[:, WALL_X] + along, plan[:, GAP_Y], np.zeros(50)], axis=-1)
        ways.append(task.way(plan, pose, state.goal))
    assert (np.diff(ways, axis=0) < 0).all()


def test_progress_through_the_gap_pays_from_start_to_goal():
    core, state = started(count=1, reward="task")
    core.reset(seed=0, pose=(-2.4, 0.0, 1.0), goal=(-2.35, 0.0, 1.0))
    assert core.transition is not None
    near = core.transition.next_state.distance[0]
    assert near == pytest.approx(0.05)  # a goal on this side needs no gap
    assert state.distance[0] > 4.0


@pytest.mark.parametrize(
    ("guide", "told"),
    [
        ("both", [1, 1, 1]),
        ("one", [1, 0, 0]),
        ("none", [0, 0, 0]),
        (1, [0, 1, 0]),
        ((0, 2), [1, 0, 1]),
        ((), [0, 0, 0]),
    ],
)
def test_the_guide_says_who_is_told_the_angle_and_all_are_told_the_place(guide, told):
    core = Transport(config=config(task=DoorwayTask(guide=guide), body=TRIO, observe=("goal",)))
    obs, _ = core.reset(seed=0)
    assert core.conditions.told[0, :, 1].tolist() == [bool(t) for t in told]
    assert core.conditions.told[0, :, 0].all()
    assert (obs[0, :, 2:] != 0).all(axis=1).tolist() == [bool(t) for t in told]


def test_the_gap_block_shows_where_the_gap_is_in_each_agents_frame():
    core = Transport(config=config(observe=("gap",)))
    obs, _ = core.reset(seed=0, pose=(-2.0, 0.5, np.pi / 2))
    x, y, gap = core.conditions.plan[0, :3]
    # agent 0 looks along the object's x, which points up; agent 1 down
    np.testing.assert_allclose(obs[0, 0], [y - 0.5, -(x + 2), 0, -1, gap], atol=1e-6)
    np.testing.assert_allclose(obs[0, 1], [0.5 - y, x + 2, 0, 1, gap], atol=1e-6)


def test_the_gap_block_belongs_to_the_task():
    with pytest.raises(UnknownName, match="observe must be"):
        Transport(observe=("gap",))
    other = config(task=TransportTask())
    assert "gap" not in [getattr(block, "name", block) for block in other.observe]
    assert other.scene == Scene()


def test_obstacles_of_the_scene_stay_and_never_stand_before_the_gap():
    core, state = started(count=100, scene=CLUTTERED)
    assert all(scene.obstacles[:2] == CLUTTERED.obstacles for scene in core.scenes)
    assert all(len(scene.obstacles) == 4 for scene in core.scenes)
    for scene, start, goal in zip(core.scenes, state.pose, state.goal, strict=True):
        assert all(scene.is_clear(outline) for outline in corners(np.array([start, goal]), Body()))


@pytest.mark.parametrize("x", [-1.4, -0.9, 0.6, 1.4])  # [m] of a pillar
@pytest.mark.parametrize("y", [-0.9, 0.4])
@pytest.mark.parametrize(
    ("body", "standoff"),
    [(Body(), 0.1 + 1.0 + 0.05), (Body.beam(length=0.3), 0.1)],  # [m]; the latter turns in the gap
    ids=["lengthwise", "at any angle"],
)
def test_only_obstacles_in_the_way_through_the_gap_move_it(body, standoff, x, y):
    scene = replace(HALL, obstacles=(Box(center=(x, y), size=(0.3, 0.3)),))

    def is_in_the_way(plan):
        off = np.abs(np.subtract((x, y), (plan[WALL_X], plan[GAP_Y])))
        return bool((off < (plan[STANDOFF] + 0.15, plan[GAP] / 2 + 0.15)).all())

    for seed in range(60):
        free, plan = (
            DoorwayTask().sample(np.random.default_rng(seed), body, room).plan
            for room in (HALL, scene)
        )
        assert plan[STANDOFF] == pytest.approx(standoff, abs=0.01)
        assert (plan != free) == is_in_the_way(free)
        assert not is_in_the_way(plan)


def test_an_asymmetric_body_passes_at_the_angle_at_which_it_is_narrowest():
    tilted = Body(outline=((-0.8, -0.7), (-0.7, -0.8), (0.8, 0.7), (0.7, 0.8)))  # along 45°
    task = DoorwayTask()
    episode = task.sample(np.random.default_rng(0), tilted, HALL)
    assert episode.plan[5] % np.pi == pytest.approx(3 * np.pi / 4)
    assert episode.plan[7] == pytest.approx(np.sqrt(0.02))


def test_a_gap_that_the_body_does_not_fit_is_refused():
    refused(r"task\.gap must be at least 0\.20 m, .*got \(0\.15, 0\.9\)", gap=(0.15, 0.9))
    refused(r"task\.gap must be at least 1\.10 m", body=Body.beam(length=1.5, width=1.0))
    DoorwayTask(gap=(0.2, 0.2)).check(Body(), HALL)


def test_ranges_the_wrong_way_round_are_refused():
    for name in ("gap", "gap_position", "wall"):
        with pytest.raises(InvalidInput, match=rf"task\.{name} must be \(low, high\), .*; swap"):
            made(**{name: (0.9, 0.6)})
        with pytest.raises(InvalidInput, match=rf"task\.{name} must be"):
            made(**{name: (0.6, 0.7, 0.8)})


def test_layouts_that_do_not_fit_are_refused_by_name():
    refused(r"task\.start_platform must lie in the room", scene=Scene(size=(6.0, 4.0)))
    refused(r"task\.goal_platform must lie", goal_platform=((2.0, -1.5), (4.0, 1.5)))
    refused(r"task\.gap_position must leave wall on both sides", gap_position=(-1.0, 1.6))
    refused(r"task\.start_platform must have room", start_platform=((-2.0, 0), (-1.5, 0.05)))
    filled = replace(HALL, obstacles=(Box(center=(2.4, 0), size=(2.0, 3.9)),))
    refused(r"task\.goal_platform must have room for the body", scene=filled)
    stopped = replace(HALL, obstacles=(Box(center=(0.7, 0), size=(0.1, 3.9)),))
    refused(r"scene\.obstacles must leave the gap free", scene=stopped)
    for fields, said in (
        ({"wall": (-0.2, 1.3)}, r"task\.goal_platform must keep clear of the wall"),
        ({"wall_thickness": 3.0}, r"task\.start_platform must keep clear of the wall"),
        ({"goal_platform": ((3, 2), (1, 1))}, r"task\.goal_platform must be two corners"),
        ({"wall_thickness": 0.0}, r"task\.wall_thickness must be positive"),
        ({"gap": (0.0, 0.5)}, r"task\.gap must begin above zero"),
    ):
        with pytest.raises(InvalidInput, match=said):
            made(**fields)


@pytest.mark.parametrize("guide", ["two", 1.5, None, True, ("a",), -1])
def test_a_guide_that_means_nothing_is_refused(guide):
    with pytest.raises(InvalidInput, match=r"task\.guide must be"):
        DoorwayTask(guide=guide)


@pytest.mark.parametrize("guide", [2, (0, 5)])
def test_a_guide_for_an_agent_that_does_not_exist_is_refused(guide):
    refused(r"task\.guide must name agents 0 to 1", guide=guide)
