"""Record of the environment in which a model learned last, and whether that is still known."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.errors import InvalidInput

from ..trained.record import RECORD

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


def _identity(notes: Mapping[str, Any]) -> tuple[Any, ...]:
    """Environment, control and teams of a record; a damaged one is equal to none."""
    record = notes.get(RECORD)
    if not isinstance(record, Mapping):
        return None, None, None
    training = record.get("training")
    known = training if isinstance(training, Mapping) else {}
    return record.get("environment"), known.get("control"), known.get("teams")
