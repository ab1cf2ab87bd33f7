"""Whether a file is whole, told by how its format ends."""

import csv
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path


def require_whole(path: Path) -> None:
    """Raise `AssertionError` if the file is half of one."""
    content = path.read_bytes()
    check = _CHECKS.get(path.suffix)
    try:
        is_whole = bool(content) and (check is None or check(content))
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        raise AssertionError(f"{path.name} is torn: {error}") from error
    if not is_whole:
        raise AssertionError(f"{path.name} is torn, {len(content)} bytes long")


def table_rows(content: bytes) -> list[dict[str, str]]:
    """Rows of a CSV table by the names of its columns."""
    return [*csv.DictReader(io.StringIO(content.decode(), newline=""))]


def _is_archive(content: bytes) -> bool:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return archive.testzip() is None and bool(archive.namelist())


def _is_json(content: bytes) -> bool:
    json.loads(content)
    return content.endswith(b"\n")


def _is_table(content: bytes) -> bool:
    rows = [*csv.reader(io.StringIO(content.decode(), newline=""))]
    return content.endswith(b"\n") and len({len(row) for row in rows}) == 1


_CHECKS: dict[str, Callable[[bytes], bool]] = {
    ".csv": _is_table,
    ".gif": lambda content: content.startswith(b"GIF8") and content.endswith(b";"),
    ".json": _is_json,
    ".npz": _is_archive,
    ".parquet": lambda content: content[:4] == content[-4:] == b"PAR1",
    ".pdf": lambda content: content.rstrip().endswith(b"%%EOF"),
    ".png": lambda content: content.endswith(b"IEND\xaeB`\x82"),
    ".zip": _is_archive,
}
