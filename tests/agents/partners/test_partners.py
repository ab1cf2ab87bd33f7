"""Every kind of partner does what its name says."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Transport, TransportConfig, TransportTask
from coopenv.agents.controllers.guidance import Outline, gains_row, guiding_twist, object_wrench
from coopenv.agents.controllers.impedance import Gains, ImpedanceController
from coopenv.agents.partners import (
    PARTNERS,
    Follower,
    Impedance,
    Lagging,
    Leader,
    LoadSharing,
    Noisy,
    Population,
    Robot,
    Stubborn,
    Switching,
    Walking,
    find_partner,
)
from coopenv.agents.partners.traits import DELAY
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.partners.cases import acting
from tests.helpers import CLUTTERED, OPEN_ROOM, OPTIONS, TRIO

NEVER = TransportTask(position_tolerance=1e-300)  # not even by those who settle at the goal


class Idle:
    """A learner that holds the object and does nothing."""

    def __call__(self, obs, transition):
        return np.zeros((*obs.shape[:2], 3))


def episode(partner, learner=None, *, worlds=50, steps=60, seed=0, **keywords):
    """Infos, wrenches of the partner and its power in every step: ``(step, world, ...)``."""
    config = TransportConfig(partner=partner, task=NEVER, scene=OPEN_ROOM, **keywords)
    core = Transport(num_worlds=worlds, config=config)
    learner = ImpedanceController(config) if learner is None else learner
    pose = np.zeros((worlds, 3))
    angle = np.random.default_rng(seed).uniform(-np.pi, np.pi, (worlds, 2))
    goal = np.column_stack([2 * np.cos(angle[:, 0]), 2 * np.sin(angle[:, 0]), angle[:, 1] / 3])
    obs, _ = core.reset(seed=seed, pose=pose, goal=goal)
    infos, wrenches, powers = [], [], []
    for _ in range(steps):
        assert core.transition is not None
        obs, *_, info = core.step(learner(obs, core.transition))
        infos.append(info)
        wrenches.append(core.transition.applied[:, 1])
        powers.append(power(core.transition, 1))
    told = {name: np.array([info[name] for info in infos]) for name in infos[0]}
    return core, told, np.array(wrenches), np.array(powers)


def power(transition, agent):
    """What an agent's wrench does on the object, ``(world,)`` [W], mean over the step."""
    before, after = transition.state, transition.next_state
    angle = before.pose[:, 2] + np.angle(np.exp(1j * (after.pose - before.pose)[:, 2])) / 2
    c, s = np.cos(angle), np.sin(angle)
    fx, fy, torque = transition.applied[:, agent].T
    twist = (before.twist + after.twist) / 2
    x, y = transition.team.grips[:, agent].T
    linear = (c * fx - s * fy) * twist[:, 0] + (s * fx + c * fy) * twist[:, 1]
    return linear + (x * fy - y * fx + torque) * twist[:, 2]


@pytest.mark.parametrize("partner", [Impedance(), Lagging(delay=0), Noisy(force=0.0, torque=0.0)])
def test_equal_plans_never_fight(partner):
    _, told, *_ = episode(partner, steps=80)
    assert told["relative_cost"].max() < 1e-6
    assert told["internal_force_level"].max() < 1e-6
    assert not told["disagreement"].any()


def test_the_known_disagreement_is_the_offset_that_was_asked_for():
    core, told, *_ = episode(Impedance(offset=(0.1, 0.6), turn=(0.0, 0.4)), worlds=300, steps=1)
    assert core.transition is not None
    goal, plan = core.transition.next_state.goal, told["partner_plan"][0]
    away = np.hypot(*(plan - goal)[:, :2].T)
    turned = np.abs(np.angle(np.exp(1j * (plan - goal)[:, 2])))
    assert away.min() >= 0.1
    assert 0.55 < away.max() <= 0.6
    assert 0.35 < turned.max() <= 0.4
    np.testing.assert_allclose(told["disagreement"][0], away + 0.5 * turned, atol=1e-12)
    directions = np.arctan2(*(plan - goal)[:, 1::-1].T)
    assert np.histogram(directions, 4, (-np.pi, np.pi))[0].min() > 50


