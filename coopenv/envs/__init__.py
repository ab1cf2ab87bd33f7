"""Thin views of `coopenv.Transport`: Gymnasium, Gymnasium vector, PettingZoo."""

from coopenv.envs.parallel import TransportParallelEnv
from coopenv.envs.single import TransportEnv
from coopenv.envs.vector import TransportVectorEnv

__all__ = ["TransportEnv", "TransportParallelEnv", "TransportVectorEnv"]
