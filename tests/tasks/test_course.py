"""The block that tells the way: a drive and two turns, round obstacles, to who knows the goal."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import coopenv
from coopenv import Transport, TransportConfig, WalkerAvoidTask
from coopenv.envs.registry import find_config
from coopenv.observation import BLOCKS
from coopenv.tasks.course import COURSE, RANGE
from coopenv.tasks.nearest import NEAREST

AVOID = "coopenv/WalkerAvoid-v0"
BLUR = WalkerAvoidTask().position_tolerance  # [m]
turns = st.floats(-3.1, 3.1)  # short of half a turn, whose sign is anybody's
CORE = Transport(config=find_config(AVOID, {"observe": ("goal", "course"), "informed": (0, 1)}))


def course(pose, goal=(3.0, 2.0, 0.0), core=CORE):
    """What agent 0 reads; the obstacle is out of the way where both lie at x > 1.5 m."""
    obs, _ = core.reset(seed=LAID_OUT, pose=pose, goal=goal)
    return obs[0, 0, core.observation.blocks["course"]]


def obstacle(seed):
    CORE.reset(seed=seed)
    return CORE.scenes[0].obstacles[0].center


# An episode whose obstacle stands in the left half, so that the right one is free
LAID_OUT = next(seed for seed in range(100) if obstacle(seed)[0] < -1.5)


def test_a_way_straight_ahead_or_behind_has_no_turns():
    np.testing.assert_allclose(course((1.5, 0.0, 0.0), (3.0, 0.0, 0.0)), [1.5, 0, 0], atol=1e-6)
    np.testing.assert_allclose(course((3.0, 0.0, 0.0), (1.5, 0.0, 0.0)), [-1.5, 0, 0], atol=1e-6)


def test_it_tells_the_turn_to_the_way_and_the_one_at_its_end():
    first = np.arctan2(1.0, 1.0)
    away, before, after = course((1.8, 0.0, 0.3), (2.8, 1.0, 1.0))
    share = 2.0 / (2.0 + BLUR**2)
    assert away == pytest.approx(2**0.5)
    assert before == pytest.approx(share * (first - 0.3) + (1 - share) * (1.0 - 0.3), abs=1e-6)
    assert after == pytest.approx(share * (1.0 - first), abs=1e-6)


def test_at_the_goals_place_the_turn_to_its_angle_is_left():
    np.testing.assert_allclose(course((2.0, 1.0, 0.4), (2.0, 1.0, -0.2)), [0, -0.6, 0], atol=1e-6)


def test_beside_the_goal_it_says_which_end_is_to_turn_to_it():
    # As far ahead as behind is where it changes its mind: a network is not to find the edge itself.
    before, behind = (course((2.0 + x, 1.0, 0.0), (2.0, 1.3, 0.0)) for x in (-0.01, 0.01))
    assert before[0] > 0 > behind[0]
    assert before[1] > 0 > behind[1]


@settings(deadline=None, max_examples=50)
@given(st.floats(1.8, 3), st.floats(-2, 2), turns, st.floats(1.8, 3), st.floats(-2, 2), turns)
def test_what_it_tells_is_what_the_distance_counts(x, y, turn, goal_x, goal_y, goal_turn):
    pose, goal = (x, y, turn), (goal_x, goal_y, goal_turn)
    told = course(pose, goal)
    away = abs(told[0]) if abs(told[0]) < RANGE else np.hypot(goal_x - x, goal_y - y)
    share = away**2 / (away**2 + BLUR**2)
    between = np.pi - (np.pi - (goal_turn - turn)) % (2 * np.pi)
    before = told[1] - (1 - share) * between  # of it, what is to the way
    counted = away + 0.5 * (abs(before) + abs(told[2]) + (1 - share) * abs(between))
    task = WalkerAvoidTask()
    plan = CORE.conditions.plan
    found = task.way(plan, np.array([pose]), np.array([goal]))[0]
    assert counted == pytest.approx(found, abs=1e-3)


def test_round_an_obstacle_it_leads_to_a_corner():
    obs, _ = CORE.reset(seed=range(1))
    assert CORE.transition is not None
    pose, goal = CORE.transition.next_state.pose, CORE.transition.next_state.goal
    straight = np.arctan2(goal[0, 1] - pose[0, 1], goal[0, 0] - pose[0, 0])
    ahead = np.pi - (np.pi - (straight - pose[0, 2])) % (2 * np.pi)
    assert abs(obs[0, 0, CORE.observation.blocks["course"]][1] - ahead) > 0.2


def test_who_is_not_told_the_goal_reads_no_way():
    core = Transport(config=find_config(AVOID, {"observe": ("course",)}))
    obs, _ = core.reset(seed=0)
    assert obs[0, 0].all()
    assert not obs[0, 1].any()


def test_no_word_of_sensing_brings_it_but_its_name_does():
    assert COURSE.name not in BLOCKS
    walker = find_config(AVOID, {"sensing": "own"})
    assert NEAREST in walker.observe
    assert COURSE not in walker.observe
    assert COURSE in find_config(AVOID, {"observe": ("goal", "course")}).observe


def test_it_stays_through_json():
    config = find_config(AVOID, {"observe": ("goal", coopenv.Sensor("course", noise=0.1))})
    assert TransportConfig.from_json(config.to_json()) == config
    assert replace(config, horizon=7).observe == config.observe