def test_a_plan_stays_in_the_room():
    core = Transport(num_worlds=400, partner=Impedance(offset=1.0, turn=1.0))
    _, info = core.reset(seed=0)
    assert core.transition is not None
    plan, goal = info["partner_plan"], core.transition.next_state.goal
    outline = np.array(core.bodies[0].outline)
    c, s = np.cos(plan[:, 2, None]), np.sin(plan[:, 2, None])
    x = plan[:, :1] + c * outline[:, 0] - s * outline[:, 1]
    y = plan[:, 1:2] + s * outline[:, 0] + c * outline[:, 1]
    half = np.array(core.scenes[0].size) / 2
    assert (np.abs(x) <= half[0] + 1e-9).all()
    assert (np.abs(y) <= half[1] + 1e-9).all()
    away = np.hypot(*(plan - goal)[:, :2].T)
    assert (away > 0.999).mean() > 0.9  # mirrored, so that the distance is kept


COMPLIANT = Gains(approach=1.0, damping=5.0)  # 19 N/m a hand: limits are met 0.5 m off the plan


@pytest.mark.parametrize(
    ("turn", "least"),
    [(0.0, 0.8), ((0.0, 0.4), 0.7)],  # measured: F_I 0.90, γ 0.87; with turns 0.82, 0.79
)
def test_disagreement_shows_in_the_internal_force_and_in_the_relative_cost(turn, least):
    """Correlation over 400 episodes of 3 s, the way there included."""
    scripted = ImpedanceController(TransportConfig(), gains=COMPLIANT)
    partner = Impedance(offset=(0.0, 0.4), turn=turn, gains=COMPLIANT)
    _, told, *_ = episode(partner, lambda obs, last: scripted(obs, last)[:, :1], worlds=400)
    known = told["disagreement"][0]
    for name in ("internal_force_level", "relative_cost"):
        measured = told[name].mean(axis=0)
        assert np.corrcoef(known, measured)[0, 1] > least


def where_it_settles(partner):
    """Of the way from the learner's goal to the partner's plan, 0 to 1, once nothing moves."""
    core, told, *_ = episode(partner, worlds=20, steps=300, horizon=300)
    assert core.transition is not None
    state = core.transition.next_state
    assert np.abs(state.twist).max() < 1e-3
    way = told["partner_plan"][-1, :, :2] - state.goal[:, :2]
    moved = state.pose[:, :2] - state.goal[:, :2]
    return (way * moved).sum(axis=1) / (way * way).sum(axis=1)


def test_the_stronger_the_partner_the_nearer_the_object_settles_to_its_plan():
    """A plan to the side is opposed by torques as well, so that the ratio is not quite s/(1+s)."""
    np.testing.assert_allclose(where_it_settles(Impedance(offset=0.05)), 1 / 2, atol=0.03)
    np.testing.assert_allclose(where_it_settles(Leader(offset=0.05)), 0.63, atol=0.05)
    np.testing.assert_allclose(where_it_settles(Stubborn(offset=0.05, turn=0.0)), 0.75, atol=0.08)


def test_the_follower_works_more_when_led_and_the_stubborn_does_not():
    """Work over 3 s: the follower's 0 J idle, 13.3 J led; the stubborn one's 18.1 J and 13.7 J."""
    work = {
        (name, led): episode(name, None if led else Idle(), steps=60)[3].sum(axis=0) * 0.05
        for name in ("follower", "stubborn")
        for led in (False, True)
    }
    assert not work["follower", False].any()
    assert work["follower", True].min() > 2.0
    assert work["stubborn", True].mean() <= work["stubborn", False].mean()


def test_who_leads_a_follower_arrives_sooner_than_alone():
    def left(partner):
        core, *_ = episode(partner, steps=40)
        assert core.transition is not None
        return core.transition.next_state.distance.mean()

    heavy, light = left(Follower(heaviness=1.0)), left(Follower(heaviness=0.4))
    idle = left(LoadSharing(share=0.0))
    assert light < heavy < idle


