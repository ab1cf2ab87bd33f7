"""Functions of the user's own as entries: their names, and what they are by their parameters."""

import sys
from collections.abc import Callable
from importlib import import_module
from inspect import Parameter, signature
from typing import Any

import numpy.typing as npt

from coopenv.config import TransportConfig
from coopenv.config.own_code import read_hash
from coopenv.errors import InvalidInput, UnknownName
from coopenv.transition import Transition

from ..policy import Policy

ACTS = "act(obs) or act(obs, transition)"
FORMS = f"{ACTS}, or make(config) that returns one of these"
_PLACES = Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD


class Own:
    """What a function that the command names enters, and makes for each scenario.

    A function ``act(obs)`` is a policy of what is observed alone; ``act(obs, transition)`` is a
    `coopenv.agents.policy.Policy`; ``make(config)``, a class for example, makes either for the
    environment of a scenario.

    Parameters
    ----------
    name
        ``module:function``; the module is imported.

    Raises
    ------
    InvalidInput, UnknownName
        If there is no such function, or it takes something else.
    """

    def __init__(self, name: str):
        self._name, self._given = name, _found(name)
        needed = _needed(self._given, name)
        self._makes = needed == ["config"]
        if not self._makes and len(needed) not in (1, 2):
            raise InvalidInput(f"{name} must take one of the known forms, {_took(needed, FORMS)}")
        self.sees = "observation" if len(needed) == 1 and not self._makes else "state"
        path = getattr(sys.modules[name.partition(":")[0]], "__file__", None)
        self.sha256 = None if path is None else read_hash(path)

    def policy(self, config: TransportConfig) -> Policy:
        """What acts in an environment.

        Raises
        ------
        InvalidInput
            If what was made for it does not act.
        """
        act: Any = self._given(config) if self._makes else self._given
        needed = _needed(act, self._name)
        if len(needed) not in (1, 2):
            raise InvalidInput(f"{self._name} must return what acts, {_took(needed, ACTS)}")
        return _Observing(act) if len(needed) == 1 else act


class _Observing:
    """A policy that is handed the observation alone."""

    def __init__(self, act: Callable[[npt.NDArray], Any]):
        self._act = act

    def __call__(self, obs: npt.NDArray, transition: Transition) -> Any:
        return self._act(obs)

    def __getattr__(self, name: str) -> Any:
        if name in ("reset", "seed_episodes"):  # of one that remembers, or draws
            return getattr(self._act, name)
        raise AttributeError(name)


def _found(name: str) -> Callable[..., Any]:
    module, _, inside = name.partition(":")
    try:
        found: Any = import_module(module)
    except (Exception, SystemExit) as error:
        raise InvalidInput(
            f"entry must be in a module that can be imported, got {module!r}: "
            f"{type(error).__name__}: {error}; mend it, or put its folder on PYTHONPATH"
        ) from error
    for step in inside.split("."):
        if not hasattr(found, step):
            raise UnknownName(f"name in {module}", inside, dir(found))
        found = getattr(found, step)
    return found


def _needed(act: Any, name: str) -> list[str]:
    """Names of what has to be given, by place."""
    try:
        known = signature(act).parameters.values()
    except (TypeError, ValueError) as error:  # nothing that is called, or a builtin
        raise InvalidInput(
            f"{name} must be called, and say by what, got {act!r:.80}; write {FORMS}"
        ) from error
    return [each.name for each in known if each.default is each.empty and each.kind in _PLACES]


def _took(needed: list[str], forms: str) -> str:
    return f"got one that takes ({', '.join(needed)}); write {forms}"
