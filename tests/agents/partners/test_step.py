"""One step of a partner by hand: what it feels, wants and gives, within whose limits."""

from math import exp, pi

import numpy as np
import pytest

from coopenv import Body, Transport
from coopenv.agents.controllers.guidance import Gains, gains_row
from coopenv.agents.partners import Leader, Noisy, hands, traits

DT = 0.1  # [s]
MASS, INERTIA, DRAG, SPIN_DRAG = 2.0, 3.0, 4.0, 5.0
GRIPS = [[-0.4, 0.2], [0.5, 0.25]]  # [m]
APPLIED = [[9.0, 9.0, 9.0], [2.0, -1.0, 0.5]]  # [N, N·m]; who feels knows only its own, agent 1's
# Each agent's part of an object wrench; forces and torque mix
PARTS = np.array(
    [[[0.5, 0, 0], [0, 0.5, 1], [0, 0.25, 0]], [[0.5, 0, 0], [0, 0.5, -1], [0, 0, 0.5]]]
)


def stepped(
    role, *, pose, twist, before, ahead=(0.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0), wanted=(0, 0, 0),
    limits=((1e3, 1e3), (1e3, 1e3)), driven=(1,), gravity=(0.0, 0.0), hands_as=None, **columns,
):  # fmt: skip
    """Wrenches ``(driven, 3)`` of one step in one world, and the partner's mind after it."""
    rows = traits.same_twice(1, role=role, **columns)
    rows[..., traits.GAINS : traits.GAINS + 6] = gains_row(Gains(approach=2.0, damping=5.0))
    count = len(driven)
    mind = hands.Mind(
        traits=rows, keys=np.zeros(1, np.uint64), now=np.zeros(1, np.int64),
        steps=np.zeros(1, np.int64), wanted_twist=np.array([wanted], dtype=float),
        given=np.zeros((1, 1, count, 3)),
    )  # fmt: skip
    seen = [np.array([each], dtype=float) for each in (pose, twist, before, goal, ahead)]
    outline = np.array([[(-0.5, -0.1), (0.5, -0.1), (0.5, 0.1), (-0.5, 0.1)]])
    load = [np.array([each]) for each in (MASS, INERTIA, DRAG, SPIN_DRAG)]
    frame = np.array([[(1.0, 0.0), (0.0, 1.0)]])  # agent 1 looks along the object's y
    nothing = np.zeros((1, 0, 3))
    stretch, springs, fastest = hands_as or (nothing, nothing, nothing)
    out = hands.act(
        tuple(mind),
        (*seen, np.array([APPLIED]), stretch),
        (*load, outline, np.array([0.51]), np.array([(20.0, 20.0)]), np.array([gravity])),
        (np.array([GRIPS]), frame, np.array([limits]), PARTS[None], 2 * PARTS[None],
         np.array(driven), springs, fastest),
        DT,
    )  # fmt: skip
    return out[0], mind


# M v̇ + D v = (10 + 3, 20 + 6) N and 6 + 1.5 N·m. It heads along y in between, so that is (26, −13)
# N in its frame, of which its own hand gave (2, −1) N and −0.5 − 0.5 + 0.5 N·m.
TURNING = {"pose": (0, 0, pi / 2 + 0.015), "twist": (1, 2, 0.4), "before": (0.5, 1, 0.2)}
STRAIGHT = {"pose": (0, 0, pi / 2), "twist": (1, 2, 0), "before": (0.5, 1, 0)}  # (24, −12), 0.5


def test_who_shares_feels_what_is_not_its_own_and_carries_its_share_at_its_grip():
    given, mind = stepped(traits.SHARES, **TURNING, share=0.2)
    # A quarter of (24, −12, 8), whose force turns the object by −1.5 − 1.5 N·m at (0.5, 0.25)
    np.testing.assert_allclose(given, [[6, -3, 2 + 3]], rtol=1e-12)
    np.testing.assert_array_equal(mind.wanted_twist, [[1, 2, 0.4]])  # it has no motion of its own
    assert mind.steps.tolist() == [1]


def test_two_hands_share_what_both_do_not_give():
    given, _ = stepped(traits.SHARES, **TURNING, share=0.5, driven=(0, 1))
    # Of (26, −13, 7.5) both hands gave (11, 8) N and −0.5 and −0.4 · 9 − 0.2 · 9 + 9 N·m.
    felt = np.array([15.0, -21.0, 7.5 + 0.5 - 3.6])
    each = felt / 2
    levers = np.array([-0.4 * each[1] - 0.2 * each[0], 0.5 * each[1] - 0.25 * each[0]])
    wanted = np.column_stack([np.tile(each[:2], (2, 1)), each[2] - levers])
    np.testing.assert_allclose(given, wanted, rtol=1e-12)


