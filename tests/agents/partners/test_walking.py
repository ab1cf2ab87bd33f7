"""Partners that know the way, and which agent a partner is where nobody says."""

import json
from dataclasses import asdict, fields, replace

import numpy as np
import pytest

from coopenv import Body, DoorwayTask, TrackingTask, Transport, TransportConfig, TransportTask
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.partners import (
    Follower,
    Impedance,
    Lagging,
    Population,
    Robot,
    Switching,
    Walking,
    default_partner,
    find_partner,
)
from coopenv.agents.partners.traits import DELAY
from coopenv.agents.partners.way import PACE
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.studies.dyads.people import People
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import IDS, LEVEL, TRIO, actions, side_by_side

BEAMS = tuple(name for name in IDS if "Beam" in name)
WALKERS = tuple(name for name in IDS if "Walker" in name)
EVERY_ID = pytest.mark.parametrize("view", IDS)


def succeeded(view, partner, *, episodes=60, **keywords) -> float:
    """How often the scripted controller succeeds as the learner beside a partner."""
    config = find_config(view, {"partner": partner, **keywords})
    return run_episodes(find_controller(config), config, episodes=episodes).success.mean()


@EVERY_ID
def test_a_partner_of_a_walker_is_the_human_and_of_a_beam_its_last_agent(view):
    config = find_config(view, {"partner": "leader"})
    assert (config.driven, config.learners) == (((0,), (1,)) if view in WALKERS else ((1,), (0,)))
    other = find_config(view, {"partner": "leader", "partner_agents": config.learners})
    assert other.driven == config.learners


@EVERY_ID
def test_who_is_needed_and_not_named_knows_wheels(view):
    name = "walking" if view in WALKERS else "impedance"
    assert default_partner(find_config(view, {})) == name
    chosen = TrainConfig(control="partner", environment=EnvironmentChoice(env=view))
    assert chosen.environment.partner == name


@EVERY_ID
def test_the_default_partner_is_there_for_who_learns_beside_it(view):
    pytest.importorskip("stable_baselines3")
    from coopenv.agents import sb3

    venv = sb3.make_vec_env(view, num_worlds=1, control="partner")
    named = find_partner(default_partner(find_config(view, {})))
    assert venv.transport.config.partner == named
    assert venv.transport.learners == ((1,) if view in WALKERS else (0,))


@pytest.mark.parametrize("view", WALKERS)
def test_beside_the_default_partner_of_a_walker_the_scripted_drive_succeeds(view):
    """500 of 500 episodes; where the drive was the partner, 2 % and none."""
    assert succeeded(view, default_partner(find_config(view, {}))) >= 0.95


@pytest.mark.parametrize(
    ("view", "partner"),
    [*((view, "walking") for view in LEVEL), *((view, "robot") for view in IDS)],
)
def test_who_knows_the_way_and_the_scripted_learner_succeed(view, partner):
    assert succeeded(view, partner) >= 0.95


@pytest.mark.parametrize("view", WALKERS)
def test_a_robot_can_be_the_drive(view):
    assert succeeded(view, "robot", partner_agents=(1,)) >= 0.95


def test_who_heads_straight_is_held_up_by_a_doorway_and_who_knows_the_way_is_not():
    assert succeeded("coopenv/BeamDoorway-v0", "impedance") < 0.7
    assert succeeded("coopenv/BeamDoorway-v0", Robot()) >= 0.95


@pytest.mark.parametrize("view", WALKERS)
def test_a_human_pushes_along_the_heading_and_leaves_the_turning_to_the_drive(view):
    core = Transport(num_worlds=8, config=find_config(view, {"partner": "robot"}))
    core.reset(seed=0)
    for _ in range(20):
        core.step(np.zeros((8, 1, 3)))
        assert core.transition is not None
        assert not core.transition.applied[:, 0, 1:].any()
        assert core.transition.applied[:, 0, 0].any()


