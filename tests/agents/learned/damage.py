"""Damage to files of JSON and archives, drawn at random from a seed: cuts, bits, kinds, members."""

import copy
import io
import json
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch

JUNK: tuple[Any, ...] = (
    *(None, True, 3, -1, 10**400, 1.5, float("nan"), float("inf"), 1e308),
    *("", "nan", "a", [], [3], [[1]], {}, {"a": 1}, {"dict": {}}, {"tuple": [1]}),
)


WEIGHTS = ("policy.pth", "optimizer.pth")  # ends of the names of members that torch wrote


def cut(whole: bytes, rng: np.random.Generator) -> bytes:
    """Its beginning alone."""
    return whole[: int(rng.integers(len(whole)))]


def flipped(whole: bytes, rng: np.random.Generator) -> bytes:
    """One bit, or a few bytes in a row, are others."""
    data = bytearray(whole)
    place = int(rng.integers(len(data)))
    if rng.random() < 0.5:
        data[place] ^= 1 << int(rng.integers(8))
    else:
        data[place : place + 8] = rng.bytes(8)
    return bytes(data)


def places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every container with one of its keys, all the way down."""
    keys = range(len(value)) if isinstance(value, list) else value
    for key in [*keys] if isinstance(value, dict | list) else []:
        yield value, key
        yield from places(value[key])


def of_other_kind(text: bytes, rng: np.random.Generator) -> bytes:
    """JSON in which one value is missing or of another kind."""
    value = json.loads(text)
    found = [*places(value)]
    container, key = found[int(rng.integers(len(found)))]
    if rng.random() < 0.2:
        del container[key]
    else:
        container[key] = JUNK[int(rng.integers(len(JUNK)))]
    return json.dumps(value).encode()


def of_other_weights(data: bytes, rng: np.random.Generator) -> bytes:
    """A file of torch in which one entry is missing, of another shape or of another kind."""
    value = torch.load(io.BytesIO(data), weights_only=True)
    found = [*places(value)]
    container, key = found[int(rng.integers(len(found)))]
    given = container[key]
    tensors = [torch.zeros(()), torch.zeros(3, 7), torch.zeros(2, dtype=torch.complex64)]
    if torch.is_tensor(given):
        tensors += [
            given.reshape(-1)[:0],
            given.reshape(-1),
            given.to(torch.int64),
            torch.full(given.shape, float("inf")),
        ]
        tensors += [given.to_sparse(), given[None]]
    others = [*tensors, *JUNK]
    if rng.random() < 0.2:
        del container[key]
    else:
        container[key] = others[int(rng.integers(len(others)))]
    made = io.BytesIO()
    torch.save(value, made)
    return made.getvalue()


def members_of(whole: bytes) -> dict[str, bytes]:
    """Name → content of an archive's members."""
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive_of(members: Mapping[str, bytes]) -> bytes:
    """An archive with valid checks of whatever the members hold."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return made.getvalue()


def damaged_archive(whole: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """What was done to an archive, and the archive."""
    members = members_of(whole)
    name = [*members][int(rng.integers(len(members)))]
    done = str(rng.choice(["cut", "flipped", "without", "cut inside", "flipped inside", "other"]))
    if done == "cut":
        return done, cut(whole, rng)
    if done == "flipped":
        return done, flipped(whole, rng)
    if done == "without":
        return f"{done} {name}", archive_of({key: members[key] for key in members if key != name})
    if done == "other":
        structured = [key for key in members if key.startswith("coopenv") or key.endswith(WEIGHTS)]
        name = str(rng.choice(structured))
        change = of_other_weights if name.endswith(".pth") else of_other_kind
    else:
        change = cut if done == "cut inside" else flipped
    return f"{done} {name}", archive_of({**members, name: change(members[name], rng)})


Damage = Callable[[bytes, np.random.Generator], tuple[str, bytes]]


def refused_or_whole(
    damage: Damage, whole: Path, target: Path, read: Callable[[Path], Any], *, times: int, seed: int
) -> dict[str, int]:
    """How often a damaged copy of ``whole`` was refused by an error of ours, and how often read.

    Whatever else is raised goes through, with the number of the copy and what was done to it.
    """
    from coopenv.errors import CoopenvError

    content = whole.read_bytes()
    counts = {"refused": 0, "read": 0}
    for number in range(times):
        done, data = damage(copy.copy(content), np.random.default_rng((seed, number)))
        target.write_bytes(data)
        try:
            read(target)
        except CoopenvError:
            counts["refused"] += 1
        except Exception as error:
            raise AssertionError(f"copy {number} of seed {seed}: {done}") from error
        else:
            counts["read"] += 1
    return counts
