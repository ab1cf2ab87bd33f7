"""Record of a policy's training against the environment that it is to act in.

Sizes alone do not tell blocks of the same size, nor a policy of one agent beside a partner from one
that every agent runs.
"""

from collections.abc import Mapping
from typing import Any

from coopenv.config import ACTIONS, TransportConfig
from coopenv.config.hands import BY_HANDS
from coopenv.errors import InvalidInput
from coopenv.tasks import TASKS
from coopenv.transport import Transport

RECORD = "provenance"  # entry of the notes, as coopenv.agents.provenance writes it


def check_trained_on(notes: Mapping[str, Any], core: Transport, agents: int) -> None:
    """Raise `InvalidInput` if ``core`` shows other blocks, takes other actions or has another team.

    Parameters
    ----------
    notes
        Of the policy; without provenance nothing is checked.
    core
        Of the evaluation.
    agents
        How many of its learners share a row of the policy.
    """
    environment, training = (part_of(notes, name) for name in ("environment", "training"))
    observe = environment.get("observe")
    trained = [_name(entry) for entry in observe] if isinstance(observe, list) else []
    seen = list(core.observation.blocks)
    if trained and trained != seen:
        raise InvalidInput(
            f"obs must be made of the blocks that the policy was trained on, {' '.join(trained)}, "
            f"got {' '.join(seen)}; evaluate it with the observe= of its training "
            f"(--observe {' '.join(trained)}), or in the environment that its file records"
        )
    check_kind(environment, core.config.action)
    _check_world(environment, core.config)
    control = training.get("control", "shared")  # not known: no team is refused
    learners = len(core.learners)
    if control != "shared" and agents != learners:
        beside = " beside a partner" if environment.get("partner") is not None else ""
        team = "one agent" if control == "partner" else "whole team"
        raise InvalidInput(
            f"policy must drive the {team} that it was trained for{beside} "
            f"(control={control!r}), got an environment with {learners} learners; give it a "
            "partner= (--partner), or evaluate it in the environment that its file records"
        )


def check_kind(environment: Mapping[str, Any], action: str) -> None:
    """Raise `InvalidInput` if what moves hands would be taken for a wrench, or the other way round.

    Where sizes differ, they tell by themselves.

    Parameters
    ----------
    environment
        Part of a policy's record; one that says no action is not refused.
    action
        Kind of the actions that are to be carried out.
    """
    trained = environment.get("action")
    if trained in ACTIONS and trained != action and {trained, action} & set(BY_HANDS):
        raise InvalidInput(
            f"action must be {trained!r} for a policy that was trained with it, got {action!r}, "
            "whose numbers mean something else; leave action= (--action) as the policy's file "
            "records it, or train another policy"
        )


def _check_world(environment: Mapping[str, Any], config: TransportConfig) -> None:
    """Raise where a policy's numbers stand for other forces, or its goal for another task."""
    kind = environment.get("task")
    kind = kind.get("kind") if isinstance(kind, Mapping) else None
    ours = {f"coopenv.{each.__name__}" for each in TASKS}
    here = f"coopenv.{type(config.task).__name__}"
    if kind in ours and here in ours and kind != here:
        raise InvalidInput(
            f"task must be the {str(kind).rpartition('.')[2]} that the policy was trained in, got "
            f"{type(config.task).__name__}; evaluate it in the environment that its file records, "
            "or train another policy"
        )
    for name, unit in (("force_limit", "N"), ("torque_limit", "N·m")):
        trained, now = _limits(environment.get(name)), _limits(getattr(config, name))
        most = max(len(trained), len(now))
        if trained and _each(trained, most) != _each(now, most):
            raise InvalidInput(
                f"{name} must be the {_listed(trained)} {unit} that the policy's actions of 1 "
                f"stood for in its training, got {_listed(now)} {unit}; leave it as its file "
                "records it"
            )


def _limits(said: Any) -> tuple[float, ...]:
    """One for all agents, or one an agent; empty where it is no limit."""
    limits = tuple(said) if isinstance(said, list | tuple) else (said,)
    return limits if all(isinstance(each, int | float) for each in limits) else ()


def _each(limits: tuple[float, ...], agents: int) -> tuple[float, ...]:
    return limits * agents if len(limits) == 1 else limits


def _listed(limits: tuple[float, ...]) -> str:
    return " and ".join(f"{each:g}" for each in limits)


def part_of(notes: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """A part of the record; empty where there is none."""
    record = notes.get(RECORD)
    part = record.get(name) if isinstance(record, Mapping) else None
    return part if isinstance(part, Mapping) else {}


def _name(entry: Any) -> str:
    """The name of a block as `TransportConfig.to_json` writes it, of a sensor's too."""
    if isinstance(entry, Mapping):
        return _name(entry["block"]) if "block" in entry else str(entry.get("name"))
    return str(entry)
