"""Damage to files: cuts, flipped bits, strange letters, values of another type, missing members."""

import io
import json
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

STRANGE = (
    *(b"\x00", b"\r", b"\r\n\n", b'"', b"'", b"\xef\xbb\xbf", b"\xff\xfe", b"\xed\xa0\x80"),
    *(b"nan", b"-inf", b"1e999", b"-0", b"99999999999999999999", b"0x1F", b"1_000", b"\xd9\xa3"),
    *(b",", b";", b"\t", b"=", b"#", b"[", b"{", b"null", b"true", b"a" * 5000, b"[" * 3000),
)
ODD: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1.5, 10**30, 1e308, -1e-320, float("nan"), float("inf")),
    *("", "x", "a" * 3000, "\x00", "../../etc", "os:system", "module:id", "\ud800"),
    *([], {}, [[]], [None], {"": 0}, {"kind": "x"}, [1, "a", None]),
)


def damaged(content: bytes, rng: np.random.Generator, suffix: str) -> bytes:
    """A file's content with one to three faults, some of which only its format can have."""
    for _ in range(rng.integers(1, 4)):
        ways: list[Callable[[bytes, np.random.Generator], bytes]] = [*_WAYS]
        if suffix in (".zip", ".npz"):
            ways += 3 * [_other_archive]
        elif suffix == ".json":
            ways += 8 * [_other_json]
        elif suffix in (".csv", ".toml"):
            ways += 4 * [_other_lines]
        content = ways[rng.integers(len(ways))](content, rng)
    return content


def _cut(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: _place(content, rng)]


def _without_start(content: bytes, rng: np.random.Generator) -> bytes:
    return content[_place(content, rng) :]


def _flipped(content: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.integers(1, 9) if changed else 0):
        changed[_place(content, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _strange(content: bytes, rng: np.random.Generator) -> bytes:
    start = _place(content, rng)
    end = min(len(content), start + int(rng.integers(4)))
    return content[:start] + STRANGE[rng.integers(len(STRANGE))] + content[end:]


def _without_block(content: bytes, rng: np.random.Generator) -> bytes:
    start = _place(content, rng)
    return content[:start] + content[start + int(rng.integers(1, 4096)) :]


def _blank_block(content: bytes, rng: np.random.Generator) -> bytes:
    """As after a crash of the machine: the length is right, a block was never written."""
    start, length = _place(content, rng), int(rng.integers(1, 4096))
    return (content[:start] + bytes(length) + content[start + length :])[: len(content)]


def _doubled(content: bytes, rng: np.random.Generator) -> bytes:
    start = _place(content, rng)
    return content[: start + int(rng.integers(1, 4096))] + content[start:]


def _other(content: bytes, rng: np.random.Generator) -> bytes:
    """Nothing, zeros, or noise."""
    return (b"", bytes(len(content)), rng.bytes(min(len(content), 5000)))[rng.integers(3)]


_WAYS = (_cut, _without_start, _flipped, _strange, _without_block, _blank_block, _doubled, _other)


def _place(content: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(max(1, len(content))))


def _other_lines(content: bytes, rng: np.random.Generator) -> bytes:
    """Lines that are missing, doubled, swapped, or with a strange cell."""
    lines = content.splitlines(keepends=True) or [b""]
    i, j = (int(k) for k in rng.integers(len(lines), size=2))
    cells = lines[i].split(b",")
    cells[rng.integers(len(cells))] = STRANGE[rng.integers(len(STRANGE))]
    match int(rng.integers(4)):
        case 0:
            del lines[i]
        case 1:
            lines.insert(i, lines[j])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case _:
            lines[i] = b",".join(cells)
    return b"".join(lines)


def _other_json(content: bytes, rng: np.random.Generator) -> bytes:
    """A value somewhere in the document that is another, is missing, or has a neighbour."""
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):  # damaged already
        return _cut(content, rng)
    odd = ODD[rng.integers(len(ODD))]
    holder, key = _somewhere(document, rng)
    if holder is None:
        document = odd
    elif isinstance(holder, dict) and rng.random() < 0.2:
        del holder[key]
    elif isinstance(holder, dict) and rng.random() < 0.1:
        holder["unknown"] = odd
    else:
        holder[key] = odd
    return json.dumps(document, indent=2).encode() + b"\n"


def _somewhere(document: Any, rng: np.random.Generator) -> tuple[Any, Any]:
    """What holds a value, and where in it; None for the document itself."""
    holder, key, value = None, None, document
    while isinstance(value, dict | list) and value and (holder is None or rng.random() < 0.8):
        keys = [*value] if isinstance(value, dict) else [*range(len(value))]
        holder, key = value, keys[rng.integers(len(keys))]
        value = holder[key]
    return (holder, key) if rng.random() < 0.97 else (None, None)


def _other_archive(content: bytes, rng: np.random.Generator) -> bytes:
    """An archive whose sums are right, with a member damaged, missing or misnamed."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except Exception:  # damaged already, in one of a dozen ways
        return _flipped(content, rng)
    if not members:
        return content
    names = [*members]
    name, other = (names[k] for k in rng.integers(len(names), size=2))
    match int(rng.integers(6)):
        case 0:
            del members[name]
        case 1:
            members[name] = members[other]
        case 2:
            members[f"{name}x"] = members.pop(name)
        case 3:
            members[name] = _WAYS[rng.integers(len(_WAYS))](members[name], rng)
        case _:
            name = next((each for each in names[::-1] if _is_json(members[each])), name)
            members[name] = _other_json(members[name], rng)
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for each, value in members.items():
            archive.writestr(each, value)
    return written.getvalue()


def _is_json(content: bytes) -> bool:
    return content[:1] in (b"{", b"[")
