"""Agents that somebody else drives: what is left to the learners in every view."""

from dataclasses import dataclass, replace

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from coopenv import (
    Body,
    Transport,
    TransportConfig,
    beam_doorway_v0,
    beam_lift_v0,
    beam_tracking_v0,
    beam_transport_v0,
    walker_avoid_v0,
    walker_turn_v0,
)
from coopenv.agents.controllers import find_controller
from coopenv.agents.partners import PARTNERS, Impedance, Noisy, Population
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.partners.cases import acting
from tests.helpers import EASY, NEVER, TRIO, actions, assert_same, side_by_side

ID = "coopenv/BeamTransport-v0"
TRUTH = {"partner_plan", "partner_has_plan", "disagreement", "partner_kind"}


@dataclass(frozen=True)
class Steady:
    """A partner of somebody else's making: always the same wrench in the object frame."""

    wrench: tuple[float, ...] = (3.0, -2.0, 1.0)

    def player(self, config, num_worlds, agents):
        return SteadyPlayer(np.tile(self.wrench, (num_worlds, len(agents), 1)))


class SteadyPlayer:
    def __init__(self, wrench):
        self.wrench, self.kind = wrench, np.zeros(len(wrench), dtype=np.int64)
        self.asked = 0

    def reset(self, worlds, generators, start):
        assert len(worlds) == len(start.applied)

    def act(self, transition):
        self.asked += 1
        return self.wrench

    def plan(self, transition):
        return transition.next_state.goal + np.array([0.3, 0.4, 0.0])


def run(core, steps, *, seed=0, learner_seed=1):
    """Observations, rewards and infos of a run in which worlds start anew as they end."""
    obs, info = core.reset(seed=seed)
    seen: list[tuple] = [(obs, info)]
    ended = None
    for action in actions(learner_seed, steps, core.num_worlds, len(core.learners), 3):
        obs, reward, terminated, truncated, info = core.step(action, restart=ended)
        seen.append((obs, reward, terminated, truncated, info))
        ended = terminated | truncated
    return seen


def test_the_partner_drives_the_last_agent_and_the_others_learn():
    core = Transport(num_worlds=3, partner=Steady())
    assert (core.num_agents, core.learners) == (2, (0,))
    obs, info = core.reset(seed=0)
    assert obs.shape == (3, 1, 22)
    obs, reward, *_, info = core.step(actions(0, 1, 3, 1, 3)[0])
    assert (obs.shape, reward.shape) == ((3, 1, 22), (3, 1))
    assert all(term.shape == (3, 1) for term in info["reward_terms"].values())
    assert info["force_load_share"].shape == (3, 2)
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.applied[:, 1], [[3, -2, 1]] * 3, atol=1e-12)


QUARTET = Body(grips=((-0.9, 0.0), (-0.3, 0.05), (0.3, 0.05), (0.9, -0.05)))


@pytest.mark.parametrize("driven", [(3,), (1,), (1, 3), (0, 2), (0, 1, 2)])
def test_learners_see_and_earn_what_they_would_if_all_learned(driven):
    alone = Transport(
        num_worlds=4, body=QUARTET, partner=Steady(), partner_agents=driven, reward="balanced"
    )
    both = Transport(num_worlds=4, body=QUARTET, reward="balanced")
    learners = [i for i in range(4) if i not in driven]
    alone.reset(seed=0)
    both.reset(seed=0)
    for action in actions(0, 5, 4, len(learners), 3):
        mine = alone.step(action)
        assert alone.transition is not None
        theirs = both.step(alone.transition.action)
        np.testing.assert_array_equal(mine[0], theirs[0][:, learners])
        np.testing.assert_array_equal(mine[1], theirs[1][:, learners])
        for name, term in mine[4]["reward_terms"].items():
            np.testing.assert_array_equal(term, theirs[4]["reward_terms"][name][:, learners])
        for name in ("internal_wrench", "relative_cost", "success"):
            np.testing.assert_array_equal(mine[4][name], theirs[4][name])


