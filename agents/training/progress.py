"""Progress of a training run: the episodes that ended lately, and the learning curves over them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import chain
from math import ceil
from typing import Any

import numpy as np
from typing_extensions import Self

from coopenv.errors import InvalidInput, MissingExtra

from ..curves import Row

try:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.callbacks import BaseCallback
except ImportError as error:
    raise MissingExtra("coopenv.agents.train", "train") from error

LARGEST = 1e300  # of a number in a curve, beyond which no picture is drawn

Episode = dict[str, float]
"""An episode that ended: ``success``, ``reward``, ``length`` and its means by name; without those
that are undefined in it."""


@dataclass(kw_only=True)
class Progress:
    """How far a run has come, and what its curves are drawn from."""

    steps: int = 0
    """Control steps done, over all worlds."""
    rows: list[Row] = field(default_factory=list)
    """The curves, one row an update."""
    window: list[list[Episode]] = field(default_factory=list)
    """Episodes that ended in each of the last rollouts, oldest first."""

    @classmethod
    def from_dict(cls, given: Any) -> Self:
        """What JSON brings back of one.

        Raises
        ------
        InvalidInput
            If an entry is missing, unknown or of another kind.
        """
        kinds = {"steps": _is_count, "rows": _are_curves, "window": _is_window}
        if not isinstance(given, dict) or set(given) != set(kinds):
            raise InvalidInput(
                f"progress must have {', '.join(kinds)}, got {given!r:.80}; the file is damaged: "
                "copy it again"
            )
        for name, is_right in kinds.items():
            if not is_right(given[name]):
                raise InvalidInput(
                    f"progress.{name} must be what a run wrote there, got {given[name]!r:.80}; "
                    "the file is damaged: copy it again"
                )
        return cls(**given)

    def copy(self) -> Self:
        """One that goes on by itself."""
        return replace(self, rows=[*self.rows], window=[*self.window])

    def ended(self) -> list[Episode]:
        """Episodes of the window of which all is known that every one has."""
        needed = {"success", "reward", "length"}
        return [episode for episode in chain(*self.window) if needed <= set(episode)]

    def add(self, ended: list[Episode], *, rollouts: int) -> None:
        """Let a rollout's episodes into the window, which holds that many rollouts."""
        self.window = [*self.window, ended][-rollouts:]


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _are_curves(value: Any) -> bool:
    """Whether it is a list of numbers by name, each with the steps at which it stands."""
    return _are_rows(value) and all("steps" in row for row in value)


def _are_rows(value: Any) -> bool:
    """Whether it is a list of numbers by name."""
    return isinstance(value, list) and all(
        isinstance(row, dict) and all(map(_is_number, row.values())) for row in value
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST


def _is_window(value: Any) -> bool:
    return isinstance(value, list) and all(map(_are_rows, value))


class Watch(BaseCallback):
    """Turns the episodes that ended lately into one row of the curves a rollout.

    Lately: in as many rollouts as an episode may last. In a shorter while those that end are
    mostly the short ones, that is, the successful. For the same reason a run that goes on shows the
    episodes of before until the new ones have had that long, then the first of each world, and from
    there on all.

    Parameters
    ----------
    progress
        Of the run, which this writes on.
    horizon, rollout
        Control steps of the longest episode, and between two updates.
    per_step
        Rows of the ``VecEnv`` a control step of a world, in the mean over worlds.
    begin
        Called with the model before each rollout, when the last update is done.
    report
        Called with the newest row after every rollout.
    """

    def __init__(
        self,
        progress: Progress,
        *,
        horizon: int,
        rollout: int,
        per_step: Fraction | int,
        begin: Callable[[BaseAlgorithm], None],
        report: Callable[[Row], None],
    ):
        super().__init__()
        self.progress, self._per_step = progress, per_step
        self._begin, self._report = begin, report
        self._rollouts = ceil(horizon / rollout)  # of the window
        self._early = self._rollouts if any(progress.window) else 0  # rollouts until they may tell
        self._ended: list[Episode] = []  # in this rollout
        self._first: dict[int, Episode] = {}  # by row of the VecEnv, while it is early

    def _on_rollout_start(self) -> None:
        self._begin(self.model)
        self._ended = []

    def _on_step(self) -> bool:
        infos = self.locals["infos"]  # where there is a cost, every step has one that tells it
        ended = {k: episode_of(info) for k, info in enumerate(infos) if "episode" in info}
        self._ended += ended.values()
        if self._early:
            self._first = {**ended, **self._first}
        return True

    def _on_rollout_end(self) -> None:
        progress = self.progress
        if self._early:
            self._early -= 1
            if not self._early:
                progress.window = [[*self._first.values()]]
        else:
            progress.add(self._ended, rollouts=self._rollouts)
        progress.steps = int(self.num_timesteps / Fraction(self._per_step))
        row: Row = {"steps": progress.steps, **episode_means([*chain(*progress.window)])}
        for name, value in row.items():
            self.logger.record(f"episode/{name}", value)
        progress.rows.append(row)
        self._report(row)


def episode_of(info: dict[str, Any]) -> Episode:
    """What the info of an ended episode says, in the names of the curves."""
    statistics = dict(info["episode"])
    del statistics["t"]
    named = {
        "success": info["is_success"],
        "reward": statistics.pop("r"),
        "length": statistics.pop("l"),
        **statistics,
    }
    return {name: float(value) for name, value in named.items() if not np.isnan(value)}


def episode_means(ended: Sequence[Episode]) -> Row:
    """Means over ended episodes, each over those in which it is defined; nothing without any."""
    if not ended:
        return {}
    names = dict.fromkeys(chain(*ended))
    means = {
        name: float(np.mean([episode[name] for episode in ended if name in episode]))
        for name in names
    }
    return {"episodes": len(ended), **means}
