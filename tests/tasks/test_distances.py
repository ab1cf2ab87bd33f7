"""Distances, ways, thresholds and sights of the tasks by hand."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import (
    Box,
    DoorwayTask,
    Scene,
    Transport,
    TransportTask,
    WalkerAvoidTask,
    WalkerTurnTask,
)
from coopenv.conditions import Conditions
from coopenv.geometry.frames import wrap_pose
from coopenv.tasks import passage
from coopenv.tasks.episodes import Episodes
from coopenv.tasks.passage import heading, narrowest, seen_gap, way_through
from coopenv.tasks.sight import ahead_in_agent_frames, twist_in_agent_frames
from tests.helpers import NEVER

POSE = TransportTask(
    position_tolerance=0.25, angle_tolerance=0.5, speed_tolerance=0.125, spin_tolerance=0.75,
    angle_weight=0.3,
)  # fmt: skip


def rows(*each):
    return np.array(each, dtype=float)


def test_the_distance_is_the_way_and_the_turn_at_its_weight():
    pose, goal = rows((1, 2, 3.0), (0, 0, 0.2)), rows((4, -2, -3.0), (0, 0, -0.3))
    np.testing.assert_allclose(POSE.distance(pose, goal), [5 + 0.3 * (2 * np.pi - 6), 0.15])


@pytest.mark.parametrize(
    ("pose", "twist", "done"),
    [
        ((0.15, -0.2, 0.5), (0.1, 0.075, -0.75), True),  # everything just within
        ((0.15, -0.2001, 0), (0, 0, 0), False),
        ((0.1501, -0.2, 0), (0, 0, 0), False),
        ((0, 0, -0.5001), (0, 0, 0), False),
        ((0, 0, 0), (0.1001, 0.075, 0), False),
        ((0, 0, 0), (0.1, 0.0751, 0), False),
        ((0, 0, 0), (0, 0, -0.7501), False),
    ],
)
def test_success_asks_for_place_angle_speed_and_spin(pose, twist, done):
    assert POSE.success(rows(pose), rows(twist), rows((0, 0, 0))).tolist() == [done]
    there = rows((3, -1, 0))
    assert POSE.success(rows(pose) + there, rows(twist), there).tolist() == [done]


def test_a_rolling_body_turns_to_the_way_and_at_its_end():
    task = WalkerTurnTask(angle_weight=0.5, position_tolerance=0.5)
    goal = rows((3, 4, 1.0))
    way = np.arctan2(4, 3)
    share = 25 / 25.25
    ends = abs(way - 0.2) + abs(1.0 - way)
    wanted = 5 + 0.5 * (share * ends + (1 - share) * 0.8)
    assert task.distance(rows((0, 0, 0.2)), goal)[0] == pytest.approx(wanted)
    # Backwards it turns by the other part of half a turn at both ends: by 0.73 and 0.07 as before.
    back = task.distance(rows((0, 0, 0.2 - np.pi)), rows((3, 4, 1.0 - np.pi)))[0]
    assert back == pytest.approx(wanted)
    assert task.distance(rows((3, 4, 0.4)), rows((3, 4, 1.0)))[0] == pytest.approx(0.3)


def layout(**changes):
    """Of a doorway: a wall at x = 0.5 and a gap of 0.8 m at y = −1, to be passed along x."""
    plan = np.zeros(9)
    known = {
        "WALL_X": 0.5, "GAP_Y": -1.0, "GAP": 0.8, "HALF_DEPTH": 0.1, "STANDOFF": 1.5,
        "THROUGH": 0.0, "ANY_ANGLE": 0.0, "WIDTH": 0.1, "AHEAD": 1.0, **changes,
    }  # fmt: skip
    for name, value in known.items():
        plan[getattr(passage, name)] = value
    return plan[None]


def test_the_way_through_a_gap_leads_over_both_standoffs():
    pose, goal = rows((-3, 3, 0.4)), rows((4, 0, -0.2))
    # To (−1, −1), 3 m along the axis to (2, −1), and on to the goal; turns of 0.4 and 0.2
    wanted = np.hypot(2, 4) + 3 + np.hypot(2, 1) + 0.5 * 0.6
    assert way_through(layout(), pose, goal, 0.5)[0] == pytest.approx(wanted)
    free = way_through(layout(ANY_ANGLE=1.0), pose, goal, 0.5)[0]
    assert free == pytest.approx(wanted)  # 0.6 is the turn too
    mirrored = way_through(layout(WALL_X=-0.5), pose * (-1, 1, -1), goal * (-1, 1, -1), 0.5)
    assert mirrored[0] == pytest.approx(wanted)


def test_near_the_gap_it_only_has_to_get_onto_its_axis():
    pose, goal = rows((0, -0.7, 0.0)), rows((1.5, 0, 0.0))  # the goal is nearer than the standoff
    wanted = 0.3 + 0.5 + 1.0 + 1.0
    assert way_through(layout(), pose, goal, 0.5)[0] == pytest.approx(wanted)


def test_behind_the_wall_it_passes_from_one_way_to_the_other():
    goal = rows((4, 0, 0.2))
    pose = rows((1.1, -1, 0.0))  # two fifths from the wall's middle to the standoff behind it
    led = -0.6 + 1.5 + np.hypot(2, 1) + 0.5 * 0.2
    direct = np.hypot(2.9, 1) + 0.5 * 0.2
    wanted = 0.6 * led + 0.4 * direct
    assert way_through(layout(), pose, goal, 0.5)[0] == pytest.approx(wanted)
    pose = rows((2.5, 1, 0.0))
    assert way_through(layout(), pose, goal, 0.5)[0] == pytest.approx(np.hypot(1.5, 1) + 0.1)


@pytest.mark.parametrize(
    ("angle", "goal", "best", "turns"),
    [
        (0.4, -0.2, 0.0, 0.6),
        (3.0, 3.0, np.pi, 2 * (np.pi - 3)),
        (1.0, 2.5, np.pi, 2 * np.pi - 3.5),
        (np.pi / 2, np.pi / 2, 0.0, np.pi),  # of equals the first
    ],
)
def test_of_two_angles_it_passes_at_the_one_that_takes_fewer_turns(angle, goal, best, turns):
    found, needed = heading(layout()[0], angle, goal)
    assert needed == pytest.approx(turns)
    assert found == pytest.approx(best)


def test_a_body_is_narrowest_across_one_of_its_edges():
    slanted = ((0.0, 0.0), (4.0, 3.0), (3.4, 3.8), (-0.6, 0.8))  # 5 m by 1 m
    shape = narrowest(slanted)
    assert shape.width == pytest.approx(1.0)
    assert shape.along == pytest.approx(np.arctan2(3, 4))
    assert shape.ahead == pytest.approx(5.0)
    turned = narrowest((slanted[1], slanted[2], slanted[3], slanted[0]))
    assert turned.width == pytest.approx(1.0)


def test_the_gap_is_seen_from_each_agents_frame():
    frame = np.array([[(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)]])
    seen = seen_gap(layout(), rows((0.1, 0.2, np.pi / 2)), frame)[0]
    # The object's x is the world's y: (0.4, −1.2) m is (−1.2, −0.4) to it.
    np.testing.assert_allclose(
        seen,
        [(-1.2, -0.4, 0, -1, 0.8), (1.2, 0.4, 0, 1, 0.8), (-0.4, 1.2, -1, 0, 0.8)],
        atol=1e-12,
    )


TOLD = np.array([[(1, 1), (1, 0)], [(0, 1), (0, 0)]], dtype=bool)
FRAMES = np.array([[(1.0, 0.0), (-1.0, 0.0)]] * 2)


def test_a_preview_is_seen_from_each_agents_frame_as_far_as_it_is_told():
    pose = rows((1, 2, np.pi / 2), (1, 2, np.pi / 2))
    later = np.array([[(2, 4, np.pi), (1, 1, 0)]] * 2, dtype=float)
    seen = ahead_in_agent_frames(pose, later, FRAMES, TOLD)
    np.testing.assert_allclose(seen[0, 0], [2, -1, 0, 1, -1, 0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(seen[0, 1], [-2, 1, 0, 0, 1, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(seen[1, 0], [0, 0, 0, 1, 0, 0, 0, -1], atol=1e-12)
    assert not seen[1, 1].any()


def test_a_twist_is_seen_from_each_agents_frame_as_far_as_it_is_told():
    pose, twist = rows((1, 1, np.pi / 2), (1, 1, np.pi / 2)), rows((2, 3, 4), (2, 3, 4))
    seen = twist_in_agent_frames(pose, twist, FRAMES, TOLD)
    np.testing.assert_allclose(seen, [[(3, -2, 4), (-3, 2, 0)], [(0, 0, 4), (0, 0, 0)]], atol=1e-12)


def test_the_way_round_an_obstacle_is_in_the_plan():
    task = WalkerAvoidTask(angle_weight=0.5, position_tolerance=0.5)
    plan = rows((0.5, 10, 10, 0, 0.1, 1, 1, 0))  # a disc of 0.5 m, a room, a box
    way = task.way(plan, rows((-3, 0, 0)), rows((3, 0, 0)))[0]
    # By (∓1.02, −0.92): box, disc and 0.02 m beside them
    leg, slant = np.hypot(1.98, 0.92), np.arctan2(0.92, 1.98)
    length = 2 * leg + 2.04
    share = length**2 / (length**2 + 0.25)
    assert way == pytest.approx(length + 0.5 * share * (4 * slant))


class Mean(TransportTask):
    """Counts only where the mean distance of the steps is below a metre, and from 0.2 s on."""

    __slots__ = ()

    def due(self, plan, time):
        return time >= 0.2 - 1e-9

    def accepts(self, mean_distance):
        return mean_distance < 1.0


def judged(task, distances, *, horizon=5, success=True):
    """Success and truncation of a world whose steps had these distances."""
    core = Transport(task=NEVER)
    core.reset(seed=0)
    assert core.transition is not None
    episodes = Episodes(task, 1, dt=0.1, horizon=horizon)
    episodes.begin(np.array([0]))
    seen = []
    for distance in distances:
        time = episodes.tick()
        state = core.transition.next_state
        state = replace(
            state,
            pose=state.goal if success else state.goal + 9.0,
            twist=np.zeros((1, 3)),
            distance=np.array([distance]),
            time=time,
        )
        conditions: Conditions = core.conditions
        done, terminated, truncated = episodes.judge(conditions, state)
        assert terminated[0] == done[0]
        seen.append([bool(done[0]), bool(truncated[0])])
    return seen


def test_success_waits_until_it_is_due_and_the_mean_distance_is_small():
    assert judged(Mean(), [0.5, 0.5]) == [[False, False], [True, False]]
    # Means of 4, 2.5, 1.75, 1.3 and 1.06 m
    late = judged(Mean(), [4.0, 1.0, 0.25, 0.0, 0.0])
    assert late == [[False, False]] * 4 + [[False, True]]
    assert judged(Mean(), [2.0, 0.5, 0.25], horizon=3)[2] == [True, False]  # 0.92 m; no truncation


def test_an_episode_is_truncated_after_its_horizon_and_not_before():
    seen = judged(TransportTask(), [1.0] * 3, horizon=3, success=False)
    assert seen == [[False, False], [False, False], [False, True]]


def test_guides_say_who_is_told_the_angle():
    for guide, wanted in (
        ("both", (1, 1, 1)), ("one", (1, 0, 0)), ("none", (0, 0, 0)), (2, (0, 0, 1)),
        ((1, 2), (0, 1, 1)),
    ):  # fmt: skip
        told = DoorwayTask(guide=guide).told(3)
        assert told[:, 0].all()
        assert told[:, 1].tolist() == [bool(each) for each in wanted]


def test_a_box_in_a_row_is_its_centre_size_and_angle():
    box = Box(center=(1, 2), size=(3, 4), angle=0.5)
    assert tuple(box.row) == (1, 2, 3, 4, 0.5)
    assert Scene(obstacles=(box,)).obstacles == (box,)


class Asked(TransportTask):
    """A transport task that is asked, as it has something to say in every step."""

    __slots__ = ()

    def due(self, plan, time):
        return np.ones(len(time), dtype=np.bool_)


def test_a_pose_task_that_is_not_asked_leads_to_the_same_bits():
    count = 400
    core = Transport(num_worlds=count, task=NEVER)
    core.reset(seed=0)
    generator = np.random.default_rng(1)
    goal = wrap_pose(generator.uniform(-4, 4, (count, 3)))
    asked, read = (Episodes(task, count, dt=0.05, horizon=3) for task in (Asked(), TransportTask()))
    for episodes in (asked, read):
        episodes.begin(np.arange(count))
    ended = np.zeros(2, dtype=np.int64)
    for scale in (0.2, 0.1, 0.05):
        pose = goal + scale * generator.normal(size=(count, 3)) + (0.0, 0.0, 2 * np.pi)
        twist = scale * generator.normal(size=(count, 3))
        first, second = (e.arrive(core.conditions, pose, twist, goal) for e in (asked, read))
        for name in ("pose", "twist", "goal", "distance", "time"):
            np.testing.assert_array_equal(getattr(first[0], name), getattr(second[0], name))
        for mine, theirs in zip(first[1:], second[1:], strict=True):
            np.testing.assert_array_equal(mine, theirs)
        ended += np.array([first[1].sum(), first[3].sum()])
    first, second = (e.get_state(np.arange(count)) for e in (asked, read))
    np.testing.assert_array_equal(first["steps"], second["steps"])
    np.testing.assert_array_equal(first["ended"], second["ended"])
    assert (ended > 50).all()  # by success and by time


class Restless(TransportTask):
    """A task that says that its goal moves, and not where to."""

    __slots__ = ()

    @property
    def moves(self):
        return True


def test_a_goal_that_is_said_to_move_must_say_where_it_is():
    core = Transport(task=Restless())
    core.reset(seed=0)
    with pytest.raises(NotImplementedError, match="goal of Restless does not move"):
        core.step(np.zeros(core.action_shape))
