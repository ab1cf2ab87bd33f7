"""Two agents carry a beam through an open room: the PettingZoo module of ``BeamTransport``."""

from typing import Any

from coopenv.envs.registry import register

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {}

parallel_env, env, single_env, vector_env = register(
    "coopenv/BeamTransport-v0", module=__name__, **DEFAULTS
)