def test_a_follower_has_no_plan_and_rests_until_it_is_led():
    core, told, wrenches, _ = episode("follower", Idle(), steps=20)
    assert core.transition is not None
    assert not told["partner_has_plan"].any()
    assert not told["disagreement"].any()
    np.testing.assert_array_equal(told["partner_plan"][-1], core.transition.next_state.pose)
    assert not wrenches.any()


def test_a_follower_feels_a_wall_as_it_feels_a_person():
    """Pushed against a wall, it does not go on pushing: it feels that nothing moves."""
    keywords = {"task": NEVER, "horizon": 400}
    core = Transport(partner="follower", **keywords)
    core.reset(seed=0, pose=(1.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0))
    push = np.array([[[1.0, 0.0, 0.0]]])  # along the beam, towards x
    largest = []
    for _ in range(200):
        core.step(push)
        assert core.transition is not None
        largest.append(np.abs(core.transition.applied[0, 1, 0]))
    assert max(largest[:15]) > 1.0
    assert np.mean(largest[-50:]) < 1.0


def test_a_load_sharing_partner_keeps_the_share_it_wants():
    def smooth(obs, transition):
        time = transition.next_state.time[:, None]
        push = np.stack([np.cos(time), np.sin(time), 0.2 * np.cos(2 * time)], axis=-1)
        return 0.3 * push

    for share in (0.2, 0.5, 0.7):
        _, told, *_ = episode(LoadSharing(share=share), smooth, steps=80)
        kept = told["force_load_share"][5:, :, 1]
        assert np.nanmedian(np.abs(kept - share)) < 0.03
    _, told, *_ = episode(Follower(), smooth, steps=80)
    assert np.nanmedian(np.abs(told["force_load_share"][5:, :, 1] - 0.7)) > 0.06


def test_a_lagging_partner_does_what_was_right_some_steps_ago():
    """Driven beside a partner in time, on the same transitions, it gives the same, later."""
    late = Transport(num_worlds=4, partner=Lagging(partner=Leader(offset=0.3), delay=3))
    late.reset(seed=0)
    config = dataclasses.replace(late.config, partner=late.config.partner.partner)  # pyright: ignore
    prompt: Any = config.partner.player(config, 4, (1,))  # pyright: ignore
    assert late.transition is not None
    prompt.reset(np.arange(4), [np.random.default_rng(0)] * 4, late.transition)
    prompt._mind.traits[:] = late.driven.player._mind.traits  # pyright: ignore
    prompt._mind.traits[..., DELAY] = 0
    given, right = [], []
    for _ in range(12):
        right.append(prompt.act(late.transition))
        late.step(np.zeros((4, 1, 3)))
        given.append(late.transition.applied[:, 1:])
    assert not np.any(given[:3])
    np.testing.assert_allclose(given[3:], right[:-3], atol=1e-9)


def test_delays_are_drawn_between_their_bounds():
    core = Transport(num_worlds=200, partner=Lagging(delay=(1, 4)))
    core.reset(seed=0)
    begun = np.full(200, -1)
    for step in range(6):
        core.step(np.zeros((200, 1, 3)))
        assert core.transition is not None
        moves = core.transition.applied[:, 1].any(axis=1)
        begun[moves & (begun < 0)] = step
    assert set(begun) == {1, 2, 3, 4}


def test_noise_has_the_level_that_was_asked_for_and_no_memory():
    noisy = Noisy(partner=LoadSharing(share=0.0), force=1.5, torque=0.4)
    _, _, wrenches, _ = episode(noisy, Idle(), worlds=100, steps=100)
    np.testing.assert_allclose(wrenches.std(axis=(0, 1)), [1.5, 1.5, 0.4], rtol=0.03)
    np.testing.assert_allclose(wrenches.mean(axis=(0, 1)), 0, atol=0.06)
    flat = wrenches.reshape(len(wrenches), -1)
    for other in (flat[1:], np.roll(flat, 3, axis=1)[:-1], np.roll(flat, 1, axis=1)[:-1]):
        assert abs(np.corrcoef(flat[:-1].ravel(), other.ravel())[0, 1]) < 0.03