def test_any_agents_but_one_can_be_driven():
    core = Transport(num_worlds=2, body=TRIO, partner=Steady(), partner_agents=(0, 2))
    assert (core.num_agents, core.learners) == (3, (1,))
    core.reset(seed=0)
    core.step(np.zeros((2, 1, 3)))
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.applied[:, [0, 2]], [[[3, -2, 1]] * 2] * 2)
    assert not core.transition.applied[:, 1].any()


def test_a_partner_is_clipped_to_the_limits_in_the_agents_frame():
    core = Transport(
        partner=Steady((30.0, 4.0, -50.0)), force_limit=(10.0, 8.0), torque_limit=(5.0, 2.0)
    )
    core.reset(seed=0)
    core.step(np.zeros((1, 1, 3)))
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.applied[0, 1], [8, 4, -2], atol=1e-12)
    forces = Transport(partner=Steady(), action="force")
    forces.reset(seed=0)
    forces.step(np.zeros((1, 1, 2)))
    assert forces.transition is not None
    np.testing.assert_allclose(forces.transition.applied[0, 1], [3, -2, 0], atol=1e-12)


def test_plan_and_disagreement_are_told_in_the_info_and_nowhere_else():
    core = Transport(num_worlds=3, partner=Steady())
    _, info = core.reset(seed=0)
    assert set(info) >= TRUTH
    assert not TRUTH & set(core.observation.blocks)
    for _ in range(3):
        *_, info = core.step(np.zeros((3, 1, 3)))
        assert core.transition is not None
        goal = core.transition.next_state.goal
        np.testing.assert_allclose(info["partner_plan"], goal + np.array([0.3, 0.4, 0]))
        np.testing.assert_allclose(info["disagreement"], 0.5)
        assert info["partner_has_plan"].all()
    *_, info = Transport().reset(seed=0)
    assert not TRUTH & set(info)


def test_observations_do_not_depend_on_where_the_partner_wants_to_go():
    """Until it acts: the first observation of an episode is the same for every plan."""
    first = [
        Transport(num_worlds=5, partner=Impedance(offset=away)).reset(seed=3)[0]
        for away in (0.0, 0.7)
    ]
    np.testing.assert_array_equal(first[0], first[1])


@pytest.mark.parametrize("name", PARTNERS)
def test_the_same_seed_gives_the_same_bits_and_a_world_stands_alone(name):
    keywords = {"partner": name, "task": EASY, "horizon": 25, **acting(name)}
    many, few = (Transport(num_worlds=n, **keywords) for n in (5, 1))
    plan = actions(1, 60, 5, 1, 3)
    again = Transport(config=many.config, num_worlds=5)
    for core in (many, again):
        core.reset(seed=4)
    few.reset(seed=6)
    for together, alone in side_by_side(many, again, few, plan):
        for key in TRUTH:
            np.testing.assert_allclose(together[4][key][2], alone[4][key][0], atol=1e-9)


def test_every_view_runs_the_same_episodes_with_a_partner():
    keywords = {"partner": "population", "horizon": 12, "task": NEVER}
    single, vector = gymnasium.make(ID, **keywords), gymnasium.make_vec(ID, num_envs=2, **keywords)
    parallel = beam_transport_v0.parallel_env(**keywords)
    core = Transport(num_worlds=1, **keywords)
    firsts = [single.reset(seed=5)[0], vector.reset(seed=5)[0][0], core.reset(seed=5)[0][0, 0]]
    firsts.append(parallel.reset(seed=5)[0]["agent_0"])
    for action in actions(0, 12, 1, 3).astype(np.float32):
        obs, *_, info = single.step(action[0])
        batched, *_, told = vector.step(np.repeat(action, 2, axis=0))
        mine, *_ = core.step(action[None])
        theirs, *_, own = parallel.step({"agent_0": action[0]})
        firsts += [obs, batched[0], mine[0, 0], theirs["agent_0"]]
        np.testing.assert_array_equal(info["partner_plan"], own["agent_0"]["partner_plan"])
        np.testing.assert_array_equal(info["partner_plan"], told["partner_plan"][0])
        assert type(info["disagreement"]) is float
        assert info["disagreement"] == own["agent_0"]["disagreement"] == told["disagreement"][0]
    for group in range(0, len(firsts), 4):
        for other in firsts[group + 1 : group + 4]:
            np.testing.assert_allclose(other, firsts[group], atol=1e-6)


