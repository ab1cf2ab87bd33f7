"""Two agents move a beam along a reference: the PettingZoo module of ``BeamTracking``."""

from typing import Any

from coopenv.envs.registry import register
from coopenv.observation import DEFAULT_BLOCKS
from coopenv.tasks import TrackingTask

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {
    "task": TrackingTask(),
    "reward": "tracking",
    "observe": (*DEFAULT_BLOCKS, "preview", "reference_twist"),
    "horizon": 220,
}

parallel_env, env, single_env, vector_env = register(
    "coopenv/BeamTracking-v0", module=__name__, **DEFAULTS
)
