"""Documents for programs: JSON with numbers as they are, and null for what is not finite."""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np


def plain(value: Any, *, path: Callable[[Path], str] = os.fspath) -> Any:
    """What JSON can hold of a value: null for NaN and infinity, lists for arrays, text for paths.

    Parameters
    ----------
    value
        Of mappings, sequences, arrays, dataclasses, named tuples, numbers and texts.
    path
        How a path is written.

    >>> plain({"share": np.array([0.1, np.nan])})
    {'share': [0.1, None]}
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if is_dataclass(value) and not isinstance(value, type):
        value = {each.name: getattr(value, each.name) for each in fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = value._asdict()  # pyright: ignore[reportAttributeAccessIssue]
    if isinstance(value, Mapping):
        return {str(name): plain(each, path=path) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each, path=path) for each in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return path(value) if isinstance(value, Path) else value


def document(value: Any) -> str:
    """A value as the text of a JSON document, in letters that every terminal and pipe can take."""
    return json.dumps(plain(value), indent=2, allow_nan=False)
