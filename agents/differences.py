"""Differences between two environments in JSON: the dotted names of their parts, and in words."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.physics.body import Body
from coopenv.rewards import COSTS, PRESETS, find_reward

from .environment.overrides import with_team
from .partners import PARTNERS, LearnedPartner

Change = tuple[str, Any, Any]
"""Dotted name of a part, such as ``environment.reward.progress.weight``, and its two values;
``None`` where it is missing."""
_UNSAID = ("kind", "name", "sha256", "fields")  # of a part in words: said otherwise, or of no use


def changes(one: Any, other: Any, path: str = "") -> Iterator[Change]:
    """The parts in which two JSON values differ, as deep as both have them.

    Terms of a reward are known by their names, in whatever order.
    """
    one, other = _by_name(one), _by_name(other)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        if one.get("kind") == other.get("kind"):
            for name in dict.fromkeys((*one, *other)):
                yield from changes(one.get(name), other.get(name), f"{path}.{name}".lstrip("."))
            return
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for number, (mine, theirs) in enumerate(zip(one, other, strict=True)):
            yield from changes(mine, theirs, f"{path}[{number}]")
        return
    if one != other:
        yield path, one, other


def differences(one: Any, other: Any) -> list[str]:
    """Dotted names of the parts in which two JSON values differ."""
    return [name for name, _, _ in changes(one, other)]


def described(config: TransportConfig, default: TransportConfig) -> list[str]:
    """What a configuration has other than ``default``, a few words for each part."""
    now, then = (json.loads(one.to_json()) for one in (config, default))
    words = []
    held = _held(config, default)
    if held is not None and now["body"] != then["body"]:
        words.append(f"team {config.num_agents}")
        then["body"] = held
    for field in now:
        if now[field] == then[field]:
            continue
        name = _known_name(field, config)
        if name:
            words.append(f"{field} {name}")
        elif field == "observe":
            words.append(f"observe {' '.join(map(_short, now[field]))}")
        else:
            found = changes(then[field], now[field], field)
            words += [f"{part} {_short(value)}" for part, _, value in found]
    return words


def _held(config: TransportConfig, default: TransportConfig) -> Any:
    """The default's body as the team of ``config`` holds it, if it is held so; else ``None``."""
    try:
        made = with_team(default, config.num_agents)
    except InvalidInput:
        return None
    bodies = (config.body, made.body)
    alike = all(isinstance(body, Body) for body in bodies) and all(
        getattr(bodies[0], name) == getattr(bodies[1], name) for name in ("outline", "grips")
    )
    return json.loads(made.to_json())["body"] if alike else None


def _by_name(value: Any) -> Any:
    """The terms of a reward as an object, so that one that is added moves no other."""
    if isinstance(value, Mapping) and value.get("kind") == "coopenv.rewards.RewardSum":
        terms = value.get("terms")
        if isinstance(terms, list) and all(map(_is_term, terms)):
            return {entry["name"]: entry["term"] for entry in terms}
    return value


def _is_term(entry: Any) -> bool:
    """Whether it is as a configuration writes a term; a damaged file may hold anything."""
    return isinstance(entry, Mapping) and isinstance(entry.get("name"), str) and "term" in entry


def _known_name(field: str, config: TransportConfig) -> str | None:
    """What the field's value is called where names are given, if it is one of those."""
    if field == "reward":
        return next((name for name in PRESETS if find_reward(name) == config.reward), None)
    if field == "cost":
        known = {**COSTS, **PRESETS}
        return next((name for name, cost in known.items() if cost == config.cost), None)
    if field == "partner":
        partner = config.partner
        if isinstance(partner, LearnedPartner):
            return partner.path if partner == LearnedPartner(path=partner.path) else None
        return next((name for name, kind in PARTNERS.items() if kind == partner), None)
    return None


def _short(value: Any) -> str:
    """A value on one line with all of its numbers; what is not set is left out."""
    if isinstance(value, Mapping):
        kind = str(value.get("kind", "")).rpartition(".")[2]
        name = str(value.get("name", kind))
        fields = value.get("fields") if "sha256" in value else None  # of a class of one's own
        rest = {**value, **fields} if isinstance(fields, Mapping) else value
        rest = {key: entry for key, entry in rest.items() if key not in _UNSAID}
        said = [f"{key}={_short(entry)}" for key, entry in rest.items() if entry not in (None, [])]
        return f"{name}({', '.join(said)})" if said else name or "other"
    if isinstance(value, list):
        return f"[{', '.join(map(_short, value))}]"
    return "none" if value is None else str(value)
