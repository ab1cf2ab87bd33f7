"""The joint action: how learners' actions are read, and what is left of all without a partner."""

import re

import numpy as np
import pytest

from coopenv import Transport, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.stepping.driven import driven_agents, read_action


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_is_refused_wherever_it_is(value):
    for place in np.ndindex(4, 3, 3):
        action = np.zeros((4, 3, 3))
        action[place] = value
        with pytest.raises(InvalidInput, match=re.escape(f"action must be finite, got {value} at")):
            read_action(action, action.shape, None)
        restart = np.arange(4) == place[0]
        assert not read_action(action, action.shape, restart).any()


@pytest.mark.parametrize("action", [[[[0, 0, 0]] * 2], np.zeros((1, 2, 3), dtype=np.float32)])
def test_actions_may_be_whatever_numpy_reads(action):
    assert read_action(action, (1, 2, 3), None).dtype == np.float64


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (
            np.zeros((2, 3)),
            r"action must have shape \(world, agent, 3\) = \(1, 2, 3\), got \(2, 3\)",
        ),
        ("push", "action must be an array of numbers"),
        ([[[0, 0, 0], [0, 0]]], "action must be an array of numbers"),
    ],
)
def test_what_is_no_action_is_refused(action, said):
    with pytest.raises(InvalidInput, match=said):
        read_action(action, (1, 2, 3), None)


def test_where_nobody_is_driven_everything_is_the_learners():
    core = Transport(num_worlds=3)
    core.reset(seed=0)
    assert core.transition is not None
    nobody = driven_agents(core.config, 3)
    action, terms = np.ones((3, 2, 3)), {"one": np.ones((3, 2))}
    assert nobody.joint(action, core.transition) is action
    assert nobody.of_learners(action) is action
    assert nobody.terms_of_learners(terms) is terms
    assert nobody.info(core.transition) == {}


def test_a_partner_leaves_the_rows_of_the_learners():
    driven = driven_agents(TransportConfig(partner="leader", partner_agents=(0,)), 3)
    value = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(driven.of_learners(value), value[:, 1:])
