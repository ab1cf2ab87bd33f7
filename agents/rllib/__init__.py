"""RLlib: multi-agent PPO over PettingZoo's view, on one machine or a Ray cluster; `[rllib]`.

``python -m coopenv.agents.rllib --help``, or ``make rllib``, as RLlib needs an environment of its
own. The policy that is trained becomes one in plain numbers, which needs neither Ray nor torch.
"""

from .settings import RLlibConfig
from .training import require_rllib, train

__all__ = ["RLlibConfig", "require_rllib", "train"]
