"""Any policy as a partner: functions, scripted ones, those of one's own, and what is none."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from coopenv import PUSHES, Transport, TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.partners import PolicyPartner
from coopenv.agents.policy import RandomPolicy
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.partners.cases import SEEN, Counting, wrenches


def steady(obs, transition):
    """A policy at the top of a module: always forwards."""
    return np.tile([1.0, 0.0, 0.0], (*obs.shape[:2], 1))


@dataclass(frozen=True)
class Push:
    """A policy of one's own, a frozen dataclass."""

    force: float = 0.5

    def __call__(self, obs, transition):
        return np.tile([self.force, 0.0, 0.0], (*obs.shape[:2], 1))


def test_a_function_is_a_partner_and_gets_what_the_driven_agents_see():
    given = []

    def policy(obs, transition):
        given.append(obs)
        return np.full((*obs.shape[:2], 3), 0.5)

    core = Transport(num_worlds=3, partner=policy)
    twin = Transport(num_worlds=3)
    core.reset(seed=0, pose=np.zeros(3), goal=np.ones(3))
    seen, _ = twin.reset(seed=0, pose=np.zeros(3), goal=np.ones(3))
    core.step(np.zeros((3, 1, 3)))
    np.testing.assert_array_equal(given[0], seen[:, 1:])
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.action[:, 1], 0.5)


def test_every_environment_has_a_copy_whose_memory_follows_the_episodes():
    mine = Counting(2)
    cores = [Transport(num_worlds=2, partner=mine) for _ in range(2)]
    for core in cores:
        core.reset(seed=0)
        core.step(np.zeros((2, 1, 3)))
    core = cores[0]
    core.reset(mask=np.array([False, True]))
    core.step(np.zeros((2, 1, 3)))
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.action[:, 1, 0], [0.2, 0.1])
    assert not mine.steps.any()


def test_scripted_and_random_policies_are_partners():
    config = replace(SEEN, partner=find_controller(SEEN))
    core = Transport(config=config)
    core.reset(seed=0)
    assert core.transition is not None
    wanted = find_controller(SEEN)(np.zeros((1, 2, 1)), core.transition)[0, 1]
    core.step(np.zeros((1, 1, 3)))
    np.testing.assert_allclose(core.transition.action[0, 1], wanted)
    drawn = replace(SEEN, partner=RandomPolicy(SEEN))
    first, second = (wrenches(Transport(config=drawn), seed=3) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert len(np.unique(first)) == first.size


def test_a_scripted_policy_that_gives_numbers_of_pushes_is_a_partner():
    config = replace(SEEN, action="discrete", pushes="grid")
    core = Transport(config=replace(config, partner=find_controller(config)))
    core.reset(seed=0)
    assert core.transition is not None
    wanted = find_controller(config)(np.zeros((1, 2, 1)), core.transition)[0, 1]
    core.step(np.zeros((1, 1), dtype=np.int64))
    np.testing.assert_array_equal(core.transition.action[0, 1], np.array(PUSHES["grid"])[wanted])
    wrong = replace(config, partner=lambda obs, _: np.full(obs.shape[:2], 27))
    core = Transport(config=wrong)
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match="must be from 0 to 26, got 27"):
        core.step(np.zeros((1, 1), dtype=np.int64))


def test_a_policy_of_ones_own_goes_through_json_as_ones_own_code_does():
    for policy in (steady, Push(force=0.25)):
        config = TransportConfig(partner=policy)  # pyright: ignore[reportArgumentType]
        text = config.to_json()
        assert TransportConfig.from_json(text, trust=(__name__,)) == config
        with pytest.raises(InvalidInput, match=r"partner\.policy must be of coopenv unless"):
            TransportConfig.from_json(text)


@pytest.mark.parametrize(
    ("partner", "message"),
    [
        ("runs/nobody/policy.zip", r"partner must be a policy's file: .* which is not there"),
        ("nobody", "partner must be one of the known names"),
        (lambda obs: obs, r"callable as policy\(obs, transition\)"),
        (PolicyPartner, r"partner must be a name .*, or be a policy or its file"),
        (7, r"partner must be a name .*, or be a policy or its file"),
    ],
)
def test_what_is_no_partner_is_refused(partner, message):
    with pytest.raises((InvalidInput, UnknownName), match=message):
        TransportConfig(partner=partner)


@pytest.mark.parametrize(
    "given", [np.zeros((1, 3, 3)), np.zeros((1, 1, 2)), np.full((1, 1, 3), np.nan)]
)
def test_actions_of_another_form_are_refused(given):
    core = Transport(partner=lambda obs, transition: given)
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match="actions of the partner's policy must"):
        core.step(np.zeros((1, 1, 3)))
