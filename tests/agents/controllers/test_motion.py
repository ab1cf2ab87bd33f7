"""Scripted controllers of hands: every task is done, and nothing is loaded from within."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import Body, Hands, Ranges, Transport, TransportConfig
from coopenv.agents.controllers import MotionController, find_controller, find_guide
from coopenv.agents.controllers.hand_motions import REACH, HandMotions, paced
from coopenv.agents.evaluate import evaluate
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from coopenv.wrench import grasp_matrix
from tests.helpers import NEVER, TRIO

IDS = ("BeamTransport", "BeamDoorway", "BeamTracking", "BeamLift", "WalkerTurn", "WalkerAvoid")
ASKEW = ((-0.7, 0.05), (0.9, -0.02))
HANDS = Hands(stiffness=(150.0, 80.0), damping=(30.0, 20.0), torque_damping=(5.0, 3.0))


def seen(env, episodes=60, **keywords):
    config = find_config(f"coopenv/{env}-v0", {"action": "motion", **keywords})
    return evaluate(find_controller(config), config, episodes=episodes, num_worlds=episodes)


@pytest.mark.parametrize("env", IDS)
def test_hands_do_every_task_and_none_loads_the_object_from_within(env):
    result = seen(env)
    assert result.success_rate >= 0.95
    assert result.relative_cost < 1e-3
    assert result.internal_force_level < 0.02  # [N]


@pytest.mark.parametrize(
    ("env", "keywords"),
    [
        ("BeamTransport", {"body": Body(mass=20.0), "horizon": 400}),
        ("BeamDoorway", {"body": TRIO}),
        ("BeamDoorway", {"hands": Hands(torque_stiffness=0.0, torque_damping=0.0)}),
        ("BeamLift", {"hands": Hands(stiffness=(150.0, 80.0), damping=(30.0, 20.0))}),
        ("BeamTracking", {"hands": Hands(stiffness=40.0, damping=10.0)}),
        ("WalkerTurn", {"action": "impedance"}),
        (
            "BeamTransport",
            {
                "action": "impedance",
                "hands": Hands(stiffness_factors=(1.0, 4.0), damping_factors=(0.3, 1.0)),
                "randomise": Ranges(stiffness=(80.0, 200.0), mass=(6.0, 12.0)),
                "substeps": 8,
            },
        ),
    ],
    ids=["heavy", "trio", "ball joints", "uneven", "soft", "impedance on wheels", "drawn"],
)
def test_other_hands_do_the_tasks_as_well(env, keywords):
    result = seen(env, 40, **keywords)
    assert result.success_rate >= 0.95
    assert result.relative_cost < 1e-3


def anchored(**keywords) -> Transport:
    """Worlds whose object hardly moves, whatever pulls at it."""
    body = Body(mass=1e7, inertia=1e7, grips=ASKEW)
    limits = {"force_limit": 80.0, "torque_limit": 20.0}
    core = Transport(num_worlds=4, task=NEVER, body=body, **limits, **keywords)
    core.reset(seed=0)
    return core


@pytest.mark.parametrize("action", ["motion", "impedance"])
def test_a_hand_gives_in_the_mean_of_a_step_what_is_wanted_of_it(action):
    core = anchored(action=action, hands=HANDS)
    motions, generator = HandMotions(core.config, (0, 1)), np.random.default_rng(0)
    wanted = np.zeros((4, 2, 3))
    for _ in range(12):  # from stretches that the steps before left
        wanted = wanted + generator.uniform(-1, 1, wanted.shape) * (8.0, 8.0, 1.0)
        assert core.transition is not None
        action_given = motions(wanted, np.zeros((4, 3)), core.transition)
        assert np.abs(action_given).max() < 1
        core.step(action_given)
        np.testing.assert_allclose(core.transition.applied, wanted, atol=1e-4)
    assert np.abs(wanted).max() > 10


def test_where_one_hand_would_be_too_fast_all_go_the_same_part_of_the_way():
    core = anchored(action="motion", hands=HANDS)
    motions = HandMotions(core.config, (0, 1))
    first = np.tile([(5.0, -3.0, 1.0), (2.0, 4.0, 0.5)], (4, 1, 1))
    wanted = first + np.array([(60.0, 10.0, 2.0), (-5.0, 1.0, -0.5)])
    assert core.transition is not None
    core.step(motions(first, np.zeros((4, 3)), core.transition))
    actions = motions(wanted, np.zeros((4, 3)), core.transition)
    np.testing.assert_allclose(np.abs(actions).max(axis=(1, 2)), 1.0)
    # The spring's part is there at once, the damper's is taken up anew: what is given without
    # moving is where the way begins.
    springs = motions.springs(core.team.hands)
    assert core.transition.stretch is not None
    there = springs[..., [0, 0, 1]] * core.transition.stretch
    core.step(actions)
    part = (core.transition.applied - there) / (wanted - there)
    np.testing.assert_allclose(part, np.broadcast_to(part[:1, :1, :1], part.shape), atol=1e-5)
    assert 0.1 < part.mean() < 0.9


@pytest.mark.parametrize("wheels", [False, True])
def test_parts_are_those_of_one_rigid_plan_and_make_the_whole(wheels):
    config = TransportConfig(action="motion", hands=HANDS, body=Body(grips=ASKEW))
    core = Transport(num_worlds=2, config=config)
    motions, team = HandMotions(config, (0, 1)), core.team
    parts = motions.parts(team.grips, team.hands, np.full(2, wheels))[0]
    grasp = grasp_matrix(np.array(ASKEW))
    felt = [0, 2] if wheels else [0, 1, 2]
    whole = grasp @ parts.reshape(6, 3)
    np.testing.assert_allclose(whole[np.ix_(felt, felt)], np.eye(len(felt)), atol=1e-12)
    reply = np.array([30 + 150 / 40, 30 + 150 / 40, 5 + 20 / 40, 22.0, 22.0, 3 + 20 / 40])
    moved = parts.reshape(6, 3) / reply[:, None]  # velocities of the hands against their grips
    plan = np.linalg.lstsq(grasp.T, moved, rcond=None)[0]
    np.testing.assert_allclose(grasp.T @ plan, moved, atol=1e-12)
    if wheels:
        np.testing.assert_allclose(parts[..., 1], 0.0, atol=1e-12)
        np.testing.assert_allclose(plan[1], 0.0, atol=1e-12)


VELOCITY = st.floats(-3, 3)


@settings(max_examples=50)
@given(VELOCITY, VELOCITY, VELOCITY, st.floats(-4, 4))
def test_a_plan_is_slowed_down_to_the_slowest_hand_and_keeps_its_path(vx, vy, spin, angle):
    hands = Hands(speed=(1.0, 0.4), turn_rate=(2.0, 0.9)).table(2)[None, :, 4:]
    wanted = np.array([[vx, vy, spin]])
    slowed = paced(wanted, np.array([[3.0, 2.0, angle]]), np.array([ASKEW]), hands)
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * slowed[0, 0] + s * slowed[0, 1], c * slowed[0, 1] - s * slowed[0, 0]
    grips, turn = np.array(ASKEW), abs(slowed[0, 2])
    speeds = np.hypot(x - slowed[0, 2] * grips[:, 1], y + slowed[0, 2] * grips[:, 0])
    used = max(*(speeds / (1.0, 0.4)), turn / 2.0, turn / 0.9)
    assert used <= REACH + 1e-9
    share = slowed[0] @ wanted[0] / max(wanted[0] @ wanted[0], 1e-300)
    np.testing.assert_allclose(slowed, share * wanted, atol=1e-9)
    if share < 0.999 and np.abs(wanted).max() > 1e-3:
        assert used >= REACH - 1e-9  # and no slower than it must


def test_beside_a_partner_it_moves_the_learner_alone_and_is_free_of_the_batch():
    config = TransportConfig(action="motion", partner="impedance")
    core = Transport(num_worlds=3, config=config)
    obs, _ = core.reset(seed=0)
    controller, whole = find_controller(config), find_controller(TransportConfig(action="motion"))
    assert core.transition is not None
    actions = controller(obs, core.transition)
    assert actions.shape == (3, 1, 3)
    assert isinstance(controller, MotionController)
    np.testing.assert_allclose(actions, whole(obs, core.transition)[:, :1], atol=1e-12)


def test_options_that_only_wrenches_have_are_refused():
    config = TransportConfig(action="impedance")
    with pytest.raises(InvalidInput, match="options must be gains alone for action='impedance'"):
        find_controller(config, method="nonsqueezing")
    gains = find_guide(config).gains
    assert find_controller(config, gains=gains).gains is gains
