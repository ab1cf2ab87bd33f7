"""What an option that is not known was meant to be."""

from collections.abc import Mapping, Sequence
from dataclasses import fields

from coopenv.cli.options.files import options, parts
from coopenv.errors import likely
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene


def meant(arguments: Sequence[str], commands: Mapping[str, type], program: str) -> str | None:
    """One line about the first option that is not known; None where all are."""
    if not arguments or arguments[0] not in commands:
        return None
    kind, name = commands[arguments[0]], arguments[0]
    for below, part in parts(kind).items():
        if arguments[1:2] == [below]:
            kind, name = part, f"{name} {below}"
    known = set(options(kind)) | {"help"}
    for given in arguments[1:]:
        option = given.partition("=")[0]
        word = option.removeprefix("--").removeprefix("no-").replace("-", "_")
        if not option.startswith("--") or word in known:
            continue
        place = _place(word)
        near = f"--{place}" if place and place.split()[0] in known else likely(word, known)
        rule = f"{program}: option must be one of {program} {name} --help, got {option}"
        if near is None:
            return f"{rule}; look there"
        near = near if near.startswith("--") else f"--{near.replace('_', '-')}"
        return f"{rule}; did you mean {near}?"
    return None


def _place(name: str) -> str | None:
    """How to write a number of body or scene as an option: ``body mass=...``."""
    group, dot, entry = name.partition(".")
    if dot:
        return f"{group} {entry}=..."
    for group, kind in (("body", Body), ("scene", Scene)):
        if name in {entry.name for entry in fields(kind)}:
            return f"{group} {name}=..."
    return None
