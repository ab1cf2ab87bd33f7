"""Specifications of Gymnasium with anything of this package in them come back from JSON equal."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

from coopenv import Block, TransportTask
from coopenv.errors import InvalidInput
from tests.config.test_any_document import CARRIED, VALUES

ID = "coopenv/BeamTransport-v0"
SLOW = (HealthCheck.too_slow, HealthCheck.data_too_large)


class Renamed(TransportTask):
    """A task whose class no JSON names."""


class Bare:
    """A term of one's own that is no frozen dataclass."""

    weight = 1.0

    def __call__(self, transition):
        return transition.per_agent(transition.next_state.distance, self.weight)


OWN: list[dict[str, Any]] = [
    {"reward": {"own": lambda transition: transition.per_agent(0.0)}},
    {"reward": Bare()},
    {"partner": lambda obs, transition: obs[..., :3]},
    {"observe": ("goal", Block(name="own", size=1, describe="nothing", read=lambda t: t.applied))},
    {"task": Renamed(clearance=0.2)},
]


def as_json_has_it(env: Any, make: Any) -> Any:
    """The environment that is made from the text of another's specification."""
    return make(EnvSpec.from_json(env.spec.to_json()))


@settings(max_examples=12, deadline=None, suppress_health_check=SLOW)
@given(CARRIED, VALUES)
def test_any_environment_comes_back_equal_through_gymnasiums_own_reader(carried, values):
    given = {**carried, **values}
    many = isinstance(given.get("body"), tuple)
    make: Any = gymnasium.make_vec if many else gymnasium.make
    try:
        env = make(ID, **given, **({"num_envs": 2} if many else {}))
    except InvalidInput:  # a decomposition that this team cannot have, for example
        reject()
    again = as_json_has_it(env, make)
    assert again.unwrapped.transport.config == env.unwrapped.transport.config


@settings(max_examples=10, deadline=None, suppress_health_check=SLOW)
@given(VALUES, st.sampled_from(OWN))
def test_what_no_text_can_hold_is_refused_by_the_name_of_its_part(values, own):
    env: Any = gymnasium.make(ID, **{**values, "partner": None, **own})
    with pytest.raises(InvalidInput, match=rf"^{next(iter(own))}\b.*\bcoopenv.register\b"):
        env.spec.to_json()


def test_numbers_in_arrays_and_modes_of_gymnasium_come_back():
    limits = np.array([3.0, 4.0])
    vector: Any = gymnasium.make_vec(
        ID,
        num_envs=2,
        force_limit=limits,
        torque_limit=np.float32(2.5),
        autoreset_mode=AutoresetMode.SAME_STEP,
    )
    again = as_json_has_it(vector, gymnasium.make_vec).unwrapped
    assert again.transport.config.force_limit == (3.0, 4.0)
    assert again.transport.config.torque_limit == 2.5
    assert again.autoreset_mode is AutoresetMode.SAME_STEP


def test_a_wrapper_that_no_text_can_hold_is_told_from_its_environment():
    bare = gymnasium.make(ID)
    wrapped = gymnasium.wrappers.TransformReward(bare, lambda reward: reward)
    assert wrapped.spec is not None
    with pytest.raises(InvalidInput, match="a wrapper must be something that JSON can hold"):
        wrapped.spec.to_json()
    assert bare.spec is not None
    kept = gymnasium.wrappers.RecordEpisodeStatistics(bare)
    assert kept.spec is not None
    again = gymnasium.make(EnvSpec.from_json(kept.spec.to_json()))
    assert isinstance(again, gymnasium.wrappers.RecordEpisodeStatistics)
