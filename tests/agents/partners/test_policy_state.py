"""The state of episodes beside a partner that is a policy: its memory is kept and put back."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from coopenv import Sensor, Transport, TransportConfig
from coopenv.agents import sb3
from coopenv.agents.partners import LearnedPartner
from coopenv.agents.policy import RandomPolicy
from coopenv.errors import InvalidInput
from tests.agents.learned.cases import trained
from tests.agents.partners.cases import Counting
from tests.helpers import NEVER

SEEN = TransportConfig(
    task=NEVER, observe=("goal", Sensor("twist", noise=0.1, delay=2)), horizon=50
)
OTHER = replace(SEEN, observe=("time",))


@pytest.fixture(scope="module")
def recurrent(tmp_path_factory) -> str:
    """The file of a policy that remembers."""
    path = tmp_path_factory.mktemp("policies") / "recurrent.zip"
    venv = sb3.make_vec_env(SEEN, 2, control="shared")
    model = trained("RecurrentPPO", venv)
    sb3.SB3Policy(model, notes=venv.to_notes()).save(path)
    return str(path)


@pytest.fixture(params=["remembers", "draws", "learned", "nothing"])
def partner(request, recurrent) -> Any:
    """A learned policy with a memory, mean and sampled, a random one, and a function."""
    return {
        "remembers": recurrent,
        "draws": LearnedPartner(path=recurrent, deterministic=False, seed=3),
        "learned": RandomPolicy(SEEN),
        "nothing": lambda obs, _: np.full((*obs.shape[:2], 3), 0.2),
    }[request.param]


def pushes(core: Transport, steps: int = 8) -> np.ndarray:
    """What the partner does in the next steps."""
    done = []
    for _ in range(steps):
        core.step(np.zeros(core.action_shape))
        assert core.transition is not None
        done.append(core.transition.action[:, 1])
    return np.array(done)


def test_a_policy_goes_on_from_a_state_as_it_went_on_from_there(partner):
    core = Transport(num_worlds=3, config=replace(OTHER, partner=partner))
    core.reset(seed=0)
    pushes(core, 5)
    core.reset(mask=np.array([False, True, False]))  # world 1 is in another step of its episode
    state = core.get_state()
    wanted = pushes(core)
    core.set_state(state)
    np.testing.assert_array_equal(pushes(core), wanted)
    other = Transport(num_worlds=3, config=core.config)
    other.set_state(state)
    np.testing.assert_array_equal(pushes(other), wanted)
    many = Transport(num_worlds=4, config=core.config)
    many.reset(seed=9)
    pushes(many, 1)
    many.set_state(state.take([1, 0]), [3, 1])
    np.testing.assert_allclose(pushes(many)[:, [1, 3]], wanted[:, [0, 1]], atol=1e-5)


def test_what_a_policy_remembers_goes_through_a_pickle(recurrent):
    core = Transport(num_worlds=2, config=replace(OTHER, partner=recurrent))
    core.reset(seed=0)
    pushes(core, 5)
    twin = pickle.loads(pickle.dumps(core))
    np.testing.assert_array_equal(pushes(twin), pushes(core))


def test_a_policy_that_does_not_tell_what_it_remembers_is_refused():
    core = Transport(num_worlds=2, config=replace(OTHER, partner=Counting(2)))
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match=r"policy of a partner must have get_state .* Counting"):
        core.get_state()
