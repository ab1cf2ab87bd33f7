"""Checkpoints of a training run: the model as it was between two updates, with its progress."""

import json
import zipfile
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written

from ..curves import save_rows
from .progress import Progress

try:
    from stable_baselines3.common.base_class import BaseAlgorithm
except ImportError as error:
    raise MissingExtra("coopenv.agents.train", "train") from error

POLICY, CHECKPOINT = "policy.zip", "checkpoint.zip"  # in a run's folder: finished, under way
RUN, PROGRESS = "coopenv.json", "coopenv_progress.json"  # in the file, beside SB3's own entries


@dataclass(frozen=True, kw_only=True)
class Checkpoint:
    """A saved model, what run it is of and how far that run has come.

    A finished run's ``policy.zip`` is one too, from which the run goes on with more steps.
    """

    path: Path
    identity: dict[str, Any]
    """What two runs must have in common for one to go on from the other."""
    progress: Progress

    @classmethod
    def read(cls, path: Path) -> Self:
        """What `save` wrote, without the model.

        Raises
        ------
        InvalidInput
            If the file is torn, or not of a run.
        """
        try:
            with zipfile.ZipFile(path) as archive:
                run, progress = (json.loads(archive.read(name)) for name in (RUN, PROGRESS))
            return cls(path=path, identity=run["identity"], progress=Progress(**progress))
        except (zipfile.BadZipFile, KeyError, TypeError, ValueError) as error:
            raise InvalidInput(
                f"out must hold no file of another kind of that name, got {path}, which does not "
                "say what run it is of; choose another out, or start over with fresh=True (--fresh)"
            ) from error

    def check(self, identity: Mapping[str, Any]) -> None:
        """Raise `InvalidInput` unless it is of the run with this ``identity``."""
        names = differences(self.identity, identity)
        if names:
            raise InvalidInput(
                f"out must hold no other run, got {self.path}, which differs in "
                f"{', '.join(names)}; choose another out, or start over with fresh=True (--fresh)"
            )


def save(path: Path, model: BaseAlgorithm, identity: Mapping[str, Any], progress: Progress) -> None:
    """Write the model with its run and progress into one file, whole or not at all."""
    with written(path) as part:
        with part.open("wb") as file:
            model.save(file)
        with zipfile.ZipFile(part, "a", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(RUN, json.dumps({"identity": identity}, indent=2))
            archive.writestr(PROGRESS, json.dumps(asdict(progress)))


class Keeper:
    """Keeps the model as it was before the rollout under way, and writes it now and then.

    An update that is broken off leaves some parameters changed and others not, so an interrupted
    run goes back to where its last update ended.

    Parameters
    ----------
    out
        Folder of the run, for ``checkpoint.zip`` and ``curves.csv``.
    identity
        Of the run.
    progress
        Of the run, as it grows.
    every
        Rollouts between two checkpoints.
    """

    def __init__(self, out: Path, identity: Mapping[str, Any], progress: Progress, *, every: int):
        self._out, self._identity, self._progress, self._every = out, identity, progress, every
        self._rollouts = 0
        self._kept: tuple[dict[str, Any], dict[str, Any], Progress] | None = None

    def begin_rollout(self, model: BaseAlgorithm) -> None:
        """Keep the model; write it if it is time for a checkpoint."""
        counters = ("num_timesteps", "ep_info_buffer", "ep_success_buffer")
        self._kept = (
            deepcopy(dict(model.get_parameters())),
            {name: deepcopy(getattr(model, name)) for name in counters},
            self._progress.copy(),
        )
        if self._rollouts and self._rollouts % self._every == 0:
            self._write(model, self._kept[2])
        self._rollouts += 1

    def write_kept(self, model: BaseAlgorithm) -> int:
        """Take the model back to the last update that ended, and write it; its control steps.

        Before the first update there is nothing to write.
        """
        if self._kept is None:
            return self._progress.steps
        parameters, counters, progress = self._kept
        if progress.steps:
            model.set_parameters(parameters)
            for name, value in counters.items():
                setattr(model, name, value)
            self._write(model, progress)
        return progress.steps

    def _write(self, model: BaseAlgorithm, progress: Progress) -> None:
        save(self._out / CHECKPOINT, model, self._identity, progress)
        save_rows(progress.rows, self._out / "curves.csv")


def differences(one: Any, other: Any, path: str = "") -> list[str]:
    """Dotted names of the parts in which two JSON values differ."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return [
            found
            for name in dict.fromkeys((*one, *other))
            for found in differences(one.get(name), other.get(name), f"{path}.{name}".lstrip("."))
        ]
    return [] if one == other else [path]
