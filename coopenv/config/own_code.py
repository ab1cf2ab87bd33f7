"""Functions and classes from outside this package, named in JSON as ``module:name`` with a hash.

The hash is of the source file, so that helpers and constants beside what is named count as well.
"""

import sys
from collections.abc import Collection
from dataclasses import is_dataclass
from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeAlias

from coopenv.errors import InvalidInput

Trust: TypeAlias = bool | Collection[str]
"""Whether JSON may name code that is not of this package: all, none, or that of these modules."""

_SCRIPTS = ("__main__", "__mp_main__")  # whatever script runs, and in processes it spawned


def written_name(thing: Any, part: str) -> dict[str, str]:
    """``name`` and ``sha256`` of a function or class; ``part`` is for the error.

    Raises
    ------
    InvalidInput
        If it could not be found again by its name.
    """
    module, name = getattr(thing, "__module__", None), getattr(thing, "__qualname__", None)
    found = _inside(sys.modules.get(module or ""), name or "")
    path = _source(module or "")
    if module in _SCRIPTS or found is not thing or path is None:
        remedy = (
            "save it, and give the name of its file in its place"
            if hasattr(thing, "save")
            else "define it at the top of a module of your own, a .py file that is imported: not "
            "in the script that runs, not in a function, not as a lambda"
        )
        raise InvalidInput(
            f"{part} must be something that a file can name, got {thing!r}; {remedy}"
        )
    return {"name": f"{module}:{name}", "sha256": read_hash(path)}


def read_name(name: str, digest: Any, part: str, trust: Trust) -> Any:
    """The function or class that `written_name` wrote; imported only where it is trusted.

    Raises
    ------
    InvalidInput
        If it is not trusted, not there, or its source file is not what it was.
    """
    module, _, inside = name.partition(":")
    if not is_trusted(module, trust):
        raise InvalidInput(
            f"{part} must be of coopenv unless you trust the text, got {name!r}, which loading "
            "would import and run; if you know where the text is from, pass "
            f"trust=({module!r},) to TransportConfig.from_json (--trust {module})"
        )
    path = _source(module)
    if path is None:
        raise InvalidInput(
            f"{part} must be code that is there, got {name!r}, but there is no source file of "
            f"{module!r}; put its folder on PYTHONPATH"
        )
    now = read_hash(path)
    if digest != now:
        raise InvalidInput(
            f"{part} must be the code that was written, but {path} has changed since: sha256 "
            f"{digest!r} then, {now!r} now; restore it, or put the new hash into the text if the "
            "change makes no difference (for a policy's file, name the environment with --env)"
        )
    found = _inside(_imported(module, part), inside)
    if found is None:
        raise InvalidInput(f"{part} must be in {path}, got {name!r}; mend the name in the text")
    return found


def is_trusted(module: str, trust: Trust) -> bool:
    """Whether a module may be imported because a text names it: it or what it is in is trusted."""
    if isinstance(trust, bool):
        return trust
    names = (trust,) if isinstance(trust, str) else trust
    return any(module == name or module.startswith(f"{name}.") for name in names)


def frozen(kind: Any, part: str) -> type:
    """``kind``, or raise `InvalidInput` unless it is a class of frozen dataclasses."""
    made = isinstance(kind, type) and is_dataclass(kind)
    if not made or not kind.__dataclass_params__.frozen:  # pyright: ignore[reportAttributeAccessIssue]
        raise InvalidInput(
            f"{part} must be a frozen dataclass to go through JSON, got {kind!r}; decorate it with "
            "@dataclass(frozen=True) and keep all that it depends on in its fields"
        )
    return kind


def read_hash(path: str | Path) -> str:
    """SHA-256 of a source file; how its lines end makes no difference."""
    return sha256(Path(path).read_bytes().replace(b"\r\n", b"\n")).hexdigest()


def _imported(module: str, part: str) -> Any:
    try:
        return import_module(module)
    except Exception as error:
        raise InvalidInput(
            f"{part} must be in a module that can be imported, got {module!r}: "
            f"{type(error).__name__}: {error}; mend it"
        ) from error


def _inside(module: Any, name: str) -> Any:
    for step in name.split("."):
        module = getattr(module, step, None)
    return module


def _source(module: str) -> Path | None:
    """The source file of a module, which need not be imported; ``None`` where there is none."""
    try:
        origin = getattr(sys.modules.get(module), "__file__", None)
        if origin is None:
            spec = find_spec(module)
            origin = spec.origin if spec is not None else None
    except (ImportError, ValueError, AttributeError):
        return None
    path = Path(origin or "")
    return path if path.suffix == ".py" and path.is_file() else None