def test_driven_agents_leave_the_agents_of_the_parallel_view():
    env = beam_transport_v0.parallel_env(body=TRIO, partner="noisy", partner_agents=(1,))
    assert env.possible_agents == ["agent_0", "agent_2"]
    obs, _ = env.reset(seed=0)
    assert set(obs) == {"agent_0", "agent_2"}
    assert env.state().shape == (2 * env.transport.observation.size,)
    still = {agent: np.zeros(3, dtype=np.float32) for agent in env.agents}
    still["agent_2"][0] = 1.0
    *_, infos = env.step(still)
    whole = env.transport.transition
    assert whole is not None
    for i, agent in ((0, "agent_0"), (2, "agent_2")):
        internal = whole.decomposition.internal[0, i]
        np.testing.assert_array_equal(infos[agent]["internal_wrench"], internal)
    with pytest.raises(InvalidInput, match="actions must have one entry for each of"):
        env.step({**still, "agent_1": np.zeros(3, dtype=np.float32)})


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_autoreset_begins_anew_with_the_partner(mode):
    """What a world does after its autoreset is what the core does after a reset of its own."""
    keywords = {"partner": "population", "horizon": 7, "task": NEVER}
    env = gymnasium.make_vec(ID, num_envs=3, autoreset_mode=mode, **keywords)
    core = Transport(num_worlds=3, **keywords)
    env.reset(seed=0)
    core.reset(seed=0)
    plan = iter(actions(0, 40, 3, 3))
    obs = np.zeros((3, 22), dtype=np.float32)
    for _ in range(3):
        for step in range(7):
            action = next(plan)
            obs, *_, info = env.step(action)
            mine, *_, told = core.step(action[:, None])
            if step < 6 or mode == "NextStep":
                np.testing.assert_array_equal(obs, mine[:, 0])
                np.testing.assert_array_equal(info["disagreement"], told["disagreement"])
        mine, _ = core.reset(mask=np.ones(3, dtype=bool))
        if mode == "NextStep":
            obs, *_ = env.step(np.ones((3, 3)))
        np.testing.assert_array_equal(obs, mine[:, 0])


def test_starts_and_goals_are_the_same_whoever_the_partner_is():
    starts = []
    for name in PARTNERS:
        core = Transport(num_worlds=3, partner=name, horizon=3, **acting(name))
        core.reset(seed=0)
        core.reset()
        assert core.transition is not None
        starts.append((core.transition.next_state.pose, core.transition.next_state.goal))
    for other in starts[1:]:
        assert_same(other, starts[0])


def test_a_refused_action_moves_neither_the_world_nor_the_partner():
    cores = [Transport(num_worlds=2, partner="switching") for _ in "ab"]
    for core in cores:
        core.reset(seed=0)
    with pytest.raises(InvalidInput, match="action must be finite"):
        cores[0].step(np.full((2, 1, 3), np.nan))
    with pytest.raises(InvalidInput, match=r"action must have shape .*\(2, 1, 3\)"):
        cores[0].step(np.zeros((2, 2, 3)))
    for action in actions(0, 5, 2, 1, 3):
        assert_same(cores[0].step(action), cores[1].step(action))