def test_a_robot_does_its_part_of_what_the_controller_would():
    """Its own part, led at the same pace: hardly anything is internal, through the gap as well."""
    for view in ("coopenv/BeamTransport-v0", "coopenv/BeamDoorway-v0"):
        config = find_config(view, {"partner": "robot"})
        seen = run_episodes(find_controller(config, gains=PACE), config, episodes=20)
        assert np.median(seen.relative_cost) < 1e-9
        assert seen.relative_cost.max() < 0.01  # near walls, which it keeps off once more
        assert seen.success.mean() >= 0.95


@EVERY_ID
def test_the_same_seed_gives_the_same_bits_and_a_world_walks_alone(view):
    many = find_config(view, {"partner": "walking", "horizon": 25})
    five, again, one = (Transport(num_worlds=n, config=many) for n in (5, 5, 1))
    five.reset(seed=4)
    again.reset(seed=4)
    one.reset(seed=6)
    for _ in side_by_side(five, again, one, actions(1, 40, 5, 1, 3)):
        assert five.transition is not None
        assert one.transition is not None
        np.testing.assert_allclose(five.transition.applied[2], one.transition.applied[0], atol=1e-6)


@EVERY_ID
def test_its_plan_is_the_goal_and_nobody_disagrees(view):
    core = Transport(num_worlds=3, config=find_config(view, {"partner": "walking"}))
    _, info = core.reset(seed=0)
    for _ in range(3):
        assert core.transition is not None
        np.testing.assert_array_equal(info["partner_plan"], core.transition.next_state.goal)
        assert info["partner_has_plan"].all()
        assert not info["disagreement"].any()
        *_, info = core.step(np.zeros((3, 1, 3)))


def test_people_of_any_strength_drop_what_has_to_be_lifted_exactly_and_a_robot_does_not():
    assert succeeded("coopenv/BeamLift-v0", "walking") < 0.7
    assert succeeded("coopenv/BeamLift-v0", Walking(strength=1.0)) >= 0.95


@pytest.mark.parametrize("view", [view for view in BEAMS if view in LEVEL])
def test_a_plan_of_its_own_is_told_and_is_where_the_way_leads(view):
    """Alone, it arrives at its own plan; along a reference, it keeps beside it."""
    task = find_config(view, {}).task
    assert isinstance(task, TransportTask | DoorwayTask | TrackingTask)
    never = replace(task, position_tolerance=1e-9)
    keywords = {"partner": Robot(offset=0.2), "task": never, "horizon": 1000}
    core = Transport(num_worlds=10, config=find_config(view, keywords))
    _, info = core.reset(seed=0)
    np.testing.assert_allclose(info["disagreement"], 0.2, atol=1e-9)
    for _ in range(600):
        *_, info = core.step(np.zeros((10, 1, 3)))
    assert core.transition is not None
    away = info["partner_plan"] - core.transition.next_state.pose
    assert np.median(np.hypot(*away[:, :2].T)) < 0.02


def test_people_differ_from_episode_to_episode_within_their_ranges():
    core = Transport(num_worlds=300, partner=Walking(delay=(1, 3)), horizon=4)
    core.reset(seed=0)
    player = core.driven.player  # pyright: ignore[reportAttributeAccessIssue]
    first = player._mind.traits.copy()
    assert set(first[:, 0, DELAY]) == {1, 2, 3}
    core.reset()
    assert (player._mind.traits[:, 0] != first[:, 0]).any(axis=1).all()


def test_they_are_the_simulated_people_of_the_study():
    """The same ranges; the delay in control steps of 0.05 s."""
    study, person = People(), Walking()
    shared = {entry.name for entry in fields(person)} & {entry.name for entry in fields(study)}
    assert shared - {"delay"} == {
        "approach", "damping", "speed", "spin", "strength", "force_tremor", "torque_tremor"
    }  # fmt: skip
    for name in shared - {"delay"}:
        assert getattr(person, name) == getattr(study, name)
    assert person.delay == tuple(round(end / 0.05) for end in study.delay)


