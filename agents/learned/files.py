"""Files of learned policies: SB3's archive, and in it blueprint, normalisation and notes."""

import io
import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written

try:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.save_util import json_to_data
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error

from ..trained.archive import (
    NOTES,
    PLAIN,
    existing,
    first_line,
    notes_in,
    object_in,
    opened,
)
from ..trained.form import read_form
from .algorithms import algorithm_of, find_algorithm, missing_contrib, name_of
from .blueprint import blueprint_of, build, check_format
from .exchange import model_of
from .finite import require_finite
from .normalization import Normalization, trained_normalized
from .weights import put_weights, read_weights

_ALGORITHM, _NORMALIZED = "algorithm", "normalized"  # keys of the notes that are ours
_STATISTICS = "normalization.npz"  # member: of the observations
_BLUEPRINT = "coopenv_model.json"  # member: how the model is built
_TRACES = "_last_original_obs"  # attribute that shows a normalisation; see normalization.py


class Saved(NamedTuple):
    """What a file holds."""

    model: BaseAlgorithm
    notes: dict[str, Any]  # of others
    normalization: Normalization | None
    is_normalized: bool | None  # as the file says; None if it does not
    traces: bool  # whether a normalisation would have left traces in it


def save_model(
    model: BaseAlgorithm,
    path: str | os.PathLike,
    *,
    notes: Mapping[str, Any] | None = None,
    normalization: Normalization | None = None,
    members: Mapping[str, str] | None = None,
) -> None:
    """``model.save`` under a temporary name that is then renamed, with what SB3 leaves out.

    Parameters
    ----------
    notes
        Of others, as JSON can hold it, into the member `NOTES`.
    normalization
        Of the observations that the model was trained on.
    members
        Further members of the archive, by name.
    """
    own = {_ALGORITHM: name_of(type(model)), _NORMALIZED: normalization is not None}
    entries = {**(notes or {}), **own}
    with written(path) as part:
        with part.open("wb") as file:
            model.save(file)
        with zipfile.ZipFile(part, "a", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(NOTES, json.dumps(entries, indent=2) + "\n")
            archive.writestr(_BLUEPRINT, json.dumps(blueprint_of(model)) + "\n")
            if normalization is not None:
                archive.writestr(_STATISTICS, normalization.to_bytes())
            for name, text in (members or {}).items():
                archive.writestr(name, text)


def load_model(
    path: str | os.PathLike,
    algorithm: type[BaseAlgorithm] | None = None,
    *,
    trust: bool = False,
) -> Saved:
    """Read a file that `save_model` wrote, or in plain numbers; with ``trust`` any of SB3 itself.

    Parameters
    ----------
    algorithm
        That trained it; ``None``: the one that the file says.
    trust
        Whether the pickles in it may be read, which runs whatever they say. Without it the model
        is built from the file's blueprint, and of the rest only numbers and text are read.

    Raises
    ------
    InvalidInput
        If it is no policy, is broken, has weights that are not finite, needs trust, or needs a
        class that cannot be found.
    MissingExtra
        If sb3-contrib trained it and is not installed.
    """
    file = existing(Path(path))
    with opened(file) as archive:
        notes = notes_in(archive, file)
        if PLAIN in archive.namelist():
            return _from_plain(file, algorithm)
        try:
            entries = object_in(archive, "data", file)
            if trust:
                kind = algorithm or _algorithm(notes, entries)
                model = kind.load(os.fspath(file), device="cpu")
            else:
                model = _built(archive, notes, algorithm, file)
            statistics = (
                Normalization.from_bytes(archive.read(_STATISTICS))
                if notes.get(_NORMALIZED)
                else None
            )
        except (InvalidInput, MissingExtra):
            raise
        except ImportError as error:
            if missing_contrib(error):
                raise MissingExtra("a policy of sb3-contrib", "contrib") from error
            raise InvalidInput(
                f"policy must be made of classes that can be imported, got {str(file)!r} "
                f"({error}); put their module on the path"
            ) from error
        except Exception as error:  # what is unpickled and filled in can raise anything
            raise _not_whole(file, error) from error
    require_finite(model, f"of {str(file)!r}")
    return Saved(
        model=model,
        notes={key: note for key, note in notes.items() if key not in (_ALGORITHM, _NORMALIZED)},
        normalization=statistics,
        is_normalized=notes.get(_NORMALIZED),
        traces=_TRACES in entries,
    )


def _from_plain(file: Path, algorithm: type[BaseAlgorithm] | None) -> Saved:
    """What a file in plain numbers holds; its model's optimiser is new."""
    form = read_form(file)
    try:
        model = model_of(form, algorithm, str(file))
    except (InvalidInput, MissingExtra):
        raise
    except Exception as error:  # what is filled in can raise anything
        raise _not_whole(file, error) from error
    if form.normalization is not None:  # as of `_built`
        setattr(model, _TRACES, np.zeros(model.observation_space.shape or ()))
    return Saved(
        model=model,
        notes=dict(form.notes),
        normalization=form.normalization,
        is_normalized=form.normalization is not None,
        traces=False,
    )


def _not_whole(file: Path, error: Exception) -> InvalidInput:
    return InvalidInput(
        f"policy must be a whole file of the algorithm that wrote it, got {str(file)!r} "
        f"({type(error).__name__}: {first_line(error)}); copy it again, or name another algorithm="
    )


def copy_of(model: BaseAlgorithm) -> BaseAlgorithm:
    """The model as it is now, without its environment, as SB3's own ``save`` and ``load`` make it.

    A deep copy will not do: torch makes none of what a step of the training left behind.
    """
    buffer = io.BytesIO()
    model.save(buffer)
    buffer.seek(0)
    unfilled = {"buffer_size": 1} if hasattr(model, "buffer_size") else None
    return type(model).load(buffer, device="cpu", custom_objects=unfilled)


def _built(
    archive: zipfile.ZipFile,
    notes: Mapping[str, Any],
    algorithm: type[BaseAlgorithm] | None,
    file: Path,
) -> BaseAlgorithm:
    """The model as its blueprint says, with the weights of the archive; nothing is unpickled."""
    blueprint = _plain_blueprint(archive, notes, file)
    kind = algorithm or find_algorithm(str(notes.get(_ALGORITHM)))
    weights = read_weights(archive, str(file))
    model = build(blueprint, kind, weights.numbers())
    put_weights(model, weights)
    if model.use_sde:
        model.policy.reset_noise()
    if notes.get(_NORMALIZED):  # so that it is refused if somebody takes the model out alone
        setattr(model, _TRACES, np.zeros(model.observation_space.shape or ()))
    return model


def _plain_blueprint(
    archive: zipfile.ZipFile, notes: Mapping[str, Any], file: Path
) -> Mapping[str, Any]:
    """The blueprint in an archive; raises `InvalidInput` where there is none."""
    if _BLUEPRINT in archive.namelist():
        blueprint = check_format(object_in(archive, _BLUEPRINT, file), str(file))
        if "needs_trust" not in blueprint:
            return blueprint
        why = f"which is made with {blueprint['needs_trust']!s:.160}"
    else:
        writer = "an older coopenv" if _ALGORITHM in notes else "Stable-Baselines3 itself"
        why = f"which {writer} wrote"
    raise InvalidInput(
        f"policy must say in plain values how it is built unless you trust the file, got "
        f"{str(file)!r}, {why}: it says so in pickles, and reading them runs whatever they hold; "
        "if you know where it is from, load it with trust=True (--trust), and save it with "
        "SB3Policy.save"
    )


def _algorithm(notes: dict[str, Any], entries: dict[str, Any]) -> type[BaseAlgorithm]:
    if _ALGORITHM in notes:
        return find_algorithm(str(notes[_ALGORITHM]))
    kept = json.dumps({"policy_class": entries["policy_class"]})
    return algorithm_of(json_to_data(kept)["policy_class"], entries)


def saved_normalization(saved: Saved, path: str | os.PathLike) -> Normalization | bool:
    """The statistics that go with a file, or False where it needs none.

    Raises
    ------
    InvalidInput
        If it needs some that it does not hold, or does not say whether it does.
    """
    if saved.is_normalized is not None:
        return saved.normalization or False
    needed = trained_normalized(saved.model) if saved.traces else None
    if needed is False:
        return False
    beside = sorted(Path(path).parent.glob("*vec*normalize*.pkl"))
    hint = f", {str(beside[0])!r} for example," if beside else ""
    raise InvalidInput(
        f"normalize must be given for a policy that {'was' if needed else 'may have been'} "
        f"trained behind a VecNormalize, got none for {os.fspath(path)!r}; in Python, "
        "SB3Policy.load(path, normalize=..., trust=True) takes the file that VecNormalize.save "
        f"wrote{hint} or False if it left observations as they are, and .save writes a policy "
        "that the command line takes too"
    )
