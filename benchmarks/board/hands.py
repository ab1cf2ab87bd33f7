"""Two policies by hands for the suite of feeling alone: who is told the goal, and who follows.

Each learns by itself, beside somebody who is there already: the leader, agent 0, beside the partner
that gives way, and the follower beside that leader. Together they are entered as `pair`; as
`led` the leader is entered with the scripted follower in place of the other.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from coopenv import TransportConfig
from coopenv.agents.controllers import Follower
from coopenv.agents.policy import Policy
from coopenv.agents.pretrained import load
from coopenv.errors import InvalidInput
from coopenv.randomisation import Ranges
from coopenv.transition import Transition

OUT = Path("runs/board")
LEADER, FOLLOWER = "hands-leader-0", "hands-follower-0"  # folders of the runs
MASS = (7.0, 21.0)  # [kg], so that one policy knows both beams of the suite
HORIZON = 300  # [control steps] of the heavier one


def environment(partner: str, agent: int) -> TransportConfig:
    """What one of the two learns in: as the suite's, beside ``partner`` who is the ``agent``."""
    return TransportConfig.parse(
        {
            "action": "motion",
            "sensing": "own",
            "informed": (0,),
            "horizon": HORIZON,
            "randomise": Ranges(mass=MASS),
            "partner": partner,
            "partner_agents": (agent,),
        }
    )


def policy_of(name: str, out: Path) -> Path:
    """The file of a run."""
    return out / name / "policy.zip"


class Pair:
    """A policy for each of two agents, asked for the actions of both; those of its own are taken.

    Unlike `coopenv.agents.controllers.Roles` it asks none whether it learned in such a team.

    Parameters
    ----------
    policies
        Of agent 0 and of agent 1, without a memory.
    """

    def __init__(self, *policies: Policy):
        self._policies = policies

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        given = [each(obs, transition)[:, agent] for agent, each in enumerate(self._policies)]
        return np.stack(given, axis=1)


def pair(config: TransportConfig) -> Pair:
    """Both that learned, each of which sees what its agent observes and nothing else."""
    _check(config)
    return Pair(learned(LEADER), learned(FOLLOWER))


def led(config: TransportConfig) -> Pair:
    """The leader that learned, with the scripted follower that gives way to what it feels."""
    _check(config)
    return Pair(learned(LEADER), Follower(config))


def learned(name: str) -> Policy:
    """The policy of a run in `OUT`.

    Raises
    ------
    InvalidInput
        If it is not there.
    """
    file = policy_of(name, OUT)
    if not file.is_file():
        raise InvalidInput(
            f"policy must be there to be entered, got none at {str(file)!r}; run python -m "
            "benchmarks.board.learners, from the same folder"
        )
    return load(file)


def _check(config: TransportConfig) -> None:
    if config.action != "motion" or config.partner is not None:
        raise InvalidInput(
            f"action must be 'motion' without a partner, got {config.action!r} and "
            f"{config.partner!r}; the two learned to move hands, each beside the other"
        )
