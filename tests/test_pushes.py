"""Discrete actions: numbers of pushes, in the core and in every view."""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Discrete, MultiDiscrete

from coopenv import PUSHES, Transport, TransportConfig, beam_transport_v0
from coopenv.agents.controllers import RandomPolicy, find_controller
from coopenv.agents.evaluate import evaluate
from coopenv.errors import InvalidInput, UnknownName
from coopenv.pushes import nearest, table_of
from tests.helpers import EASY, TRIO, assert_same, vec_env

VIEW = "coopenv/BeamTransport-v0"
OWN = ((0.0, 0.0, 0.0), (0.5, -0.25, 1.0), (-1.0, 0.0, 0.5))
DRIVEN = {"body": TRIO, "partner": "noisy", "partner_agents": (1,), "action": "discrete"}


def numbers(seed, count, *shape):
    return np.random.default_rng(seed).integers(count, size=shape)


@pytest.mark.parametrize("pushes", [*PUSHES, OWN])
@pytest.mark.parametrize("others", [{}, {**DRIVEN, "reward": "balanced"}], ids=["alone", "driven"])
def test_a_number_does_what_its_push_does_as_a_wrench(pushes, others):
    keywords = {"num_worlds": 3, "horizon": 9, **others, "pushes": pushes}
    by_number = Transport(**{**keywords, "action": "discrete"})
    by_wrench = Transport(**{**keywords, "action": "wrench"})
    assert_same(by_number.reset(seed=0), by_wrench.reset(seed=0))
    table = table_of(pushes)
    for given in numbers(1, len(table), 8, 3, 2):
        assert_same(by_number.step(given), by_wrench.step(table[given]))


def test_the_first_push_of_every_table_is_none_and_all_are_different():
    for name in PUSHES:
        table = table_of(name)
        assert not table[0].any()
        assert len(np.unique(table, axis=0)) == len(table)
    assert [len(PUSHES[name]) for name in ("axes", "fine", "compass", "grid")] == [7, 13, 11, 27]


def test_every_view_offers_the_numbers_and_shows_the_same_episode():
    keywords = {"action": "discrete", "horizon": 8, "task": EASY}
    core = Transport(config=TransportConfig(**keywords))
    single = gymnasium.make(VIEW, **keywords)
    vector = gymnasium.make_vec(VIEW, num_envs=1, **keywords)
    team = beam_transport_v0.parallel_env(**keywords)
    turns = beam_transport_v0.env(**keywords)
    venv: Any = vec_env(VIEW, 1, seed=3, **keywords)
    assert single.action_space == vector.single_action_space == MultiDiscrete([7, 7])
    assert team.action_space("agent_1") == turns.action_space("agent_0") == Discrete(7)
    assert venv.action_space == MultiDiscrete([7, 7])
    first = core.reset(seed=3)[0]
    assert (single.reset(seed=3)[0] == vector.reset(seed=3)[0]).all()
    np.testing.assert_array_equal(venv.reset(), first.reshape(1, -1))
    team.reset(seed=3)
    turns.reset(seed=3)
    for given in numbers(2, 7, 4, 2):
        seen = core.step(given[None])[0].reshape(-1)
        assert (single.step(given)[0] == seen).all()
        assert (vector.step(given[None])[0] == seen).all()
        assert (venv.step(given[None])[0] == seen).all()
        by_name = dict(zip(team.agents, given, strict=True))
        assert (np.concatenate([*team.step(by_name)[0].values()]) == seen).all()
        for number in given.tolist():  # plain ones of Python will do
            turns.step(number)
        both = [np.asarray(turns.observe(name)) for name in turns.agents]
        assert (np.concatenate(both) == seen).all()


def test_an_agent_for_itself_has_one_number_in_stable_baselines():
    for control, rows in (("shared", 4), ("partner", 2)):
        venv: Any = vec_env(VIEW, 2, control=control, action="discrete", pushes="grid")
        assert venv.action_space == Discrete(27)
        venv.reset()
        assert venv.step(np.zeros(rows, dtype=np.int64))[0].shape == (rows, 22)


WRONG = [
    (7, "from 0 to 6, got 7"),
    (-1, "from 0 to 6, got -1"),
    (1.0, "whole numbers from 0 to 6"),
    (True, "whole numbers from 0 to 6"),
]