def test_who_follows_lets_a_lighter_object_answer_and_gives_its_part_of_what_the_real_one_needs():
    taste = {"heaviness": 0.5, "eagerness": 10.0, "wanted": (0.3, -0.2, 0.1)}
    given, mind = stepped(traits.FOLLOWS, **STRAIGHT, **taste)
    left, turn_left = exp(-DRAG / MASS * DT), exp(-SPIN_DRAG / INERTIA * DT)
    gain, turn_gain = (1 - left) / DRAG / 0.5, (1 - turn_left) / SPIN_DRAG / 0.5
    # (24, −12) N of the object are (12, 24) N of the world.
    vx, vy = 0.3 * left + 12 * gain, -0.2 * left + 24 * gain
    omega = 0.1 * turn_left + 0.5 * turn_gain
    np.testing.assert_allclose(mind.wanted_twist, [[vx, vy, omega]], rtol=1e-12)
    fx, fy = DRAG * vx + MASS * 10 * (vx - 1), DRAG * vy + MASS * 10 * (vy - 2)
    torque = SPIN_DRAG * omega + INERTIA * 10 * omega
    np.testing.assert_allclose(given, [PARTS[1] @ (fy, -fx, torque)], rtol=1e-12)


@pytest.mark.parametrize("role", [traits.PLANS, traits.WALKS])
def test_who_plans_leads_to_its_plan_and_who_walks_to_the_next_point_of_its_way(role):
    still = {"pose": (1, 1, 0), "twist": (0.1, -0.2, 0.3), "before": (7, 7, 7)}
    where = {"goal": (0.9, 1.3, 0.2), "away_x": 0.2, "away_y": -0.1, "away_turn": -0.3}
    given, mind = stepped(role, **still, **where, ahead=(0.7, 1.1, 0.4), strength=1.5)
    target = np.array([1.1, 1.2, -0.1] if role == traits.PLANS else [0.7, 1.1, 0.4])
    twist = np.array([0.1, -0.2, 0.3])
    missing = 2.0 * (target - (1, 1, 0)) - twist
    wrench = 1.5 * (5.0 * missing * (MASS, MASS, INERTIA) + twist * (DRAG, DRAG, SPIN_DRAG))
    part = PARTS[1] * (2 if role == traits.WALKS else 1)
    np.testing.assert_allclose(given, [part @ wrench], rtol=1e-9)
    np.testing.assert_array_equal(mind.wanted_twist, [twist])


@pytest.mark.parametrize(
    ("limits", "part"),
    [
        (((1e3, 1e3), (1e3, 1e3)), 1.0),
        (((3.0, 1e3), (1e3, 1e3)), 3 / 10),  # agent 0 is to give (6, 10, 4)
        (((1e3, 1.0), (1e3, 1e3)), 1 / 4),
        (((1e3, 1e3), (3.0, 1e3)), 1 / 2),  # agent 1 is to give (6, 6, 1), seen from it (6, −6)
        (((1e3, 1e3), (1e3, 0.1)), 1 / 10),
        (((5.0, 2.5), (2.0, 0.5)), 1 / 3),
    ],
)
def test_whoever_meets_a_limit_all_are_scaled_down_by_the_same(limits, part):
    still = {"pose": (1, 1, 0), "twist": (0, 0, 0), "before": (0, 0, 0)}
    # Led by 10 · missing · (M, M, J) to a wrench of (12, 8 · 2, 2) N, N·m
    goal = np.array([1, 1, 0]) + np.array([12 / MASS, 16 / MASS, 2 / INERTIA]) / 10
    given, _ = stepped(traits.PLANS, **still, goal=goal, limits=limits, driven=(0, 1))
    whole = np.array([[6, 10, 4], [6, 6, 1]])
    np.testing.assert_allclose(given, part * whole, rtol=1e-9)


@pytest.mark.parametrize("agent", [0, 1])
def test_a_partner_is_held_to_the_limit_of_its_own_agent(agent):
    strong = Noisy(partner=Leader(), force=500.0, torque=500.0)
    core = Transport(
        num_worlds=30, partner=strong, partner_agents=(agent,), body=Body(),
        force_limit=(3.0, 20.0), torque_limit=(7.0, 0.5),
    )  # fmt: skip
    core.reset(seed=0)
    core.step(np.ones((30, 1, 3)))
    assert core.transition is not None
    largest = np.abs(core.transition.applied).max(axis=0)
    wanted = [[3.0, 3.0, 7.0], [20.0, 20.0, 0.5]]
    np.testing.assert_allclose(largest, wanted, rtol=1e-12)  # of the learner too, who gave 1


def test_the_same_key_shakes_a_hand_alike_in_every_version():
    given, _ = stepped(
        traits.SHARES, pose=(0, 0, 0), twist=(0, 0, 0), before=(0, 0, 0), share=0.0,
        force_noise=1.0, torque_noise=2.0,
    )  # fmt: skip
    np.testing.assert_allclose(given, [[-0.61620451, -0.30034387, 2.17669195]], rtol=1e-7)


