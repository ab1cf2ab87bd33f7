"""What a training of any of the algorithms acts in and sees."""

from typing import Any

from coopenv import TransportConfig
from coopenv.agents.environment import EnvironmentChoice
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX


def environment_of(env: str, action: Any = None) -> TransportConfig:
    """That of a name such as BeamLift, with the blocks that a training of PPO in it sees.

    Parameters
    ----------
    env
        The name.
    action
        What agents give, if not what the environment has.
    """
    return train_config(
        EnvironmentChoice(env=f"{PREFIX}{env}-v0", action=action)
    ).environment.config()
