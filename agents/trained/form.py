"""Plain form of a policy: arrays and JSON in one NPZ archive, read and written without pickles."""

import io
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput
from coopenv.files import written

from .archive import NOTES, PLAIN, existing, first_line, notes_in, object_in, opened
from .network import Network
from .normalization import Normalization
from .spaces import Spaces, plain_space, space_of, spaces_of

FORMAT = 1  # raised when a file of before would mean something else
SUFFIX = ".npz"
_NAMES = {"format", "algorithm", "spaces", "network", "blueprint"}
_SPACES = ("observation_space", "action_space")
_WEIGHTS, _STATISTICS = "weights/", "normalization.npz"
_ARRAY, _VERSION = ".npy", (1, 0)  # of NumPy's format


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Form:
    """What the file holds."""

    algorithm: str  # module:class that trained it
    spaces: Spaces
    observed: Any  # the space of an observation
    said: Mapping[str, Any]  # the network in plain values; see `Network.of`
    arrays: Mapping[str, npt.NDArray]  # all weights of its policy, by their names there
    network: Network
    normalization: Normalization | None
    blueprint: Mapping[str, Any]  # how the library builds its model
    notes: Mapping[str, Any]  # of others, as JSON can hold it

    @classmethod
    def of(
        cls,
        said: Mapping[str, Any],
        spaces: tuple[Any, Any],
        arrays: Mapping[str, npt.NDArray],
        *,
        algorithm: str,
        normalization: Normalization | None,
        blueprint: Mapping[str, Any],
        notes: Mapping[str, Any],
    ) -> "Form":
        """The form of a network that ``said`` describes between the ``spaces`` of a row.

        Raises
        ------
        Exception
            Of any kind, if parts do not go together.
        """
        network = Network.of(said, arrays)
        row = spaces_of(*spaces, algorithm)
        units = row.actions * (row.pushes or 1)
        if (network.features, network.units, network.chooses) != (
            row.features,
            units,
            bool(row.pushes),
        ):
            raise ValueError("its network does not go with its spaces")
        if normalization is not None and normalization.mean.shape != (row.features,):
            raise ValueError("its statistics are of other features")
        return cls(
            algorithm=algorithm,
            spaces=row,
            observed=spaces[0],
            said=said,
            arrays=arrays,
            network=network,
            normalization=normalization,
            blueprint=blueprint,
            notes=notes,
        )


def write_form(form: Form, path: str | os.PathLike) -> None:
    """Write the file, whole or not at all; the same form gives the same bytes.

    Raises
    ------
    InvalidInput
        If the name does not end in ``.npz``.
    """
    if Path(path).suffix != SUFFIX:
        raise InvalidInput(
            f"path must end in {SUFFIX}, got {os.fspath(path)!r}; a policy in plain numbers is an "
            "archive of arrays: rename it"
        )
    said = {
        "format": FORMAT,
        "algorithm": form.algorithm,
        "spaces": dict(
            zip(_SPACES, map(plain_space, (form.observed, form.spaces.action_space)), strict=True)
        ),
        "network": form.said,
        "blueprint": form.blueprint,
    }
    with written(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        _put(archive, NOTES, json.dumps(form.notes, indent=2).encode())
        _put(archive, PLAIN, json.dumps(said).encode())
        if form.normalization is not None:
            _put(archive, _STATISTICS, form.normalization.to_bytes())
        for name, array in form.arrays.items():
            data = io.BytesIO()
            np.lib.format.write_array(data, array, version=_VERSION, allow_pickle=False)
            _put(archive, f"{_WEIGHTS}{name}{_ARRAY}", data.getvalue())


def read_form(path: str | os.PathLike) -> Form:
    """Read what `write_form` wrote. Nothing in the file is run.

    Raises
    ------
    InvalidInput
        If it is no such file, is damaged, of another format or has weights that are not finite.
    """
    file = existing(Path(path))
    with opened(file) as archive:
        if PLAIN not in archive.namelist():
            raise InvalidInput(
                f"policy must be in plain numbers, got {str(file)!r}, which is a model of "
                "Stable-Baselines3; coopenv export writes it so"
            )
        notes, said = notes_in(archive, file), object_in(archive, PLAIN, file)
        if said.get("format") != FORMAT:
            raise InvalidInput(
                f"policy must be of format {FORMAT}, got {said.get('format')!r:.40} in "
                f"{str(file)!r}; read it with the coopenv that wrote it, or a newer one"
            )
        try:
            return _form(archive, said, notes)
        except Exception as error:  # what is filled in can raise anything
            raise InvalidInput(
                f"policy must be a whole file as coopenv export writes it, got {str(file)!r} "
                f"({type(error).__name__}: {first_line(error)}); copy it again"
            ) from error


def is_plain(path: str | os.PathLike) -> bool:
    """Whether it is the file of a policy in plain numbers."""
    try:
        with zipfile.ZipFile(path) as archive:
            return PLAIN in archive.namelist()
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
        return False


def _form(archive: zipfile.ZipFile, said: Mapping[str, Any], notes: Mapping[str, Any]) -> Form:
    if set(said) != _NAMES or not isinstance(said["blueprint"], dict):
        raise ValueError("it lacks or adds something")
    arrays = {}
    for member in archive.namelist():
        if member.startswith(_WEIGHTS):
            name = member.removeprefix(_WEIGHTS).removesuffix(_ARRAY)
            arrays[name] = _array(archive.read(member), name)
    kept = _STATISTICS in archive.namelist()
    return Form.of(
        said["network"],
        (space_of(said["spaces"][_SPACES[0]]), space_of(said["spaces"][_SPACES[1]])),
        arrays,
        algorithm=str(said["algorithm"]),
        normalization=Normalization.from_bytes(archive.read(_STATISTICS)) if kept else None,
        blueprint=said["blueprint"],
        notes=notes,
    )


def _array(data: bytes, name: str) -> npt.NDArray:
    """The array in a member, of no more memory than the member has."""
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != _VERSION:
        raise ValueError(f"{name!r:.60} is of another format")
    shape, by_column, dtype = np.lib.format.read_array_header_1_0(stream)
    rest = data[stream.tell() :]
    if by_column or dtype.kind not in "fiub" or len(rest) != prod(shape) * dtype.itemsize:
        raise ValueError(f"{name!r:.60} holds something else than its numbers")
    array = np.frombuffer(rest, dtype).reshape(shape)
    if not np.isfinite(array).all():
        raise ValueError(f"{name!r:.60} has numbers that are not finite")
    return array


def _put(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    """Add a member without the time of day."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, data)
