"""An action that a view of one world refuses is named as it was given: by agent and component."""

import re
from typing import Any

import gymnasium
import numpy as np
import pytest

from coopenv import beam_transport_v0
from coopenv.errors import InvalidInput
from coopenv.rewards import RewardSum
from tests.helpers import TRIO

ID = "coopenv/BeamTransport-v0"


def single(**keywords: Any) -> Any:
    env: Any = gymnasium.make(ID, disable_env_checker=True, body=TRIO, **keywords)
    env.reset(seed=0)
    return env.unwrapped


def parallel(**keywords: Any) -> Any:
    env: Any = beam_transport_v0.parallel_env(body=TRIO, **keywords)
    env.reset(seed=0)
    return env


def by_agent(env: Any, joint: np.ndarray) -> dict[str, Any]:
    return dict(zip(env.agents, joint, strict=True))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(
    ("keywords", "agent", "place", "component"),
    [
        ({}, 1, (1, 1), "fy"),
        ({}, 2, (2, 2), "tz"),
        ({"action": "force"}, 2, (2, 0), "fx"),
        ({"partner": "follower", "partner_agents": (0,)}, 2, (1, 2), "tz"),
    ],
)
def test_a_number_that_is_not_finite_is_told_by_agent_and_component(
    keywords, agent, place, component, value
):
    rest = re.escape(f"must be finite, got {value} for {component}; give numbers in [-1, 1]")
    env = single(**keywords)
    joint = np.zeros(env.transport.action_shape[1:], dtype=np.float32)
    joint[place] = value
    with pytest.raises(InvalidInput, match=f"^action of agent {agent} {rest}$"):
        env.step(joint.reshape(-1))
    env = parallel(**keywords)
    with pytest.raises(InvalidInput, match=rf"^actions\['agent_{agent}'\] {rest}$"):
        env.step(by_agent(env, joint))


@pytest.mark.parametrize("number", [-1, 27])
def test_a_number_of_no_push_is_told_by_agent(number):
    rest = rf"must be from 0 to 26, got {number}; there are 27 pushes"
    joint = np.array([3, number, 0])
    env = single(action="discrete", pushes="grid")
    with pytest.raises(InvalidInput, match=f"^action of agent 1 {rest}$"):
        env.step(joint)
    env = parallel(action="discrete", pushes="grid")
    with pytest.raises(InvalidInput, match=rf"^actions\['agent_1'\] {rest}$"):
        env.step(by_agent(env, joint))
    turns: Any = beam_transport_v0.env(body=TRIO, action="discrete", pushes="grid")
    turns.reset(seed=0)
    turns.step(0)
    with pytest.raises(InvalidInput, match=rf"^actions\['agent_1'\] {rest}$"):
        turns.step(number)
    assert turns.agent_selection == "agent_1"


def test_a_refused_action_moves_nothing_and_hides_no_other_place():
    for env, given, zero in (
        (single(), np.full(9, np.nan), np.zeros(9)),
        (mine := parallel(), by_agent(mine, np.full((3, 3), np.nan)), None),
    ):
        before = env.transport.get_state().parts
        with pytest.raises(InvalidInput, match=r"agent.0.* must be finite") as said:
            env.step(given)
        assert "index" not in str(said.value)
        assert said.value.__suppress_context__
        np.testing.assert_equal(env.transport.get_state().parts, before)
        env.step(by_agent(env, np.zeros((3, 3))) if zero is None else zero)


def test_what_is_wrong_with_something_else_is_told_as_it_is():
    def diverged(obs, transition):
        return np.full((*obs.shape[:2], 3), np.nan)

    for env in (single(partner=diverged), parallel(partner=diverged)):
        joint = np.zeros((2, 3))
        given = joint.reshape(-1) if isinstance(env, gymnasium.Env) else by_agent(env, joint)
        with pytest.raises(InvalidInput, match=r"^actions of the partner's policy must be finite"):
            env.step(given)


class Divided:
    """A reward term that cannot be had, and says why."""

    def __call__(self, transition: Any) -> Any:
        try:
            return 1 / 0
        except ZeroDivisionError as error:
            raise InvalidInput("weight must not be 0, got 0; choose another") from error


@pytest.mark.parametrize("view", [single, parallel])
def test_what_else_is_refused_in_a_step_keeps_its_cause(view):
    env = view(reward=RewardSum({"divided": Divided()}))
    joint = np.zeros((3, 3), dtype=np.float32)
    with pytest.raises(InvalidInput, match="weight must not be 0") as caught:
        env.step(joint.reshape(env.action_space.shape) if view is single else by_agent(env, joint))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
