"""Registration of environment ids: their defaults, and the views that start from them."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, NamedTuple

import gymnasium
import pettingzoo
from pettingzoo import AECEnv

from coopenv.config import TransportConfig
from coopenv.config.own_code import Trust, is_trusted
from coopenv.envs.parallel import TransportParallelEnv, aec
from coopenv.envs.single import TransportEnv
from coopenv.envs.spec import defaults_of
from coopenv.envs.vector import TransportVectorEnv
from coopenv.errors import InvalidInput, UnknownName

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
    vars(single_env)["defaults"] = defaults  # find_config reads them
    return Views(parallel_env, env, single_env, vector_env)


_REGISTERED: dict[str, Views] = {}


def register(id: str, *, module: str | None = None, **defaults: Any) -> Views:
    """Give an environment of your own an id of Gymnasium's and PettingZoo's, and all its views.

    ``pettingzoo.make("parallel" or "aec", id)`` knows it from PettingZoo 1.27 on.

    Parameters
    ----------
    id
        For example ``"mine/Lift-v0"``. ``gymnasium.make("my_module:mine/Lift-v0")`` imports the
        module that registers it first.
    module
        ``__name__`` of the module that keeps the views under their own names, as this package's
        modules of environments do: Gymnasium then finds them there, and PettingZoo's tools take
        the module for an environment's. The defaults are tried out when a view is first made, so
        that an import draws no episode.
    **defaults
        Fields of `coopenv.TransportConfig` in which it differs, a task above all. Keywords of a
        view override them.

    Returns
    -------
    ``parallel_env, env, single_env, vector_env``.

    Raises
    ------
    InvalidInput, UnknownName
        If ``id`` or ``module`` is no name, or, without ``module``, the defaults do not make a
        configuration; with it, they raise where a view is made.

    Examples
    --------
    >>> lift = register("mine/Lift-v0", body=Body.plate(3), horizon=300)
    >>> gymnasium.make_vec("mine/Lift-v0", num_envs=16).unwrapped.transport.num_agents
    3
    >>> lift.parallel_env().possible_agents
    ['agent_0', 'agent_1', 'agent_2']
    """
    if not isinstance(id, str) or not id or ":" in id:
        raise InvalidInput(f"id must be a name without a colon, got {id!r}; see gymnasium.register")
    if module is not None and not isinstance(module, str):
        raise InvalidInput(f"module must be the name of a module, got {module!r}; pass __name__")
    keywords = {}
    if module is None:
        TransportConfig.parse({}, defaults)
        keywords["registered"] = f"{sys._getframe(1).f_globals.get('__name__', '__main__')}:{id}"
    name = id.rpartition("/")[2] if module is None else module.rpartition(".")[2]
    _REGISTERED[id] = made = views(name, defaults)
    home = __name__ if module is None else module
    gymnasium.register(
        id=id,
        entry_point=f"{home}:single_env",
        vector_entry_point=f"{home}:vector_env",
        kwargs=keywords,
    )
    _register_with_pettingzoo(id, home, keywords)
    return made


def _register_with_pettingzoo(id: str, home: str, keywords: dict[str, Any]) -> None:
    """Enter both of PettingZoo's views of an id, where PettingZoo has a registry."""
    if hasattr(pettingzoo, "register"):
        pettingzoo.register("parallel", id, f"{home}:parallel_env", kwargs=keywords)
        pettingzoo.register("aec", id, f"{home}:env", kwargs=keywords)


def single_env(*, registered: str, **keywords: Any) -> TransportEnv:
    """The Gymnasium view of an id that `register` entered as ``"module:id"``."""
    return _registered(registered).single_env(**keywords)


def vector_env(num_envs: int = 1, *, registered: str, **keywords: Any) -> TransportVectorEnv:
    """The Gymnasium vector view of an id that `register` entered as ``"module:id"``."""
    return _registered(registered).vector_env(num_envs, **keywords)


def parallel_env(*, registered: str, **keywords: Any) -> TransportParallelEnv:
    """The PettingZoo view of an id that `register` entered as ``"module:id"``."""
    return _registered(registered).parallel_env(**keywords)


def env(*, registered: str, **keywords: Any) -> AECEnv:
    """The PettingZoo view, agents in turn, of an id that `register` entered as ``"module:id"``."""
    return _registered(registered).env(**keywords)


for _made, _kind in ((single_env, TransportEnv), (vector_env, TransportVectorEnv)):
    vars(_made)["metadata"] = _kind.metadata


def _defaults(kwargs: Mapping[str, Any]) -> Mapping[str, Any]:
    return vars(_registered(kwargs["registered"]).single_env)["defaults"]


vars(single_env)["defaults"] = _defaults


def find_config(env: str, keywords: Mapping[str, Any]) -> TransportConfig:
    """The configuration behind a Gymnasium id and keywords.

    Parameters
    ----------
    env
        An id of this package or one given by `register`; ``"module:id"`` imports the module that
        registers it first.
    keywords
        Fields of `coopenv.TransportConfig`, over those of the id.

    Raises
    ------
    UnknownName
        If there is no such id, or it is not of this package's making.
    InvalidInput
        If the module cannot be imported.
    """
    if not isinstance(env, str):
        raise UnknownName("env", env, _REGISTERED)
    module, _, name = env.rpartition(":")
    if module:
        _import(module)
    spec = gymnasium.registry.get(name)
    defaults = None if spec is None else defaults_of(spec)
    if spec is None or defaults is None:
        raise UnknownName("env", env, _REGISTERED)
    own = {key: value for key, value in spec.kwargs.items() if key != "registered"}
    return TransportConfig.parse({**own, **keywords}, defaults)


def require_trusted(env: str, trust: Trust, source: str) -> None:
    """Raise `InvalidInput` if ``env``, which a file says, would import what is not trusted.

    Parameters
    ----------
    env
        Id, perhaps ``"module:id"``.
    trust
        Modules that may be imported because a file names them.
    source
        The file, for the error.
    """
    module, _, _ = env.rpartition(":")
    if module and not is_trusted(module, trust):
        raise InvalidInput(
            f"env must be an id without a module where a file says it, got {env!r} in {source}, "
            f"which would import and run {module!r}; if you know where the file is from, give "
            f"--env {env} on the command line, or --trust"
        )


def _registered(name: str) -> Views:
    module, _, id = name.rpartition(":")
    if id not in _REGISTERED:
        _import(module)
    if id not in _REGISTERED:
        raise UnknownName("env", id, _REGISTERED)
    return _REGISTERED[id]


def _import(module: str) -> None:
    try:
        import_module(module)
    except ModuleNotFoundError as error:
        raise InvalidInput(
            f"the module of an id must be importable, got {module!r} ({error}); put its folder on "
            "PYTHONPATH, or import it before"
        ) from error
