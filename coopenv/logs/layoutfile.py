"""Layout files, TOML or JSON: read as fields, and checked for their size and form."""

import json
import os
from pathlib import Path
from typing import Any

from coopenv.errors import InvalidInput
from coopenv.files import reading, toml
from coopenv.logs.limits import shown

LARGEST = 1 << 20  # [bytes]
DEEPEST = 8  # lists and tables within one another
LONGEST = 1000  # [characters] of a text


def load_fields(path: str | os.PathLike) -> dict[str, Any]:
    """Fields of a layout by their names, as a ``.toml`` or ``.json`` file has them.

    Raises
    ------
    InvalidInput
        If it cannot be read, is no table of fields, or larger or more deeply nested than any needs.
    """
    path = Path(path)
    parse = {".json": json.loads, ".toml": toml.loads}.get(path.suffix.lower())
    if parse is None:
        raise InvalidInput(f"layout must be a .toml or .json file, got {str(path)!r}; rename it")
    with reading(path):
        if not path.is_file():
            raise InvalidInput(f"layout must be a file, got {str(path)!r}; check its name")
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise InvalidInput(
            f"{path} must be a layout of at most {LARGEST:,} bytes, got more; keep only its fields"
        )
    try:
        content = parse(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InvalidInput(
            f"layout must be a readable file, got {str(path)!r}: {shown(error, 200)}; repair it"
        ) from error
    if not isinstance(content, dict) or not isinstance(content.get("columns", {}), dict):
        raise InvalidInput(f"layout must be a table of fields, got {path}; see docs/recordings.md")
    _require_plain(content, path)
    return content


def _require_plain(value: Any, path: Path, depth: int = 0) -> None:
    """Raise where a value is nested too deeply, or a text is too long to be a name."""
    if depth > DEEPEST:
        raise InvalidInput(f"{path} must be nested at most {DEEPEST} deep, got more; repair it")
    if isinstance(value, str) and len(value) > LONGEST:
        raise InvalidInput(
            f"{path} must have texts of at most {LONGEST:,} characters, got {len(value):,}: "
            f"{shown(value)!r}; shorten it"
        )
    if isinstance(value, dict | list):
        parts = [*value, *value.values()] if isinstance(value, dict) else value
        for part in parts:
            _require_plain(part, path, depth + 1)
