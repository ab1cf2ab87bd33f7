"""Algorithms of Stable-Baselines3 and sb3-contrib: which of them a saved policy is of."""

from typing import Any

import stable_baselines3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy

from coopenv.errors import InvalidInput, MissingExtra

OURS = ("stable_baselines3", "sb3_contrib")  # packages whose algorithms load without being named
_BY_POLICY = {  # module of the policy's class: the algorithm that acts with it
    "stable_baselines3.sac.policies": "stable_baselines3:SAC",
    "stable_baselines3.td3.policies": "stable_baselines3:TD3",  # DDPG as well, which acts alike
    "stable_baselines3.dqn.policies": "stable_baselines3:DQN",
    "sb3_contrib.ars.policies": "sb3_contrib:ARS",
    "sb3_contrib.common.maskable.policies": "sb3_contrib:MaskablePPO",
    "sb3_contrib.common.recurrent.policies": "sb3_contrib:RecurrentPPO",
    "sb3_contrib.crossq.policies": "sb3_contrib:CrossQ",
    "sb3_contrib.qrdqn.policies": "sb3_contrib:QRDQN",
    "sb3_contrib.tqc.policies": "sb3_contrib:TQC",
}


def name_of(algorithm: type[BaseAlgorithm]) -> str:
    """``module:class``, as it is written into a file."""
    return f"{algorithm.__module__}:{algorithm.__qualname__}"


def find_algorithm(name: str) -> type[BaseAlgorithm]:
    """The algorithm of that ``module:class``, if it is one of SB3's or sb3-contrib's.

    Raises
    ------
    InvalidInput
        If it is somebody else's: a file shall not say what is imported.
    MissingExtra
        If sb3-contrib is not installed.
    """
    module, _, kind = name.partition(":")
    package = module.partition(".")[0]
    found = getattr(_package(package, kind), kind, None) if package in OURS else None
    if not isinstance(found, type) or not issubclass(found, BaseAlgorithm):
        raise InvalidInput(
            f"algorithm must be given for a policy that {name} trained, got none; "
            f"SB3Policy.load(path, algorithm={kind or name})"
        )
    return found


def algorithm_of(policy_class: Any, entries: dict[str, Any]) -> type[BaseAlgorithm]:
    """The algorithm behind a file that SB3 itself wrote, which does not name it.

    Parameters
    ----------
    policy_class
        The class of the policy in it.
    entries
        The attributes of the model that it holds, by name.
    """
    for kind in getattr(policy_class, "__mro__", ()):
        if kind.__module__ in _BY_POLICY:
            return find_algorithm(_BY_POLICY[kind.__module__])
        if kind is ActorCriticPolicy:  # that of three; what they are set with tells them apart
            if "cg_max_steps" in entries:
                return find_algorithm("sb3_contrib:TRPO")
            return find_algorithm(
                f"stable_baselines3:{'PPO' if 'clip_range' in entries else 'A2C'}"
            )
    raise InvalidInput(
        f"algorithm must be given for a policy of the class {policy_class!r}, got none; "
        "SB3Policy.load(path, algorithm=...)"
    )


def missing_contrib(error: ImportError) -> bool:
    """Whether something could not be imported for want of sb3-contrib."""
    return (error.name or "").partition(".")[0] == "sb3_contrib"


def _package(package: str, kind: str) -> Any:
    if package == "stable_baselines3":
        return stable_baselines3
    try:
        import sb3_contrib
    except ImportError as error:
        raise MissingExtra(f"a policy that {kind} of sb3-contrib trained", "contrib") from error
    return sb3_contrib
