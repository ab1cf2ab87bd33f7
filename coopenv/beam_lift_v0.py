"""Two agents lift a beam over an obstacle onto a shelf: the PettingZoo module of ``BeamLift``."""

from typing import Any

from coopenv.envs.registry import register
from coopenv.observation import DEFAULT_BLOCKS
from coopenv.physics.scene import Scene
from coopenv.tasks import LiftTask

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {
    "task": LiftTask(),
    "scene": Scene(size=(8.0, 5.0), gravity=(0.0, -9.81), normal_gravity=0.0),
    "observe": (*DEFAULT_BLOCKS, "hurdle", "down"),
    "force_limit": 60.0,  # [N]; half of the beam's weight is 38 N
    "torque_limit": 10.0,  # [N·m]
    "horizon": 300,
}

parallel_env, env, single_env, vector_env = register(
    "coopenv/BeamLift-v0", module=__name__, **DEFAULTS
)