@pytest.mark.parametrize(("wrong", "words"), WRONG)
def test_a_number_of_no_push_is_refused_in_every_view_and_nothing_moves(wrong, words):
    core = Transport(action="discrete")
    core.reset(seed=0)
    before = core.transition
    with pytest.raises(InvalidInput, match=words):
        core.step(np.array([[wrong, wrong]]))
    assert core.transition is before
    env = gymnasium.make(VIEW, action="discrete").unwrapped
    env.reset(seed=0)
    with pytest.raises(InvalidInput, match=words):
        env.step(np.array([wrong, wrong]))
    team = beam_transport_v0.parallel_env(action="discrete")
    team.reset(seed=0)
    with pytest.raises(InvalidInput, match=rf"actions\['agent_1'\] must be {words}"):
        team.step({"agent_0": np.array(0), "agent_1": np.array(wrong)})
    turns = beam_transport_v0.env(action="discrete")
    turns.reset(seed=0)
    with pytest.raises(InvalidInput, match=words):
        turns.step(wrong)
    assert turns.agent_selection == "agent_0"


def test_numbers_of_another_shape_are_refused():
    core = Transport(action="discrete", num_worlds=2)
    core.reset(seed=0)
    for shape in ((2,), (2, 2, 1), (2, 2, 3), (2, 1)):
        with pytest.raises(InvalidInput, match="action must have shape"):
            core.step(np.zeros(shape, dtype=np.int64))


def test_the_number_of_a_world_that_begins_anew_is_ignored():
    core = Transport(action="discrete", num_worlds=2, horizon=1)
    core.reset(seed=0)
    core.step(np.zeros((2, 2), dtype=np.int64))
    restart = np.array([True, True])
    core.step(np.array([[99, -3], [0, 1]]), restart=restart)
    core.step(np.zeros((2, 2), dtype=np.int64))
    core.reset(mask=np.array([False, True]))
    with pytest.raises(InvalidInput, match=r"got 99 at index \(1, 0\)"):
        core.step(np.array([[0, 0], [99, 0]]), restart=np.array([True, False]))


@pytest.mark.parametrize(
    ("pushes", "words"),
    [
        ((), "from 2 to 10000 rows"),
        (((0, 0, 0),), "from 2 to 10000 rows"),
        (((0, 0), (1, 0)), "rows \\(fx, fy, tz\\)"),
        (((0, 0, 0), (0, 1.5, 0)), "in \\[-1, 1\\].*in row 1"),
        (((0, 0, 0), (1, 0, 0), (1, 0, 0)), "all be different, got 2 of 3"),
        (((0, 0, 0), (1, 0, np.nan)), "finite"),
    ],
)
def test_a_table_that_is_none_is_refused(pushes, words):
    with pytest.raises(InvalidInput, match=f"pushes must be.*{words}|pushes must {words}"):
        TransportConfig(action="discrete", pushes=pushes)


def test_a_misspelt_table_is_told_the_nearest():
    with pytest.raises(UnknownName, match="did you mean 'compass'"):
        TransportConfig(action="discrete", pushes="compas")


@pytest.mark.parametrize("pushes", ["grid", OWN])
def test_discrete_actions_go_through_json(pushes):
    config = TransportConfig(action="discrete", pushes=pushes, bounded=True, cost="waste")
    assert TransportConfig.from_json(config.to_json()) == config
    spec = gymnasium.make(VIEW, action="discrete", pushes=pushes, bounded=True, cost="waste").spec
    assert spec is not None
    again = gymnasium.make(EnvSpec.from_json(spec.to_json()))
    assert again.unwrapped.transport.config == config  # pyright: ignore[reportAttributeAccessIssue]


def test_scripted_controllers_take_the_nearest_push_and_arrive():
    config = TransportConfig(action="discrete")
    assert evaluate(find_controller(config), config, episodes=10).success_rate == 1.0
    assert evaluate(RandomPolicy(config), replace(config, horizon=5), episodes=3).episodes == 3
    actions = np.array([[0.9, 0.2, 0.0], [0.1, 0.1, -0.2], [0.0, 0.0, -0.8]])
    assert nearest(actions, table_of("axes")).tolist() == [1, 0, 6]
