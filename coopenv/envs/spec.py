"""Gymnasium specifications that come back from JSON as they were, or say that they cannot."""

import json
import sys
from dataclasses import fields, replace
from enum import Enum
from typing import Any

from gymnasium.envs.registration import EnvSpec, load_env_creator, make

from coopenv.config import ALIASES, TransportConfig
from coopenv.config.json_form import shown
from coopenv.errors import InvalidInput
from coopenv.transport import Transport

NAMES = (*ALIASES, *(entry.name for entry in fields(TransportConfig)))


class TransportSpec(EnvSpec):
    """A specification that checks what it writes."""

    def to_json(self) -> str:
        """The specification as JSON.

        Raises
        ------
        InvalidInput
            If another configuration, or none, would be read from it; the message names the part.
        """
        plain = {
            name: value.value if isinstance(value, Enum) else value  # Gymnasium's autoreset modes
            for name, value in self.kwargs.items()
        }
        kwargs = {name: shown(value, name) for name, value in plain.items()}
        text = _text(replace(self, kwargs=kwargs))
        wanted, read = _config(self, self.kwargs), _config(self, json.loads(text)["kwargs"])
        for name in (entry.name for entry in fields(TransportConfig)):
            mine, other = getattr(wanted, name), getattr(read, name)
            if mine != other:
                raise InvalidInput(
                    f"{name} must be something that JSON can hold, got {mine!r}, which would come "
                    f"back as {other!r}; make it a default of an id of its own (coopenv.register)"
                )
        return text


class Specified:
    """An environment whose specification is a `TransportSpec`, which tells its horizon."""

    transport: Transport
    _spec: EnvSpec | None = None

    @property
    def _max_episode_steps(self) -> int:
        """The horizon, where tools look for it that read it off Gymnasium's time limit."""
        return self.transport.horizon

    @property
    def spec(self) -> EnvSpec | None:
        """What ``gymnasium.make`` made it from; ``None`` if it did not."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        if spec is not None and not isinstance(spec, TransportSpec):
            given = {entry.name: getattr(spec, entry.name) for entry in fields(spec) if entry.init}
            spec = TransportSpec(**{**given, "max_episode_steps": self.transport.horizon})
        self._spec = spec


def asked_horizon() -> dict[str, int]:
    """The horizon that ``gymnasium.make`` was asked for, if it makes one of our ids now.

    Gymnasium keeps ``max_episode_steps`` to itself and puts a time limit outside, of which the
    environment would not learn: its own horizon would end a longer episode, and the time left of
    a shorter one would be wrong. So it is read where ``make`` holds it.

    Returns
    -------
    ``{"max_episode_steps": ...}``, or nothing.

    Raises
    ------
    InvalidInput
        If a specification with a time limit is given another horizon, which that limit would cut.
    """
    frame = sys._getframe(1)
    while frame is not None and frame.f_code is not make.__code__:
        frame = frame.f_back
    if frame is None:
        return {}
    asked, spec = frame.f_locals["max_episode_steps"], frame.f_locals["env_spec"]
    if asked == -1 or defaults_of(spec) is None:  # no limit; or one of an environment around it
        return {}
    limit = spec.max_episode_steps if asked is None else asked
    if limit is None:
        return {}
    wanted = frame.f_locals["kwargs"].get("horizon", limit)
    if asked is None and wanted != limit:
        raise InvalidInput(
            f"horizon must be given as max_episode_steps where an environment is made from a "
            f"specification that has one, got horizon={wanted} beside its {limit}; rename it"
        )
    return {"max_episode_steps": limit}


def _text(spec: "TransportSpec") -> str:
    """What Gymnasium writes; raises `InvalidInput` that names what it cannot write."""
    try:
        return EnvSpec.to_json(spec)
    except (TypeError, ValueError) as error:
        alone = {
            name: replace(spec, kwargs={name: value}, additional_wrappers=())
            for name, value in spec.kwargs.items()
        }
        part = next((name for name, one in alone.items() if not _is_writable(one)), None)
        what = "a wrapper" if part is None else part
        remedy = (
            "write the specification of env.unwrapped, and wrap what is made from it"
            if part is None
            else "make it a default of an id of its own (coopenv.register)"
        )
        got = spec.additional_wrappers if part is None else spec.kwargs[part]
        raise InvalidInput(
            f"{what} must be something that JSON can hold, got {got!r} ({error}); {remedy}"
        ) from error


def _is_writable(spec: "TransportSpec") -> bool:
    try:
        EnvSpec.to_json(spec)
    except (TypeError, ValueError):
        return False
    return True


def defaults_of(spec: EnvSpec) -> Any:
    """The defaults of the id behind a specification; ``None`` if coopenv did not register it."""
    entry = spec.entry_point
    creator = load_env_creator(entry) if isinstance(entry, str) else entry
    defaults = getattr(creator, "defaults", None)
    return defaults(spec.kwargs) if callable(defaults) else defaults


def _config(spec: EnvSpec, kwargs: dict[str, Any]) -> TransportConfig:
    """The configuration in ``kwargs``, without keywords that only views know."""
    known = {name: value for name, value in kwargs.items() if name in NAMES}
    return TransportConfig.parse(known, defaults_of(spec))