def test_they_are_plain_numbers_and_compare_by_them():
    for partner in (Walking(), Walking(offset=(0.1, 0.3), delay=1), Robot(), Robot(turn=0.2)):
        written = json.dumps(asdict(partner))
        assert type(partner)(**json.loads(written)) == partner
        assert hash(type(partner)(**json.loads(written))) == hash(partner)
    assert Walking() != Robot()
    assert TransportConfig(partner="walking") == TransportConfig(partner=Walking())


def test_they_combine_with_others_and_act_as_they_do_by_themselves():
    members = (Robot(), Impedance(), Lagging(partner=Robot(), delay=2))  # who draws nothing
    view = "coopenv/BeamDoorway-v0"
    mixed = Transport(
        num_worlds=24, config=find_config(view, {"partner": Population(members=members)})
    )
    _, info = mixed.reset(seed=0)
    alone = {
        number: Transport(num_worlds=24, config=find_config(view, {"partner": member}))
        for number, member in enumerate(members)
    }
    for core in alone.values():
        core.reset(seed=0)
    for _ in range(15):
        mixed.step(np.zeros((24, 1, 3)))
        assert mixed.transition is not None
        for number, core in alone.items():
            core.step(np.zeros((24, 1, 3)))
            assert core.transition is not None
            mine = info["partner_kind"] == number
            assert mine.any()
            np.testing.assert_allclose(
                mixed.transition.applied[mine], core.transition.applied[mine], atol=1e-9
            )


def test_who_switches_between_walking_and_following_has_a_plan_only_while_it_walks():
    partner = Switching(first=Walking(), second=Follower(), mean_time=0.5)
    core = Transport(
        num_worlds=40, config=find_config("coopenv/BeamDoorway-v0", {"partner": partner})
    )
    core.reset(seed=0)
    planned = []
    for _ in range(40):
        *_, info = core.step(np.zeros((40, 1, 3)))
        planned.append(info["partner_has_plan"])
        assert core.transition is not None
        assert np.isfinite(core.transition.applied).all()
    assert 0.3 < np.mean(planned) < 0.7


def test_who_does_not_walk_needs_no_way():
    """A body that the controller could not lead is no matter to a follower."""
    body = Body.walker(grips=((0.0, 0.0), (0.0, 0.4)))
    keywords = {"body": body, "action": "force", "partner": "leader"}
    config = find_config("coopenv/WalkerTurn-v0", keywords)
    Transport(config=config).reset(seed=0)
    with pytest.raises(InvalidInput, match="must give agent 0 a lever"):
        Transport(config=replace(config, partner=Walking())).reset(seed=0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Walking(strength=0.0), r"partner.strength must be a number from 0.01"),
        (lambda: Walking(speed=(0.9, 0.5)), r"partner.speed must be \(low, high\)"),
        (lambda: Walking(delay=0.1), r"partner.delay must be a whole number"),  # pyright: ignore
        (lambda: Walking(delay=(1, 2.5)), r"partner.delay must be a whole number"),  # pyright: ignore
        (lambda: Walking(turn=4.0), r"partner.turn must be a number from 0 to 3.14"),
        (lambda: Robot(force_tremor=-1.0), r"partner.force_tremor must be a number from 0"),
        (lambda: Robot(approach=np.nan), r"partner.approach must be finite"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(make, said):
    with pytest.raises(InvalidInput, match=said):
        make()


class FirstLearns(TransportTask):
    """A task of somebody's own, in which a partner is everybody but agent 0."""

    def partner_agents(self, num_agents):
        return tuple(range(1, num_agents))


class Nobody(TransportTask):
    def partner_agents(self, num_agents):
        return (num_agents,)


def test_a_task_of_ones_own_says_whom_a_partner_drives():
    assert TransportConfig(task=FirstLearns(), body=TRIO, partner="follower").driven == (1, 2)
    assert TransportConfig(task=FirstLearns(), body=TRIO).driven == ()
    with pytest.raises(InvalidInput, match="partner_agents of the task must name agents 0 to 1"):
        TransportConfig(task=Nobody(), partner="follower")
