"""Infos stack into arrays, whatever the step, without a special case."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from tests.helpers import EASY_TASKS, IDS, PARALLEL, actions, constant

EVERY_ID = pytest.mark.parametrize("view", IDS)
STEPS = 400


def check_stacked(infos: list[dict[str, Any]]) -> None:
    """Every key into one array of one dtype, with a row an info, all of it finite."""
    for name in infos[0]:
        stacked = np.array([info[name] for info in infos])
        assert len(stacked) == len(infos)
        assert stacked.dtype == np.asarray(infos[0][name]).dtype, name
        assert stacked.dtype.kind in "bif", name
        assert np.isfinite(stacked).all(), name
    assert {tuple(info) for info in infos} == {tuple(infos[0])}


@EVERY_ID
def test_infos_of_hundreds_of_steps_and_their_resets_stack_in_the_gymnasium_view(view):
    env = gymnasium.make(view, task=EASY_TASKS[view], horizon=30, disable_env_checker=True)
    infos = [env.reset(seed=0)[1]]
    for action in actions(0, STEPS, *constant(env).shape).astype(np.float32):
        *_, terminated, truncated, info = env.step(action)
        infos.append(info)
        if terminated or truncated:
            infos.append(env.reset()[1])
    assert len(infos) > STEPS + 10
    check_stacked(infos)


@EVERY_ID
def test_infos_of_hundreds_of_steps_and_their_resets_stack_in_the_pettingzoo_view(view):
    env = PARALLEL[view].parallel_env(task=EASY_TASKS[view], horizon=30)
    infos = [env.reset(seed=0)[1]]
    agents = env.possible_agents
    for row in actions(0, STEPS, len(agents), *env.action_space(agents[0]).shape):
        infos.append(env.step(dict(zip(agents, row, strict=True)))[-1])
        if not env.agents:
            infos.append(env.reset()[1])
    assert len(infos) > STEPS + 10
    for agent in agents:
        check_stacked([info[agent] for info in infos])


@EVERY_ID
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_infos_of_hundreds_of_steps_stack_in_the_vector_view(view, mode):
    env = gymnasium.make_vec(
        view, num_envs=4, task=EASY_TASKS[view], horizon=30, autoreset_mode=mode
    )
    infos = [env.reset(seed=0)[1]]
    ends = 0
    for action in actions(0, STEPS // 4, *constant(env).shape).astype(np.float32):
        *_, info = env.step(action)
        ends += "final_info" in info
        last = {"final_obs", "final_info", "_final_obs", "_final_info"}  # of what has ended
        infos.append({name: value for name, value in info.items() if name not in last})
    check_stacked(infos)
    assert (ends > 0) == (mode == "SameStep")
