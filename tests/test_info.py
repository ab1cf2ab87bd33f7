"""Infos: flat, finite, the same at reset and at every step, in every view."""

import copy
import pickle
from itertools import combinations
from typing import Any

import gymnasium
import numpy as np
import pytest

import coopenv
from coopenv import Ranges, Transport
from coopenv.info import Info, is_of_learners
from tests.helpers import IDS, PARALLEL, TRIO, actions, parallel_actions

RANDOMISED = {"randomise": Ranges(mass=(4, 9)), "partner": "impedance", "horizon": 40}


@pytest.mark.parametrize("view", IDS)
@pytest.mark.parametrize("keywords", [{}, RANDOMISED], ids=["plain", "randomised, with a partner"])
def test_the_infos_of_hundreds_of_steps_stack_into_arrays(view, keywords):
    if "Walker" in view and keywords:
        keywords = {**keywords, "partner": "walking", "randomise": Ranges(friction=(0.1, 0.4))}
    env: Any = gymnasium.make(view, **keywords)
    _, info = env.reset(seed=0)
    infos = [info]
    for action in actions(0, 250, *env.action_space.shape).astype(np.float32):
        *_, terminated, truncated, info = env.step(action)
        infos.append(info)
        if terminated or truncated:
            infos.append(env.reset()[1])
    for name in infos[0]:
        stacked = np.array([info[name] for info in infos])
        assert stacked.shape == (len(infos), *np.shape(infos[0][name])), name
        assert stacked.dtype.kind in "bif", name
        assert np.isfinite(stacked).all(), name


@pytest.mark.parametrize("view", IDS)
def test_the_infos_of_the_other_views_stack_too(view):
    vector: Any = gymnasium.make_vec(view, num_envs=3, horizon=20)
    seen = [vector.reset(seed=0)[1]]
    plan = actions(0, 60, *vector.action_space.shape).astype(np.float32)
    seen += [vector.step(action)[4] for action in plan]
    for name in seen[0]:
        assert np.isfinite(np.stack([info[name] for info in seen]).astype(float)).all(), name
    env = PARALLEL[view].parallel_env(horizon=20)
    told = [env.reset(seed=0)[1]]
    for action in actions(0, 20, len(env.possible_agents), vector_size(env)):
        told.append(env.step(parallel_actions(env, action))[4])
        if not env.agents:
            break
    for agent in env.possible_agents:
        for name in told[0][agent]:
            assert np.isfinite(np.stack([info[agent][name] for info in told])).all(), name


def vector_size(env):
    return env.action_space("agent_0").shape[0]


def test_groups_are_made_where_they_are_indexed_and_are_no_entries():
    info = Info({"success": False, "reward/progress": 0.5, "reward/time": -0.1, "body/mass": 3.0})
    assert info["reward_terms"] == {"progress": 0.5, "time": -0.1}
    assert info["body"] == {"mass": 3.0}
    assert list(info) == ["success", "reward/progress", "reward/time", "body/mass"]
    for other in (info.copy(), copy.deepcopy(info), pickle.loads(pickle.dumps(info))):
        assert other == info
        assert other["reward_terms"] == info["reward_terms"]
    assert Info(success=True)["reward_terms"] == {}
    for missing in ("body", "reward"):
        with pytest.raises(KeyError):
            Info(success=True)[missing]


TRIO_WITH_PARTNER = {
    "body": TRIO,
    "partner": "noisy",
    "partner_agents": (1,),
    "cost": "squeeze",
    "bounded": True,
    "randomise": Ranges(mass=(4, 9)),
}


@pytest.mark.parametrize("keywords", [{}, TRIO_WITH_PARTNER], ids=["plain", "a partner between"])
def test_single_views_tell_what_the_core_tells_of_their_world(keywords):
    core = Transport(**keywords)
    team: Any = gymnasium.make("coopenv/BeamTransport-v0", **keywords).unwrapped
    each = coopenv.beam_transport_v0.parallel_env(**keywords)
    learners, agents = core.learners, each.possible_agents
    told = [(core.reset(seed=4)[1], team.reset(seed=4)[1], each.reset(seed=4)[1])]
    for action in actions(15, 20, *core.action_shape):
        rows = dict(zip(agents, action[0], strict=True))
        told.append((core.step(action)[4], team.step(action.ravel())[4], each.step(rows)[4]))
    for of_core, of_team, of_agents in told:
        assert list(of_team) == list(of_core)
        for agent, own in of_agents.items():
            assert list(own) == list(of_core), agent
        for name, (value,) in of_core.items():
            averaged = is_of_learners(name)
            wanted = np.mean(value) if averaged else value
            np.testing.assert_allclose(of_team[name], wanted, rtol=1e-15, err_msg=name)
            for row, (agent, i) in enumerate(zip(agents, learners, strict=True)):
                of_world = not np.ndim(value) or name == "partner_plan"
                wanted = value if of_world else value[row if averaged else i]
                np.testing.assert_array_equal(of_agents[agent][name], wanted, err_msg=name)


def test_infos_of_single_views_share_no_memory():
    env = coopenv.beam_transport_v0.parallel_env(partner="noisy", body=TRIO)
    env.reset(seed=0)
    *_, infos = env.step({agent: np.ones(3, np.float32) for agent in env.agents})
    arrays = [
        value for info in infos.values() for value in info.values() if isinstance(value, np.ndarray)
    ]
    assert len(arrays) > 4
    for value in arrays:
        assert value.base is None
        assert value.flags.writeable
        value += 1.0  # a view of another would show it
    core_info = env.transport.get_state().parts["info"]
    for first, second in combinations(arrays, 2):
        assert not np.shares_memory(first, second)
    assert np.abs(core_info["partner_plan"][0] - infos["agent_0"]["partner_plan"]).min() > 0.5


def test_an_undefined_share_is_an_even_one_beside_a_flag():
    core = Transport(num_worlds=2)
    _, start = core.reset(seed=0, pose=(0, 0, 0))
    pulling = [[[1.0, 0, 0], [1.0, 0, 0]], [[1.0, 0, 0], [-0.5, 0, 0]]]  # apart; in one direction
    *_, info = core.step(pulling)
    assert not start["force_load_share_defined"].any()
    assert info["force_load_share_defined"].tolist() == [False, True]
    np.testing.assert_allclose(info["force_load_share"], [[1 / 2, 1 / 2], [2 / 3, 1 / 3]])
    assert not info["torque_load_share_defined"].any()
    np.testing.assert_array_equal(info["torque_load_share"], 0.5)


def test_success_has_the_name_by_which_evaluations_look_for_it():
    core = Transport(num_worlds=2)
    core.reset(seed=0, pose=(0, 0, 0), goal=[(0, 0, 0), (1, 0, 0)])
    *_, info = core.step(np.zeros((2, 2, 3)))
    assert info["is_success"].tolist() == info["success"].tolist() == [True, False]
