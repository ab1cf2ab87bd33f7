"""Two agents carry a beam through an open room: the PettingZoo module of ``BeamTransport``."""

from typing import Any

from coopenv.envs.registry import views

__all__ = ["env", "parallel_env", "single_env", "vector_env"]

DEFAULTS: dict[str, Any] = {}

parallel_env, env, single_env, vector_env = views("beam_transport_v0", DEFAULTS)
