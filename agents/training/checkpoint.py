"""Checkpoints of a training run: the model as it was between two updates, with its progress."""

import json
import shlex
import zipfile
from collections import deque
from copy import deepcopy
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from typing_extensions import Self

from coopenv.errors import CoopenvError, InvalidInput, MissingExtra

from ..curves import save_rows
from ..learned import save_model
from ..learned.finite import require_finite
from ..learned.weights import put_weights, read_weights
from ..provenance import Provenance
from ..trained import NOTES, read_notes
from ..trained.archive import first_line, object_in, opened
from .progress import Progress

try:
    from stable_baselines3.common.base_class import BaseAlgorithm
except ImportError as error:
    raise MissingExtra("coopenv.agents.train", "train") from error

POLICY, CHECKPOINT = "policy.zip", "checkpoint.zip"  # in a run's folder: finished, under way
LOGGED = 100  # episodes over which Stable-Baselines3 logs means
PROGRESS = "coopenv_progress.json"  # in the file, beside the entries of Stable-Baselines3
REMEDY = "choose another out, or start over with fresh=True (--fresh)"


@dataclass(frozen=True, kw_only=True)
class Checkpoint:
    """A saved model, what run it is of and how far that run has come.

    A finished run's ``policy.zip`` is one too, from which the run goes on with more steps.
    """

    path: Path
    provenance: Provenance
    progress: Progress

    @classmethod
    def read(cls, path: Path) -> Self:
        """What `save` wrote, without the model.

        Raises
        ------
        InvalidInput
            If the file is torn or damaged, or not of a run.
        """
        try:
            notes = read_notes(path)
            with zipfile.ZipFile(path) as archive:
                progress = Progress.from_dict(json.loads(archive.read(PROGRESS)))
            provenance = Provenance.from_notes(notes)
            if provenance is None:
                raise ValueError(f"{NOTES} does not say where it comes from")
            provenance.identity()  # raises if its settings are none
        except CoopenvError as error:
            raise InvalidInput(
                f"out must hold whole files of a run, got {path}: {error}; {REMEDY}"
            ) from error
        except Exception as error:  # values of another kind can raise anything
            raise InvalidInput(
                f"out must hold no file of another kind of that name, got {path}, which does not "
                f"say what run it is of; {REMEDY}"
            ) from error
        return cls(path=path, provenance=provenance, progress=progress)

    def restore(self, model: BaseAlgorithm, *, rows: Fraction | int) -> None:
        """Bring a model of this run, as it is begun, to where the checkpoint was written.

        Numbers alone are read; what Stable-Baselines3 pickles beside them is what the run's
        settings say anyway.

        Parameters
        ----------
        model
            As the run's settings make it.
        rows
            Of the ``VecEnv`` a control step of a world, in the mean over worlds.

        Raises
        ------
        InvalidInput
            If the file is damaged, or of a model of another build.
        """
        try:
            with opened(self.path) as archive:
                object_in(archive, "data", self.path)
                put_weights(model, read_weights(archive, str(self.path)))
            require_finite(model, f"of {str(self.path)!r}")
        except InvalidInput as error:
            raise InvalidInput(f"{error}; or {REMEDY}") from error
        except Exception as error:  # weights of another build can raise anything
            raise InvalidInput(
                f"out must hold weights of this run, got {self.path} ({type(error).__name__}: "
                f"{first_line(error)}); {REMEDY}"
            ) from error
        model.num_timesteps = int(self.progress.steps * rows)
        ended = self.progress.ended()
        model.ep_info_buffer = deque(
            ({"r": each["reward"], "l": each["length"]} for each in ended), maxlen=LOGGED
        )
        model.ep_success_buffer = deque((each["success"] for each in ended), maxlen=LOGGED)

    def check(self, provenance: Provenance) -> None:
        """Raise `InvalidInput` unless it is of the run that ``provenance`` begins."""
        names = self.provenance.differences(provenance)
        if names:
            raise InvalidInput(
                f"out must hold no other run, got {self.path}, which differs in "
                f"{', '.join(names)}; {REMEDY}, or go on with that run by --config "
                f"{shlex.quote(str(self.path.parent / 'config.json'))}"
            )


def save(path: Path, model: BaseAlgorithm, provenance: Provenance, progress: Progress) -> None:
    """Write the model with its provenance and progress into one file, whole or not at all."""
    save_model(
        model,
        path,
        notes=provenance.to_notes(),
        members={PROGRESS: json.dumps(asdict(progress))},
    )


class Keeper:
    """Keeps the model as it was before the rollout under way, and writes it now and then.

    An update that is broken off leaves some parameters changed and others not, so an interrupted
    run goes back to where its last update ended.

    Parameters
    ----------
    out
        Folder of the run, for ``checkpoint.zip`` and ``curves.csv``.
    provenance
        Of the run.
    progress
        Of the run, as it grows.
    every
        Rollouts between two checkpoints.
    """

    def __init__(self, out: Path, provenance: Provenance, progress: Progress, *, every: int):
        self._out, self._provenance = out, provenance
        self._progress, self._every = progress, every
        self._rollouts = 0
        self._kept: tuple[dict[str, Any], dict[str, Any], Progress] | None = None

    def begin_rollout(self, model: BaseAlgorithm) -> None:
        """Keep the model; write it if it is time for a checkpoint.

        Raises
        ------
        InvalidInput
            If its parameters are not finite; what was kept stays.
        """
        require_finite(model, "of the policy")
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
        save(self._out / CHECKPOINT, model, self._provenance, progress)
        save_rows(progress.rows, self._out / "curves.csv")
