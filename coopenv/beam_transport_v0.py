"""Two agents carry a beam through an open room: the PettingZoo module of ``BeamTransport``."""

from typing import Any

from pettingzoo import AECEnv

from coopenv.envs.parallel import TransportParallelEnv, aec

__all__ = ["env", "parallel_env"]

NAME = "beam_transport_v0"


def parallel_env(**keywords: Any) -> TransportParallelEnv:
    """The ``ParallelEnv``; takes ``render_mode`` and the fields of `coopenv.TransportConfig`."""
    return TransportParallelEnv(name=NAME, **keywords)


def env(**keywords: Any) -> AECEnv:
    """The AEC view of `parallel_env`, with the same keywords."""
    return aec(parallel_env(**keywords))
