"""What a policy's file records of its training, against the environment that it is to act in.

Sizes alone do not tell blocks of the same size, nor a policy of one agent beside a partner from one
that every agent runs.
"""

from collections.abc import Mapping
from typing import Any

from coopenv.errors import InvalidInput
from coopenv.transport import Transport

from .record import RECORD


def check_trained_on(notes: Mapping[str, Any], core: Transport, agents: int) -> None:
    """Raise `InvalidInput` if ``core`` shows other blocks or a team of another kind.

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
