"""Two policies by hands for the suite of feeling alone: who is told the goal, and who follows.

Each learns by itself, beside somebody who is there already: the leader, agent 0, beside the partner
that gives way, and the follower beside that leader. Together they are entered as `pair`.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from coopenv import TransportConfig
from coopenv.agents.policy import Policy
from coopenv.agents.pretrained import load
from coopenv.errors import InvalidInput
from coopenv.randomisation import Ranges
from coopenv.transition import Transition

OUT = Path("runs/board")
LEADER, FOLLOWER = "hands-leader-0", "hands-follower-0"  # folders of the runs
PLACES: Mapping[int, str] = {0: LEADER, 1: FOLLOWER}  # agent -> who acts for it
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


def policy_of(name: str, out: Path = OUT) -> Path:
    """The file of a run."""
    return out / name / "policy.zip"


class Pair:
    """Both policies, each of which sees what its agent observes and nothing else.

    Parameters
    ----------
    out
        Folder of the runs.

    Raises
    ------
    InvalidInput
        If it lacks one of them.
    """

    def __init__(self, out: Path = OUT):
        files = {agent: policy_of(name, out) for agent, name in PLACES.items()}
        for file in files.values():
            if not file.is_file():
                raise InvalidInput(
                    f"policy must be there to be entered, got none at {str(file)!r}; run python -m "
                    "benchmarks.board.learners, from the same folder"
                )
        self._policies: dict[int, Policy] = {agent: load(file) for agent, file in files.items()}

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        given = [policy(obs, transition)[:, agent] for agent, policy in self._policies.items()]
        return np.stack(given, axis=1)


def pair(config: TransportConfig) -> Pair:
    """The two of `OUT`, by hands alone."""
    if config.action != "motion" or config.partner is not None:
        raise InvalidInput(
            f"action must be 'motion' without a partner, got {config.action!r} and "
            f"{config.partner!r}; the two learned to move hands, each beside the other"
        )
    return Pair()
