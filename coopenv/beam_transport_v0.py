"""Two agents carry a beam through an open room: the PettingZoo module of ``BeamTransport``."""

from typing import Any

from coopenv.envs.registry import register_module

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {}

parallel_env, env, single_env, vector_env = register_module(
    __name__, "coopenv/BeamTransport-v0", DEFAULTS
)
