"""Rewards from which nothing can be learned are told by their term, not called a divergence."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents.sb3 import make_vec_env
from coopenv.agents.train import train
from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.rewards import RewardSum, Success
from coopenv.transition import Transition
from tests.agents.training.cases import SHORT, tiny


@dataclass(frozen=True)
class Late:
    """Something else than zero from the fourth step on."""

    value: str

    def __call__(self, transition: Transition) -> FloatArray:
        paid = np.zeros(transition.applied.shape[:2])
        paid[transition.next_state.time > 3.5 * transition.dt] = float(self.value)
        return paid


def paying(value: str):
    return replace(SHORT, reward=RewardSum({"success": Success(), "late": Late(value)}))


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e300", "-1e300", "1e13"])
def test_a_term_that_pays_no_number_to_learn_from_is_named(value, tmp_path):
    with pytest.raises(InvalidInput, match=r"reward 'late' must be finite.*mend the term") as said:
        train(tiny(tmp_path), environment=paying(value))
    assert "diverged" not in str(said.value)
    assert not (tmp_path / "policy.zip").exists()


@pytest.mark.parametrize("control", ["joint", "shared", "partner"])
def test_large_rewards_are_handed_on_up_to_the_bound(control):
    venv = make_vec_env(paying("1e12"), 3, control=control)
    venv.reset()
    still = np.zeros((venv.num_envs, *(venv.action_space.shape or ())))
    paid = [venv.step(still)[1] for _ in range(4)]
    assert (paid[-1] == np.float32(1e12)).all()
