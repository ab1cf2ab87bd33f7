"""Record of the environment that a model was trained in: in its file, and against another one.

Sizes alone do not tell blocks of the same size, nor a policy of one agent beside a partner from one
that every agent runs.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.config import ACTIONS
from coopenv.config.hands import BY_HANDS
from coopenv.errors import InvalidInput
from coopenv.transport import Transport

RECORD = "provenance"  # entry of the notes, as coopenv.agents.provenance writes it
_SEEN = "_last_obs"  # attribute of a model: what it saw last in its environment, while it learned


@runtime_checkable
class Recorded(Protocol):
    """An environment that can say what it is, as `coopenv.agents.sb3.TransportVecEnv`."""

    def to_notes(self) -> dict[str, Any]:
        """As JSON can hold it."""
        ...


class Notes(NamedTuple):
    """What a policy's file is to say."""

    entries: dict[str, Any]
    missing: str  # why the environment of the training is not among them; empty if it is


def has_learned_in_its_environment(model: BaseAlgorithm) -> bool:
    """Whether the environment that a model has is the one in which it learned last.

    ``set_env`` and ``load`` make SB3 forget the last observation; ``learn`` keeps one. A model that
    was given another environment without ``force_reset`` looks as if it had learned there.
    """
    return model.get_env() is not None and getattr(model, _SEEN, None) is not None


def learned_so_far(model: BaseAlgorithm) -> tuple[int, int]:
    """Steps and updates of a model's training: another number once it has learned on."""
    return model.num_timesteps, getattr(model, "_n_updates", 0)


def notes_now(model: BaseAlgorithm, notes: Mapping[str, Any], *, learned_on: bool) -> Notes:
    """``notes``, with the record of the environment in which the model learned last.

    A record in ``notes`` says more, so it stays as long as nothing was learned elsewhere. What was
    learned in an environment that cannot be recorded, or that is gone, is under no record.

    Parameters
    ----------
    model, notes
        Whose they are.
    learned_on
        Whether the model has learned since the notes were written.
    """
    kept, rest = RECORD in notes, {name: notes[name] for name in notes if name != RECORD}
    venv = model.get_env()
    if kept and not learned_on:
        return Notes(dict(notes), "")
    if venv is None and not kept:
        return Notes(dict(notes), "")
    if model.num_timesteps and not has_learned_in_its_environment(model):
        return Notes(
            rest,
            "it was given another one since it learned (give SB3Policy notes=venv.to_notes() of "
            "the one that it learned in, or save it before set_env)",
        )
    inside = None if venv is None else venv.unwrapped
    if not isinstance(inside, Recorded):
        return Notes(rest, "it learned on in one that does not say what it is" if kept else "")
    try:
        live = inside.to_notes()
    except InvalidInput as error:
        return Notes(rest, str(error))
    same = kept and _identity(live) == _identity(notes)
    return Notes(dict(notes) if same else {**rest, **live}, "")


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


def _identity(notes: Mapping[str, Any]) -> tuple[Any, Any]:
    """Environment and control of a record; a damaged one is equal to none."""
    record = notes.get(RECORD)
    if not isinstance(record, Mapping):
        return None, None
    training = record.get("training")
    control = training.get("control") if isinstance(training, Mapping) else None
    return record.get("environment"), control
