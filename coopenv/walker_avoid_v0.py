"""A human steers a walker past an obstacle that its drive senses: ``WalkerAvoid``."""

from typing import Any

from coopenv.envs.registry import register
from coopenv.observation import DEFAULT_BLOCKS
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.walker_avoid import WalkerAvoidTask

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {
    "task": WalkerAvoidTask(),
    "body": Body.walker(),
    "scene": Scene(size=(8.0, 6.0)),
    "observe": (*DEFAULT_BLOCKS, "nearest"),
    "force_limit": 30.0,  # [N]
    "torque_limit": 80.0,  # [N·m] 0.8 rad/s against the walker's drag
    "horizon": 400,  # 20 s
    "informed": (0,),  # the human knows where to go
}

parallel_env, env, single_env, vector_env = register(
    "coopenv/WalkerAvoid-v0", module=__name__, **DEFAULTS
)
