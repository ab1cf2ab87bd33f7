"""A human and a drive steer a walker on wheels to a pose: the module of ``WalkerTurn``."""

from typing import Any

from coopenv.envs.registry import register
from coopenv.physics.body import Body
from coopenv.tasks.walker_turn import WalkerTurnTask

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {
    "task": WalkerTurnTask(),
    "body": Body.walker(),
    "force_limit": 30.0,  # [N]
    "torque_limit": 80.0,  # [N·m] 0.8 rad/s against the walker's drag
    "horizon": 300,  # 15 s
}

parallel_env, env, single_env, vector_env = register(
    "coopenv/WalkerTurn-v0", module=__name__, **DEFAULTS
)
