"""Reading of an environment's keywords, and of what JSON makes of their values."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from coopenv.arrays import LARGEST, stated_array, whole
from coopenv.config.json_form import revived
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import (
    BLOCKS,
    DEFAULT_BLOCKS,
    SENSING,
    Entry,
    find_blocks,
    sensed,
)
from coopenv.observation.block import Block
from coopenv.observation.sensor import Sensor
from coopenv.partner import Partner, named_partner
from coopenv.physics.body import Body
from coopenv.physics.hands import Hands
from coopenv.physics.scene import Box, Scene
from coopenv.tasks import TASKS, Task, TransportTask

ALIASES = ("max_episode_steps", "max_cycles")  # of the horizon: Gymnasium's word, PettingZoo's

ELSEWHERE = {  # words that are no keyword of an environment -> where they belong
    **{
        entry.name: f"pass {name}={kind.__name__}({entry.name}=...)"
        for name, kind in (
            ("hands", Hands),  # first: a task's field of the same name is meant oftener
            *(("task", kind) for kind in TASKS),
            ("scene", Scene),
            ("body", Body),
        )
        for entry in fields(kind)
    },
    **dict.fromkeys(
        ("n_envs", "num_envs", "num_worlds"),
        "pass num_envs to gymnasium.make_vec, or num_worlds to coopenv.Transport",
    ),
    **dict.fromkeys(("n_agents", "num_agents"), "pass body=Body(grips=...), one an agent"),
    **{name: f"pass actuators=Actuators({name}=...)" for name in ("time_constant", "rate_limit")},
    "delay": "pass actuators=Actuators(delay=...) for what acts late, or "
    "observe=(Sensor('twist', delay=...), ...) for what is seen late",
    "noise": "pass observe=(Sensor('twist', ...), ...)",
    **dict.fromkeys(("gamma", "discount"), "discounting is the learner's"),
    "length": "pass body=Body.beam(length=...)",
    "options": "pass it to reset",
    "seed": "pass it to reset, as reset(seed=...)",
    "weights": "pass reward=rewards.PRESETS['task'].with_weights(...)",
}


def complete(
    keywords: Mapping[str, Any], defaults: Mapping[str, Any], known: Sequence[str]
) -> dict[str, Any]:
    """``keywords``, with defaults for what they leave out, by the ``known`` names only.

    Defaults are dropped where the keywords bring a task of another kind than theirs. Words of
    `ALIASES` stand for the horizon and override it.

    Raises
    ------
    InvalidInput, UnknownName
        If a name is not known, or ``sensing`` comes beside ``observe``.
    """
    keywords = {name: revived(value, name) for name, value in keywords.items()}
    _check_one_sight(keywords)
    values = _filled(keywords, defaults)
    if keywords.get("sensing") is not None:  # what is given overrides the other's default
        values.pop("observe", None)
    elif "observe" in keywords:
        values.pop("sensing", None)
    for alias in ALIASES:
        steps = values.pop(alias, None)
        if steps is not None:
            values["horizon"] = steps
    for name in values:
        if name not in known:
            raise UnknownName("environment keyword", name, known, ELSEWHERE)
    return values


def _filled(keywords: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """``keywords`` over ``defaults``, which are dropped where the task is of another kind."""
    if "task" not in keywords or "task" not in defaults:
        return {**defaults, **keywords}
    kind, task = type(defaults["task"]), keywords["task"]
    if isinstance(task, Mapping):
        task = _described_task(task, kind)
    return {**(defaults if isinstance(task, kind) else {}), **keywords, "task": task}


def read_task(value: Any) -> Task:
    """The task itself, or the one that a mapping describes."""
    if isinstance(value, Mapping):
        return _described_task(value, TransportTask)
    if not isinstance(value, Task):
        made = isinstance(value, type) and issubclass(value, Task)
        remedy = f"pass {value.__name__}(...)" if made else "write class Mine(coopenv.Task)"
        raise InvalidInput(f"task must be a coopenv.Task, got {value!r}; {remedy}")
    return value


def _described_task(value: Mapping[str, Any], kind: type[Task]) -> Task:
    """The package's task with exactly these fields, else one of ``kind``."""
    exact = [task for task in TASKS if {entry.name for entry in fields(task)} == set(value)]
    return built(value, "task", exact[0] if exact and kind not in exact else kind)


def read_observe(
    sensing: str | None, observe: Any, task: Task, *, by_hands: bool = False
) -> tuple[Entry, ...]:
    """The blocks that ``sensing`` and the task stand for, if it is given, else ``observe``.

    ``by_hands``: where these carry out the actions, ``sensing`` brings what they feel too.

    Where a name is that of one of the task's own blocks, the block itself takes its place, and so
    it does for that block of a task with other numbers; a block that is one of `BLOCKS` becomes its
    name.
    """
    own = {block.name: block for block in task.blocks}
    if own and isinstance(observe, Sequence) and not isinstance(observe, str):
        observe = tuple(_of_task(entry, own) for entry in observe)
    if sensing is not None:
        senses = tuple(block for block in task.blocks if block.is_sense)
        observe = _sensed(sensing, observe, senses, by_hands)
    return tuple(_by_name(entry, own) for entry in find_blocks(observe))


