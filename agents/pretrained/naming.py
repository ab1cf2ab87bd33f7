"""Names of the policies that come with the package: ``pretrained:BeamDoorway/joint``."""

import os
from pathlib import Path

from coopenv.errors import InvalidInput, UnknownName

WORD = "pretrained"
CONTROLS = ("joint", "shared")  # one policy of the team, or the same one for every agent
_HERE = Path(__file__).parent
_ENV, _VERSION = "coopenv/", "-v0"  # around a task in a Gymnasium id


def shipped() -> tuple[str, ...]:
    """``BeamDoorway/joint`` and the others that are there."""
    return tuple(sorted(path.stem.replace("_", "/") for path in _HERE.glob("*.npz")))


def is_name(value: object) -> bool:
    """Whether something names policies of the package: ``pretrained``, or with a colon and more."""
    return isinstance(value, str) and value.partition(":")[0] == WORD


def expanded(name: str) -> tuple[str, ...]:
    """The single policies for which a name of a policy stands; any other name for itself.

    ``pretrained`` stands for all, ``pretrained:BeamDoorway`` for those of one task.

    Raises
    ------
    UnknownName
        If there is none of that name.
    """
    if not is_name(name):
        return (name,)
    wanted, known = _wanted(name), shipped()
    found = [each for each in known if wanted in ("", each, each.partition("/")[0])]
    if not found:
        raise UnknownName("pretrained policy", wanted, known)
    return tuple(f"{WORD}:{each}" for each in found)


def named(task: str, control: str | None = None) -> str:
    """The name of the policy of a task, an id or such a name; that of the team by default.

    Raises
    ------
    InvalidInput
        If no task is named, as by ``pretrained`` alone, which stands for all.
    """
    wanted = _wanted(task if is_name(task) else f"{WORD}:{task}")
    if not wanted.partition("/")[0]:
        raise InvalidInput(
            f"policy must be that of one task, got {task!r}; name one of {', '.join(shipped())}; "
            "coopenv.agents.pretrained.names() lists them"
        )
    whole = control is None and "/" in wanted
    return f"{WORD}:{wanted}" if whole else f"{WORD}:{wanted}/{control or CONTROLS[0]}"


def file_of(name: str | os.PathLike) -> Path:
    """The file behind the name of a policy, which may be the file itself.

    Raises
    ------
    UnknownName
        If no single policy of the package has that name.
    """
    text = os.fspath(name)
    if not is_name(text):
        return Path(text)
    wanted, known = _wanted(text), shipped()
    if wanted not in known:
        raise UnknownName("single pretrained policy", wanted or text, known)
    return _HERE / f"{wanted.replace('/', '_')}.npz"


def _wanted(name: str) -> str:
    """What stands behind the colon, without what an id has more than a task."""
    return name.partition(":")[2].removeprefix(_ENV).replace(_VERSION, "")
