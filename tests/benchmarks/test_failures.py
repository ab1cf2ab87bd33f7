"""What is said of episodes that failed."""

import numpy as np
import pytest

pytest.importorskip("tyro")

from benchmarks.learning.failures import Ends, Failures, failures, kind, reached
from coopenv import Transport
from coopenv.envs.registry import find_config
from coopenv.info import Info

AWAY = 2.0  # [m]
NO_REWARD = np.zeros((2, 2))


def seen(core):
    """The newest transition."""
    assert core.transition is not None
    return core.transition


@pytest.mark.parametrize(
    ("end", "said"),
    [
        ((AWAY, 0.0, 0.0), "at wall and obstacle"),
        ((AWAY, 0.0, 1.0), "at wall"),
        ((0.3, 1.0, 0.01), "at obstacle"),
        ((0.3, 1.0, 1.0), "within 0.5 m of the goal"),
        ((AWAY, 1.0, np.inf), "elsewhere"),
    ],
)
def test_an_end_is_told_by_what_is_touched_then_by_the_goal(end, said):
    assert kind(np.array(end)) == said


def test_the_last_step_of_an_episode_is_kept():
    core = Transport(num_worlds=2, config=find_config("coopenv/WalkerAvoid-v0", {}))
    core.reset(seed=0)
    begun = reached(seen(core))
    assert (begun > 0).all()
    ends = Ends()
    ends.add(seen(core), NO_REWARD, Info(), np.array([True, True]))
    core.reset(seed=7)
    ends.add(seen(core), NO_REWARD, Info(), np.array([True, False]))  # the second had ended
    ends.end(2)
    (kept,) = ends.all
    np.testing.assert_array_equal(kept[1], begun[1])
    np.testing.assert_array_equal(kept[0], reached(seen(core))[0])
    assert (kept[0] != begun[0]).any()


def test_a_room_without_obstacles_has_none_to_touch():
    core = Transport(num_worlds=1, config=find_config("coopenv/BeamTransport-v0", {}))
    core.reset(seed=0)
    assert np.isinf(reached(seen(core))[0, 2])


def test_episodes_of_a_policy_that_failed_are_counted_and_no_others():
    pytest.importorskip("stable_baselines3")
    asked = Failures(policy="pretrained:BeamTransport/joint", episodes=4)
    assert not failures(asked)  # it fails none
