"""Files of learned policies: SB3's archive, and in it algorithm, normalisation and notes."""

import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written

try:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.save_util import json_to_data
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error

from .algorithms import algorithm_of, find_algorithm, missing_contrib, name_of
from .finite import require_finite
from .normalization import Normalization

NOTES = "coopenv.json"  # member of the archive: what SB3 does not write; others may add keys
_ALGORITHM, _NORMALIZED = "algorithm", "normalized"  # its keys that are ours
_STATISTICS = "normalization.npz"  # member: of the observations
_NEEDED = ("data", "policy.pth")  # members without which a file is no policy


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
) -> None:
    """``model.save`` under a temporary name that is then renamed, with what SB3 leaves out.

    Parameters
    ----------
    notes
        Of others, as JSON can hold it, into the member `NOTES`.
    normalization
        Of the observations that the model was trained on.
    """
    own = {_ALGORITHM: name_of(type(model)), _NORMALIZED: normalization is not None}
    entries = {**(notes or {}), **own}
    with written(path) as part:
        with part.open("wb") as file:
            model.save(file)
        with zipfile.ZipFile(part, "a") as archive:
            archive.writestr(NOTES, json.dumps(entries, indent=2) + "\n")
            if normalization is not None:
                archive.writestr(_STATISTICS, normalization.to_bytes())


def load_model(
    path: str | os.PathLike,
    algorithm: type[BaseAlgorithm] | None = None,
    *,
    venv: VecEnv | None = None,
) -> Saved:
    """Read a file that `save_model` or SB3 itself wrote. Only open files you trust.

    Parameters
    ----------
    algorithm
        That trained it; ``None``: the one that the file says.
    venv
        In which the model is to learn on.

    Raises
    ------
    InvalidInput
        If it is no policy, is broken, has weights that are not finite, or needs a class that cannot
        be found.
    MissingExtra
        If sb3-contrib trained it and is not installed.
    """
    file = _existing(Path(path))
    with _archive(file) as archive:
        notes = _notes(archive, file)
        try:
            entries = json.loads(archive.read("data"))
            kind = algorithm or _algorithm(notes, entries)
            statistics = (
                Normalization.from_bytes(archive.read(_STATISTICS))
                if notes.get(_NORMALIZED)
                else None
            )
            model = kind.load(os.fspath(file), env=venv, device="cpu")
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
            raise InvalidInput(
                f"policy must be a whole file of the algorithm that wrote it, got {str(file)!r} "
                f"({type(error).__name__}: {_first_line(error)}); copy it again"
                f"{_other_algorithm(venv)}"
            ) from error
    require_finite(model, f"of {str(file)!r}")
    return Saved(
        model=model,
        notes={key: note for key, note in notes.items() if key not in (_ALGORITHM, _NORMALIZED)},
        normalization=statistics,
        is_normalized=notes.get(_NORMALIZED),
        traces="_last_original_obs" in entries,
    )


def _other_algorithm(venv: VecEnv | None) -> str:
    """A second remedy for who reads a policy in Python; a run knows its algorithm."""
    return ", or name another algorithm=" if venv is None else ""


def read_notes(path: str | os.PathLike) -> dict[str, Any]:
    """The member `NOTES` of a policy's file; empty if SB3 itself wrote it.

    Raises
    ------
    InvalidInput
        If the file is no policy.
    """
    file = _existing(Path(path))
    with _archive(file) as archive:
        return _notes(archive, file)


def _existing(path: Path) -> Path:
    """The file itself; like SB3, with ``.zip`` added where it is not there without."""
    for file in (path, path.with_name(f"{path.name}.zip") if path.name else path):
        if file.is_file():
            return file
    what = "a folder" if path.is_dir() else "which is not there"
    inside = path / "policy.zip"
    remedy = f"give {str(inside)!r}" if inside.is_file() else "coopenv train writes such a file"
    raise InvalidInput(
        f"policy must be the file of a trained policy, got {str(path)!r}, {what}; {remedy}"
    )


def _archive(file: Path) -> zipfile.ZipFile:
    """The file opened, once all of it could be read and it holds a policy."""
    try:
        archive = zipfile.ZipFile(file)
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile) as error:
        raise _no_policy(file, _likely(file, error)) from error
    try:
        names = archive.namelist()
        missing = [name for name in _NEEDED if name not in names]
        if missing:
            raise _no_policy(file, f"an archive without {' and '.join(missing)}")
        try:
            broken = archive.testzip()
        except Exception as error:  # a damaged archive can raise anything
            raise _no_policy(file, f"which is damaged ({_first_line(error)})") from error
        if broken is not None:
            raise _no_policy(file, f"in which {broken} is damaged")
    except InvalidInput:
        archive.close()
        raise
    return archive


def _likely(file: Path, error: Exception) -> str:
    """What a file is that cannot be opened as an archive."""
    try:
        with file.open("rb") as opened:
            start = opened.read(2)
    except OSError:
        return f"which cannot be read ({error})"
    if not start:
        return "which is empty"
    return "an archive that was cut short" if start == b"PK" else "which is no archive"


def _no_policy(file: Path, what: str) -> InvalidInput:
    return InvalidInput(
        f"policy must be a file that SB3Policy.save or a model's save wrote, got {str(file)!r}, "
        f"{what}; copy it again or give another"
    )


def _notes(archive: zipfile.ZipFile, file: Path) -> dict[str, Any]:
    if NOTES not in archive.namelist():
        return {}
    try:
        notes = json.loads(archive.read(NOTES))
    except ValueError as error:
        raise _no_policy(file, f"in which {NOTES} is no JSON") from error
    if not isinstance(notes, dict):
        raise _no_policy(file, f"in which {NOTES} is no object")
    return notes


def _algorithm(notes: dict[str, Any], entries: dict[str, Any]) -> type[BaseAlgorithm]:
    if _ALGORITHM in notes:
        return find_algorithm(str(notes[_ALGORITHM]))
    kept = json.dumps({"policy_class": entries["policy_class"]})
    return algorithm_of(json_to_data(kept)["policy_class"], entries)


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [""])[0]
