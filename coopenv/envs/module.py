"""What every environment id consists of: its defaults, and the views that start from them."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, NamedTuple

import gymnasium
from pettingzoo import AECEnv

from coopenv.config import TransportConfig
from coopenv.envs.parallel import TransportParallelEnv, aec
from coopenv.envs.single import TransportEnv
from coopenv.envs.vector import TransportVectorEnv
from coopenv.errors import UnknownName

PREFIX = "coopenv/"


class Views(NamedTuple):
    """The constructors of an id; all take the fields of `coopenv.TransportConfig` as keywords."""

    parallel_env: Callable[..., TransportParallelEnv]  # PettingZoo, all agents at once
    env: Callable[..., AECEnv]  # PettingZoo, agents in turn
    single_env: Callable[..., TransportEnv]  # Gymnasium
    vector_env: Callable[..., TransportVectorEnv]  # Gymnasium, many worlds


def views(name: str, defaults: Mapping[str, Any]) -> Views:
    """The views of an environment that is called ``name`` and differs in ``defaults``."""

    def parallel_env(**keywords: Any) -> TransportParallelEnv:
        """The ``ParallelEnv``; takes ``render_mode`` and the fields of `TransportConfig`."""
        return TransportParallelEnv(name=name, defaults=defaults, **keywords)

    def env(**keywords: Any) -> AECEnv:
        """The AEC view of ``parallel_env``, with the same keywords."""
        return aec(parallel_env(**keywords))

    def single_env(**keywords: Any) -> TransportEnv:
        """The Gymnasium view; takes ``render_mode`` and the fields of `TransportConfig`."""
        return TransportEnv(defaults=defaults, **keywords)

    def vector_env(num_envs: int = 1, **keywords: Any) -> TransportVectorEnv:
        """The Gymnasium vector view of ``num_envs`` worlds."""
        return TransportVectorEnv(num_envs, defaults=defaults, **keywords)

    for made, kind in ((single_env, TransportEnv), (vector_env, TransportVectorEnv)):
        vars(made)["metadata"] = kind.metadata  # gymnasium.make reads render modes off it
    return Views(parallel_env, env, single_env, vector_env)


def find_config(env: str, keywords: Mapping[str, Any]) -> TransportConfig:
    """The configuration behind a Gymnasium id of this package and keywords.

    Raises
    ------
    UnknownName
        If there is no such id.
    """
    ours = [name for name in gymnasium.registry if name.startswith(PREFIX)]
    if env not in ours:
        raise UnknownName("env", env, ours)
    spec = gymnasium.spec(env)
    module = import_module(str(spec.entry_point).partition(":")[0])
    return TransportConfig.parse({**spec.kwargs, **keywords}, module.DEFAULTS)
