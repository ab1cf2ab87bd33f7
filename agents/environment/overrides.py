"""Numbers of body, scene, task, ranges, hands, actuators and reward weights, changed by name."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from coopenv.arrays import whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, UnknownName
from coopenv.files import toml
from coopenv.physics.actuators import Actuators
from coopenv.physics.body import Body
from coopenv.physics.hands import Hands
from coopenv.physics.scene import Box
from coopenv.randomisation import Ranges

GROUPS = ("body", "scene", "task", "randomise", "hands", "actuators", "weights")


def changed(
    config: TransportConfig, given: Mapping[str, Sequence[str]], *, team: int | None = None
) -> TransportConfig:
    """``config`` with what is given of its `GROUPS`; all else, the task's kind too, stays.

    Parameters
    ----------
    config
        Of the environment.
    given
        Group → entries ``NAME=VALUE``; values as in TOML or JSON, a word without quotation marks.
        The last of a name counts. ``weights`` are those of the reward's terms.
    team
        How many agents hold the body, as `with_team` has it; ``None``: those that do.

    Raises
    ------
    InvalidInput, UnknownName
        If an entry has another form, a name does not exist, or a value breaks its rule.
    """
    read = {name: values_of(entries, name) for name, entries in given.items() if entries}
    values: dict[str, Any] = {}
    for name in ("scene", "task"):
        if name in read:
            values[name] = _each(getattr(config, name), read[name], name)
    if "body" in read:
        values["body"] = _each(config.body, read["body"], "body")
    if team is not None:
        if "grips" in read.get("body", {}):
            raise InvalidInput(
                f"body must leave grips to team, got grips beside a team of {team!r}, which holds "
                "the body evenly round its rim; leave one of them out"
            )
        values["body"] = _held(values.get("body", config.body), team)
    if "randomise" in read:
        values["randomise"] = _each(config.randomise or Ranges(), read["randomise"], "randomise")
    if "hands" in read:
        values["hands"] = _each(config.hands or Hands(), read["hands"], "hands")
    if "actuators" in read:
        own = config.actuators or Actuators()
        values["actuators"] = _each(own, read["actuators"], "actuators")
    if "weights" in read:
        values["reward"] = config.terms.with_weights(**read["weights"])
    return replace(config, **values) if values else config


def with_team(config: TransportConfig, num_agents: int) -> TransportConfig:
    """``config`` with ``num_agents`` who carry a plate; all else stays.

    The default beam becomes a plate of `coopenv.Body.plate`; a body of another outline keeps it. It
    is held evenly round its rim. Mass, drag and friction stay, and so does an inertia other than
    that of the outline.

    Raises
    ------
    InvalidInput
        If the body rolls on wheels or every world has its own, the number is not one from 1 to
        1000, or something in ``config`` is said for each of the agents that there were.
    """
    return replace(config, body=_held(config.body, num_agents))


def entries_of(group: Any, name: str) -> tuple[str, ...]:
    """A table of a file as entries ``NAME=VALUE``; entries as they are."""
    if isinstance(group, Mapping):
        return tuple(f"{key}={json.dumps(value, default=str)}" for key, value in group.items())
    if not isinstance(group, Sequence) or not all(isinstance(each, str) for each in group):
        raise InvalidInput(f"{name} must be a table of names and values, got {group!r}; write one")
    return (group,) if isinstance(group, str) else tuple(group)


def _held(body: Any, num_agents: int) -> Body:
    """See `with_team`."""
    num_agents = whole(num_agents, "team", at_least=1, at_most=1000)
    if not isinstance(body, Body) or body.nonholonomic:
        got = "one on wheels" if isinstance(body, Body) else "several"
        raise InvalidInput(
            f"team must be of a body that any number of agents can carry, got {got}; leave team "
            "out, or give a Body that does not roll"
        )
    outline = body.outline if body.outline != Body().outline else Body.plate(1).outline
    follows = replace(body, inertia=None) == body  # that of the outline
    held = replace(body, outline=outline, inertia=None if follows else body.inertia)
    return held.held_by(num_agents)


def values_of(entries: Sequence[str], group: str) -> dict[str, Any]:
    """``["mass=4", "grips=[[-1, 0], [1, 0]]"]`` as names and values; ``group`` is for errors."""
    values = {}
    for entry in entries:
        name, equals, text = entry.partition("=")
        if not equals or not name.strip():
            raise InvalidInput(
                f"{group} must be NAME=VALUE, got {entry!r}; write for example "
                f"--{group} {'progress=5' if group == 'weights' else 'NAME=1.5'}"
            )
        values[name.strip().replace("-", "_")] = _value(text.strip())
    return values


def _value(text: str) -> Any:
    """A value of JSON or TOML; a bare word stands for itself, ``none`` for nothing."""
    if text.lower() in ("none", "null"):
        return None
    try:
        return _frozen(toml.loads(f"value = {text}")["value"])
    except toml.TOMLDecodeError:
        pass
    try:
        return _frozen(json.loads(text))
    except ValueError:
        return text


def _frozen(value: Any) -> Any:
    """Lists as tuples, all the way down."""
    if isinstance(value, list):
        return tuple(_frozen(each) for each in value)
    if isinstance(value, dict):
        return {name: _frozen(each) for name, each in value.items()}
    return value


def _each(thing: Any, values: Mapping[str, Any], group: str) -> Any:
    """One object with other values, or each of several."""
    if isinstance(thing, tuple):
        return tuple(_each(one, values, group) for one in thing)
    known = [entry.name for entry in fields(thing)]
    for name in values:
        if name not in known:
            raise UnknownName(f"name in {group}", name, known)
    values = dict(values)
    if "obstacles" in values:
        values["obstacles"] = _boxes(values["obstacles"])
    if isinstance(thing, Body) and replace(thing, inertia=None) == thing:
        values.setdefault("inertia", None)  # that of the outline follows mass and outline
    return replace(thing, **values)


def _boxes(given: Any) -> tuple[Box, ...]:
    rule = "scene.obstacles must be a list of tables with center and size"
    if not isinstance(given, tuple) or not all(isinstance(each, dict) for each in given):
        raise InvalidInput(f"{rule}, got {given!r}; write [{{center = [0, 0], size = [1, 1]}}]")
    known = [entry.name for entry in fields(Box)]
    for each in given:
        for name in each:
            if name not in known:
                raise UnknownName("name in scene.obstacles", name, known)
        if not {"center", "size"} <= set(each):
            raise InvalidInput(f"{rule}, got {each!r}; add what is missing")
    return tuple(Box(**each) for each in given)
