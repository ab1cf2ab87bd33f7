"""Training behind an entry, against the budget of a suite, in control steps."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any, NamedTuple

from coopenv.arrays import whole
from coopenv.errors import InvalidInput

UNTOLD = "not told"


class Trained(NamedTuple):
    """How much an entry was trained before it was entered."""

    steps: int
    """Control steps of a training, over all worlds; of several policies that act together, and of
    what came before a training that went on from it, their sum."""
    seeds: int = 1
    """Trainings out of which the best was entered, itself among them; each counts."""

    @property
    def total(self) -> int:
        """Control steps that count against the budget."""
        return self.steps * self.seeds

    def __str__(self) -> str:
        return f"{self.steps:,}" + (f" × {self.seeds}" if self.seeds > 1 else "")


def told(
    given: str, *, steps: int | None, seeds: int | None, known: int | None = None
) -> Trained | None:
    """What is said of the training behind an entry; ``None`` where nothing is.

    Parameters
    ----------
    given
        What is entered, for the errors.
    steps, seeds
        As of `Trained`, where somebody says them.
    known
        Control steps that it records itself, if it does.

    Raises
    ------
    InvalidInput
        If a number breaks its rule, less is said than is known, or seeds without steps.
    """
    steps = None if steps is None else whole(steps, "trained", at_least=0)
    seeds = None if seeds is None else whole(seeds, "seeds", at_least=1)
    if steps is not None and known is not None and steps < known:
        raise InvalidInput(
            f"trained must be at least the {known:,} control steps that {given!r} records, got "
            f"{steps:,}; leave it out, or count what came before as well"
        )
    done = known if steps is None else steps
    if done is None and seeds is not None:
        raise InvalidInput(
            f"trained must be told beside seeds, got nothing for {given!r}, which does not record "
            "it; give the control steps of one training (--trained)"
        )
    return None if done is None else Trained(done, 1 if seeds is None else seeds)


def recorded(training: Mapping[str, Any]) -> int | None:
    """Control steps of a training that a file records, of ``coopenv train`` in whole rollouts.

    The most that it may have taken where it was to end at a rate of success. ``None`` where the
    record has no steps.
    """
    steps, worlds, rollout = (
        value if type(value := training.get(name)) is int and value > 0 else None
        for name in ("steps", "num_worlds", "rollout")
    )
    if steps is None or worlds is None or rollout is None:
        return steps
    return ceil(steps / (worlds * rollout)) * worlds * rollout


def said(every: Sequence[Trained | None]) -> str:
    """The trainings of an entry in words: one number, the least and the most, or that one lacks."""
    known = sorted({one for one in every if one is not None})
    if not known or None in every:
        return UNTOLD
    return f"{known[0]}" if len(known) == 1 else f"{known[0]} to {known[-1]}"


def exceeds(every: Sequence[Trained | None], budget: int) -> bool:
    """Whether a training that is told took more control steps than a suite allows."""
    return any(one is not None and one.total > budget for one in every)
