"""Gymnasium specifications that come back from JSON as they were, or say that they cannot."""

import json
from dataclasses import fields, replace
from typing import Any

from gymnasium.envs.registration import EnvSpec, load_env_creator

from coopenv.config import ALIASES, TransportConfig
from coopenv.config.json_form import shown
from coopenv.errors import InvalidInput

NAMES = (*ALIASES, *(entry.name for entry in fields(TransportConfig)))


class TransportSpec(EnvSpec):
    """A specification that checks what it writes."""

    def to_json(self) -> str:
        """The specification as JSON.

        Raises
        ------
        InvalidInput
            If another configuration, or none, would be read from it.
        """
        kwargs = {name: shown(value, name) for name, value in self.kwargs.items()}
        text = EnvSpec.to_json(replace(self, kwargs=kwargs))
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
    """An environment whose specification is a `TransportSpec`."""

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """What ``gymnasium.make`` made it from; ``None`` if it did not."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        if spec is not None and not isinstance(spec, TransportSpec):
            given = {entry.name: getattr(spec, entry.name) for entry in fields(spec) if entry.init}
            spec = TransportSpec(**given)
        self._spec = spec


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
