"""Files that run code when what is pickled in them is read: they leave a marker."""

import base64
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any

import cloudpickle
import torch


class Touch:
    """Leaves an empty file where it is unpickled."""

    def __init__(self, marker: Path):
        self.marker = marker

    def __reduce__(self) -> Any:
        return Path.touch, (self.marker,)


def with_members(source: Path, target: Path, members: dict[str, bytes | None]) -> Path:
    """A copy of an archive in which some members hold something else, or, with None, are not."""
    with zipfile.ZipFile(source) as archive:
        whole = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in {**whole, **members}.items():
            if data is not None:
                archive.writestr(name, data)
    return target


def in_data(source: Path, target: Path, marker: Path) -> Path:
    """A policy of which SB3's own entries run code."""
    with zipfile.ZipFile(source) as archive:
        entries = json.loads(archive.read("data"))
    pickled = base64.b64encode(cloudpickle.dumps(Touch(marker))).decode()
    entries["start_time"] = {":type:": "<class 'int'>", ":serialized:": pickled}
    return with_members(source, target, {"data": json.dumps(entries).encode()})


def in_weights(source: Path, target: Path, marker: Path, member: str = "policy.pth") -> Path:
    """A policy of which the weights run code."""
    torch.save(Touch(marker), target)
    return with_members(source, target, {member: target.read_bytes()})


def in_pickled_weights(source: Path, target: Path, marker: Path) -> Path:
    """A policy whose weights are a bare pickle."""
    return with_members(source, target, {"policy.pth": pickle.dumps(Touch(marker), protocol=2)})


def in_statistics(source: Path, target: Path, marker: Path) -> Path:
    """A policy whose normalisation is a pickle, as NumPy reads one if it may."""
    with zipfile.ZipFile(source) as archive:
        notes = {**json.loads(archive.read("coopenv.json")), "normalized": True}
    members: dict[str, bytes | None] = {
        "coopenv.json": json.dumps(notes).encode(),
        "normalization.npz": pickle.dumps(Touch(marker)),
    }
    return with_members(source, target, members)
