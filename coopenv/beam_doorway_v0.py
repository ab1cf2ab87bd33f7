"""Two agents carry a beam through a gap in a wall: the PettingZoo module of ``BeamDoorway``."""

from typing import Any

from coopenv.envs.registry import register
from coopenv.observation import DEFAULT_BLOCKS
from coopenv.physics.scene import Scene
from coopenv.tasks import DoorwayTask

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {
    "task": DoorwayTask(),
    "scene": Scene(size=(7.0, 4.0)),
    "observe": (*DEFAULT_BLOCKS, "gap"),
    "horizon": 300,
}

parallel_env, env, single_env, vector_env = register(
    "coopenv/BeamDoorway-v0", module=__name__, **DEFAULTS
)