def test_two_unsteady_hands_are_unsteady_each_by_itself():
    hand = Noisy(partner=Leader(strength=1e-9), force=1.0, torque=2.0)
    core = Transport(num_worlds=400, partner=hand, partner_agents=(0, 2), body=Body(
        grips=((-0.9, 0.0), (0.0, 0.0), (0.9, 0.0))))  # fmt: skip
    core.reset(seed=0)
    core.step(np.zeros((400, 1, 3)))
    assert core.transition is not None
    noise = core.transition.applied[:, [0, 2]].reshape(400, 6)
    np.testing.assert_allclose(noise.std(axis=0), [1, 1, 2] * 2, rtol=0.15)
    assert np.abs(np.corrcoef(noise.T) - np.eye(6)).max() < 0.2


STIFF, TURN_STIFF, DAMPED, TURN_DAMPED = 100.0, 10.0, 20.0, 4.0
REPLY = np.array([DAMPED + STIFF * DT / 2] * 2 + [TURN_DAMPED + TURN_STIFF * DT / 2])
SPRING = np.array([STIFF, STIFF, TURN_STIFF])
STRETCH = np.array([0.03, -0.01, 0.2])
STILL = {"pose": (0, 0, 0), "twist": (0, 0, 0), "before": (0, 0, 0)}


def held(stretch=STRETCH, speed=10.0):
    """What the hands of both agents sense, their springs and how fast they are; alike."""
    springs = [[(STIFF, TURN_STIFF, DAMPED, TURN_DAMPED)] * 2]
    rows = ([[stretch] * 2], springs, [[(speed, speed)] * 2])
    return tuple(np.array(row, dtype=float) for row in rows)


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (1.0, -3.0)])
def test_who_gives_way_goes_with_its_grip_and_away_from_what_it_feels_beyond_its_weight(gravity):
    given, mind = stepped(
        traits.YIELDS, **STILL, gravity=gravity, hands_as=held(), yielding=0.02, turn_yielding=0.1
    )
    weight = PARTS[1] @ (-MASS * gravity[0], -MASS * gravity[1], 0)
    away = (given[0] - SPRING * STRETCH) / REPLY
    in_the_end = SPRING * (STRETCH + away * DT) + np.array([DAMPED, DAMPED, TURN_DAMPED]) * away
    np.testing.assert_allclose(away, -np.array([0.02, 0.02, 0.1]) * (in_the_end - weight))
    assert mind.steps.tolist() == [1]


def test_who_gives_way_goes_as_its_grip_will_go_in_the_middle_of_the_step():
    """A half of what the grip at (0.5, 0.25) gained in the last step, as the object lies."""
    gained = {"pose": (0, 0, pi / 2), "twist": (1, 2, 0.4), "before": (0.6, 1.5, 0.2)}
    given, _ = stepped(
        traits.YIELDS, **gained, hands_as=held(np.zeros(3)), yielding=0.02, turn_yielding=0.1
    )
    beside = np.array([0.25 - 0.1 * 0.25, -0.2 + 0.1 * 0.5, 0.1])
    np.testing.assert_allclose(given, [REPLY * beside], rtol=1e-12)


def guided(stretch, *, ahead, twist=(0, 0, 0), speed=10.0, **columns):
    """By how much who guides stretches its hand in a step, as one that goes so beside its grip."""
    taste = {"lead": 0.5, "turn_lead": 0.6, "easing": 2.0, **columns}
    sensed = held(stretch, speed=speed)
    still = {**STILL, "twist": twist}
    given, _ = stepped(traits.GUIDES, **still, ahead=ahead, hands_as=sensed, **taste)
    return (given[0] - SPRING * stretch) / REPLY * DT


def test_who_guides_goes_on_along_its_way_and_lets_its_lead_fade():
    # Twice the way (0.2, -0.1, 0.15) is wanted; the grip is at (0.5, 0.25)
    more = guided(STRETCH, ahead=(0.2, -0.1, 0.15))
    lacking = np.array([0.4 - 0.3 * 0.25, -0.2 + 0.3 * 0.5, 0.3])
    np.testing.assert_allclose(more, DT * (lacking - 2.0 * STRETCH), rtol=1e-9)
    follows = guided(STRETCH, ahead=(0.2, -0.1, 0.15), twist=(0.4, -0.2, 0.3))
    np.testing.assert_allclose(follows, -DT * 2.0 * STRETCH, rtol=1e-9)  # then it only fades


def test_who_guides_pulls_no_farther_than_its_lead():
    far = np.array([0.3, -0.4, 0.59])
    more = guided(far, ahead=(3.0, -4.0, 3.0), easing=0.0)
    after = far + more
    assert np.hypot(*after[:2]) == pytest.approx(0.5)
    assert after[2] == pytest.approx(0.6)


def test_who_guides_goes_no_faster_than_the_slowest_hand_can_follow():
    slow = guided(np.zeros(3), ahead=(1.0, 0.0, 0.0), speed=0.5)
    np.testing.assert_allclose(slow, [0.8 * 0.5 * DT, 0.0, 0.0], atol=1e-12)