def test_roles_switch_at_random_times():
    """Times between are memoryless: mean and standard deviation alike, no two worlds the same."""
    partner = Switching(first=Leader(), second=Follower(), mean_time=1.0)
    _, told, *_ = episode(partner, worlds=120, steps=300, horizon=300)
    leads = told["partner_has_plan"]
    assert 0.4 < leads[0].mean() < 0.6  # begins as either
    assert 0.45 < leads.mean() < 0.55
    switched = leads[1:] != leads[:-1]
    times = np.concatenate([np.diff(np.flatnonzero(world)) for world in switched.T]) * 0.05
    assert times.mean() == pytest.approx(1.0, rel=0.1)
    assert times.std() == pytest.approx(1.0, rel=0.2)
    assert len({world.tobytes() for world in switched.T}) == 120
    np.testing.assert_allclose(switched.mean(axis=1).std(), 0.0, atol=0.03)  # no common beat


def test_the_same_seed_switches_roles_at_the_same_times_in_every_version():
    partner = Switching(first=Leader(), second=Follower(), mean_time=1.0)
    leads = episode(partner, worlds=4, steps=40, horizon=300)[1]["partner_has_plan"]
    assert leads[0].tolist() == [True, True, True, False]
    switched = [np.flatnonzero(np.diff(world))[:2] + 1 for world in leads.T]
    assert [steps.tolist() for steps in switched] == [[9, 13], [18, 20], [2, 22], []]


def test_who_switches_to_following_stops_pulling_to_its_plan():
    partner = Switching(first=Leader(), second=Follower(), mean_time=0.5)
    _, told, wrenches, _ = episode(partner, Idle(), worlds=100, steps=40)
    leads = told["partner_has_plan"]
    first = leads[0] & (leads.sum(axis=0) < 40)
    assert first.any()
    force = np.hypot(wrenches[..., 0], wrenches[..., 1])
    # info of step t is of the role in which step t was acted
    assert force[leads].mean() > 2 * force[~leads].mean()


def test_a_population_draws_every_member_as_often_as_it_should():
    members = (Leader(), Follower(), Stubborn())
    core = Transport(num_worlds=600, partner=Population(members=members, weights=(1, 2, 3)))
    _, info = core.reset(seed=0)
    count = np.bincount(info["partner_kind"], minlength=3)
    np.testing.assert_allclose(count / 600, [1 / 6, 1 / 3, 1 / 2], atol=0.06)
    np.testing.assert_array_equal(info["partner_has_plan"], info["partner_kind"] != 1)
    assert (info["disagreement"] > 0).sum() == count[2]
    _, again = core.reset()
    assert (again["partner_kind"] != info["partner_kind"]).mean() > 0.4  # anew every episode


def test_every_kind_that_needs_neither_a_way_nor_hands_is_in_the_population_by_name():
    population = find_partner("population")
    assert isinstance(population, Population)
    named = {type(partner) for partner in PARTNERS.values()} - {Population}
    by_feeling = {type(partner) for partner in PARTNERS.values() if partner.needs_hands}
    assert {type(member) for member in population.members} == named - {Walking, Robot} - by_feeling
    core = Transport(num_worlds=200, partner="population")
    _, info = core.reset(seed=0)
    assert set(info["partner_kind"]) == set(range(len(population.members)))


def test_a_member_of_a_population_acts_as_it_does_by_itself():
    members = (Leader(), Follower(heaviness=0.3), LoadSharing(share=0.3))
    _, told, wrenches, _ = episode(Population(members=members), worlds=30, steps=40)
    for number, member in enumerate(members):
        mine = told["partner_kind"][0] == number
        assert mine.any()
        alone = episode(member, worlds=30, steps=40)[2]
        np.testing.assert_allclose(wrenches[:, mine], alone[:, mine], atol=1e-9)