class Exhausted(Steady):
    """Gives nothing of use where an episode has ended."""

    def player(self, config, num_worlds, agents):
        return ExhaustedPlayer(np.tile(self.wrench, (num_worlds, len(agents), 1)))


class ExhaustedPlayer(SteadyPlayer):
    def act(self, transition):
        ended = transition.terminated | transition.truncated
        return np.where(ended[:, None, None], np.nan, super().act(transition))


@pytest.mark.parametrize("partner", ["leader", None, Exhausted((1.0, 2.0, 0.5))])
def test_what_is_given_in_a_world_that_begins_anew_is_ignored_whatever_it_is(partner):
    cores = [Transport(num_worlds=2, partner=partner, horizon=1) for _ in "ab"]
    restart, size = np.array([True, True]), (2, len(cores[0].learners), 3)
    for core in cores:
        core.reset(seed=0)
        core.step(np.zeros(size))
    assert_same(
        cores[0].step(np.full(size, np.nan), restart=restart),
        cores[1].step(np.zeros(size), restart=restart),
    )


@pytest.mark.parametrize(
    ("wrench", "said"),
    [
        ((np.nan, 0.0, 0.0), "wrenches of the partner must be finite"),
        ((1.0, 2.0), "wrenches of the partner must have shape"),
    ],
)
def test_a_partner_that_gives_nonsense_is_named(wrench, said):
    core = Transport(partner=Steady(wrench))
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match=said):
        core.step(np.zeros((1, 1, 3)))


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"partner": "folower"}, r"partner must be .* did you mean 'follower'"),
        ({"partner": 3}, r"partner must be a name or have a method player"),
        ({"partner": Impedance}, r"partner must be a name or have a method player"),
        ({"partner_agents": (1,)}, r"partner_agents must come with a partner"),
        ({"partner": "leader", "partner_agents": (0, 1)}, r"leave at least one to learn"),
        ({"partner": "leader", "partner_agents": ()}, r"at least one of 2 agents"),
        ({"partner": "leader", "partner_agents": (2,)}, r"partner_agents must name agents 0 to 1"),
        ({"partner": "leader", "body": Body(grips=((0.5, 0.0),))}, r"leave at least one to learn"),
    ],
)
def test_wrong_partners_are_refused(keywords, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        TransportConfig(**keywords)


@pytest.mark.parametrize("partner", ["stubborn", Impedance(offset=0.4)])
def test_a_partner_goes_through_json_by_name_and_as_an_object(partner):
    made = gymnasium.make(ID, partner=partner)
    again = gymnasium.make(EnvSpec.from_json(made.spec.to_json()))  # pyright: ignore
    ours = made.unwrapped.transport.config  # pyright: ignore[reportAttributeAccessIssue]
    assert again.unwrapped.transport.config == ours  # pyright: ignore[reportAttributeAccessIssue]


def test_partners_compare_by_value_and_configurations_share_no_memory():
    config = TransportConfig(partner=Population(members=(Noisy(), Impedance())))
    assert config == replace(config)
    assert config == TransportConfig(partner=Population(members=(Noisy(), Impedance())))
    first, second = Transport(config=config), Transport(config=config)
    run(first, 5)
    assert_same(run(first, 20), run(second, 20))


@pytest.mark.parametrize(
    "module",
    [
        beam_transport_v0,
        beam_doorway_v0,
        beam_tracking_v0,
        walker_turn_v0,
        walker_avoid_v0,
        beam_lift_v0,
    ],
)
@pytest.mark.parametrize("driven", [0, 1])
def test_the_scripted_controller_answers_for_the_learners_only(module, driven):
    config = module.env(partner="leader", partner_agents=(driven,)).unwrapped.transport.config
    core = Transport(num_worlds=2, config=config)
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    action = find_controller(config)(obs, core.transition)
    alone = replace(config, partner=None, partner_agents=None)
    free = find_controller(alone)(obs, core.transition)
    np.testing.assert_array_equal(action, free[:, [1 - driven]])