def _by_name(entry: Entry, own: Mapping[str, Block]) -> Any:
    """The name of one of `BLOCKS`, or in that sensor, unless it is that of one of the ``own``."""
    if isinstance(entry, Sensor):
        return replace(entry, block=_by_name(entry.block, own))
    if isinstance(entry, Block) and entry.name not in own and entry == BLOCKS.get(entry.name):
        return entry.name
    return entry


def _sensed(sensing: Any, observe: Any, own: tuple[Block, ...], by_hands: bool) -> tuple[Any, ...]:
    """The blocks that the word ``sensing`` stands for, with the task's ``own`` senses."""
    if not isinstance(sensing, str) or sensing not in SENSING:
        raise UnknownName("sensing", sensing, SENSING)
    sets = (
        DEFAULT_BLOCKS,
        *(sensed(w, by_hands=hands) for w in SENSING for hands in (False, True)),
    )
    if observe not in (*sets, *((*names, *own) for names in sets)):  # else nobody chose it by hand
        _check_one_sight({"sensing": sensing, "observe": observe})
    return (*sensed(sensing, by_hands=by_hands), *own)


def _check_one_sight(given: Mapping[str, Any]) -> None:
    if given.get("sensing") is not None and "observe" in given:
        raise InvalidInput(
            f"sensing must come without observe, got sensing={given['sensing']!r} beside "
            f"observe={given['observe']!r}; give one of them"
        )


def _of_task(entry: Any, own: Mapping[str, Block]) -> Any:
    """The task's block of that name, or in that sensor; anything else as it is.

    A block of that name that reads as the task's does was that of a task before it, such as one
    with another preview: its bounds are kept, the rest is as the task has it.
    """
    if isinstance(entry, str):
        return own.get(entry, entry)
    if isinstance(entry, Block) and entry.name in own and entry.read is own[entry.name].read:
        return replace(own[entry.name], low=entry.low, high=entry.high)
    if isinstance(entry, Sensor):
        return replace(entry, block=_of_task(entry.block, own))
    if isinstance(entry, Mapping) and isinstance(entry.get("block"), str):  # as JSON has a sensor
        return {**entry, "block": _of_task(entry["block"], own)}
    return entry


def read_partner(value: Any) -> Partner | None:
    """The partner of that name, of a policy's file or a policy; else it has to be one, or None."""
    if value is None or (isinstance(value, Partner) and not isinstance(value, type)):
        return value
    if isinstance(value, str | os.PathLike) or (callable(value) and not isinstance(value, type)):
        return named_partner(value)
    raise InvalidInput(
        f"partner must be a name or have a method player(config, num_worlds, agents), or be a "
        f"policy or its file, got {value!r}; see coopenv.agents.partners"
    )


def built(value: Any, name: str, kind: type) -> Any:
    """Build ``kind`` from a mapping, the form in which JSON brings a dataclass back."""
    if not isinstance(value, Mapping):
        if not isinstance(value, kind):
            raise InvalidInput(
                f"{name} must be a {kind.__name__}, got {value!r}; pass {kind.__name__}(...)"
            )
        return value
    known = [entry.name for entry in fields(kind)]
    for key in value:
        if key not in known:
            raise UnknownName(f"keyword of {name}", key, known)
    if kind is Scene:
        boxes = value.get("obstacles", ())
        if isinstance(boxes, Sequence) and not isinstance(boxes, str):  # else Scene says so
            boxes = tuple(built(box, "scene.obstacles", Box) for box in boxes)
        value = {**value, "obstacles": boxes}
    return kind(**value)


def one_or_more(value: Any, name: str, kind: type) -> Any:
    """One of ``kind``, or a sequence of them as a tuple."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not value:
            raise InvalidInput(f"{name} must not be empty, got {value!r}; give one, or one a world")
        return tuple(built(entry, name, kind) for entry in value)
    return built(value, name, kind)


def read_flag(value: Any, name: str) -> bool:
    """``value`` as a bool, or raise `InvalidInput` unless it is one."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{name} must be True or False, got {value!r}; give one of them")
    return bool(value)


def read_limit(value: Any, name: str, num_agents: int) -> float | tuple[float, ...]:
    """What an action of 1 stands for: one positive number, or one an agent."""
    limits = stated_array(value, name)
    out = (limits <= 0) | (limits > LARGEST)
    if limits.shape not in ((), (num_agents,)) or out.any():
        raise InvalidInput(
            f"{name} must be positive, one number or one for each of {num_agents} agents, at most "
            f"{LARGEST:g}, got {value!r}; a torque-free agent is action='force'"
        )
    return tuple(limits.tolist()) if limits.ndim else limits.item()


def read_agents(value: Any, name: str, num_agents: int) -> tuple[int, ...] | None:
    """Numbers of agents, each once; None where none are given."""
    if value is None:
        return None
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise InvalidInput(
            f"{name} must be a sequence of agents' numbers, got {value!r}; pass for example (0,)"
        )
    agents = tuple(whole(agent, name, at_least=0) for agent in value)
    if len(set(agents)) < len(agents) or max(agents, default=0) >= num_agents:
        raise InvalidInput(
            f"{name} must name agents 0 to {num_agents - 1}, each once, got {agents}; "
            "drop what is not there"
        )
    return agents