@pytest.mark.parametrize("name", PARTNERS)
@pytest.mark.parametrize("option", ["forces", "three agents", "five agents", "small heavy body"])
def test_every_kind_can_be_met_in_every_body(name, option):
    keywords = {**OPTIONS[option], **acting(name)}
    core = Transport(num_worlds=2, partner=name, horizon=8, **keywords)
    core.reset(seed=0)
    ended = None
    for _ in range(12):
        shape = (2, len(core.learners), core.action_size)
        step = core.step(np.full(shape, 0.3), restart=ended)
        ended = step[2] | step[3]
        assert np.isfinite(step[0]).all()


def test_several_hands_of_one_partner_do_all_their_parts():
    core, told, *_ = episode("impedance", worlds=4, body=TRIO, partner_agents=(0, 2))
    assert told["relative_cost"].max() < 0.2
    assert core.transition is not None
    assert core.transition.next_state.distance.mean() < 0.5


@pytest.mark.parametrize("scene", [OPEN_ROOM, CLUTTERED])
def test_the_compiled_guidance_is_that_of_the_scripted_controller(scene):
    bodies = (Body(), Body.beam(length=1.2, mass=20.0, linear_drag=0.0), TRIO)
    generator = np.random.default_rng(0)
    for body in bodies:
        config = TransportConfig(body=body, scene=scene)
        gains = Gains(approach=2.0, speed=1.0)
        controller = ImpedanceController(config, gains=gains)
        core = Transport(num_worlds=15, config=config)
        core.reset(seed=1)
        for _ in range(10):
            core.step(generator.uniform(-1, 1, (15, body.num_agents, 3)))
        assert core.transition is not None
        state, load = core.transition.next_state, core.transition.conditions.load
        wanted = controller.object_wrench(core.transition)
        row, size = gains_row(gains), core.transition.conditions.room.size
        for k in range(15):
            weights = (
                load.mass[k], load.inertia[k], load.linear_drag[k], load.angular_drag[k],
                *core.transition.conditions.room.gravity[k],
            )  # fmt: skip
            outline, twist = Outline(load.outline, k, body.reach), state.twist[k]
            lead = guiding_twist(row, state.pose[k], state.goal[k], size[k], outline)
            mine = object_wrench(row, state.pose[k], twist, lead, twist, weights)
            np.testing.assert_allclose(mine, wanted[k], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Impedance(offset=-0.1), r"partner.offset must be a number from 0"),
        (lambda: Impedance(offset=(0.5, 0.1)), r"partner.offset must be \(low, high\)"),
        (lambda: Impedance(turn=4.0), r"partner.turn must be a number from 0 to 3.14"),
        (lambda: Leader(strength=0.0), r"partner.strength must be positive"),
        (lambda: Follower(heaviness=0.0), r"partner.heaviness must be a number from 0.05 to 1"),
        (lambda: LoadSharing(share=1.0), r"partner.share must be a number from 0 to 0.9"),
        (lambda: Lagging(delay=1.5), r"partner.delay must be a whole number"),  # pyright: ignore
        (lambda: Lagging(partner="leader"), r"partner.partner must be a partner"),  # pyright: ignore
        (lambda: Noisy(force=np.nan), r"partner.force must be finite"),
        (lambda: Switching(first=Noisy(partner=Switching())), r"first must not switch itself"),
        (lambda: Switching(mean_time=0.0), r"partner.mean_time must be positive"),
        (lambda: Population(members=()), r"partner.members must be a sequence of partners"),
        (lambda: Population(members=Leader()), r"members must be a sequence of partners"),  # pyright: ignore
        (lambda: Population(members=5), r"members must be a sequence of partners"),  # pyright: ignore
        (lambda: Population(weights=(1.0,)), r"partner.weights must be .* one for each of \d"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(make, said):
    with pytest.raises(InvalidInput, match=said):
        make()


def test_an_unknown_name_suggests_the_nearest():
    with pytest.raises(UnknownName, match=r"partner must be .* did you mean 'stubborn'"):
        find_partner("stuborn")
