"""Rosbag2 folders: `metadata.yaml` and the files that it names, checked before they are read."""

from pathlib import Path
from typing import Any

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import reading, require_file
from coopenv.logs.limits import Limits, legible, shown

METADATA = "metadata.yaml"
LARGEST = 1 << 20  # [bytes] of it
PIECE = 1 << 20  # [bytes] that are inflated at once
STORED = (".mcap", ".db3")  # suffixes of the files in it
TOLD = "rosbag2_bagfile_information"


def require_recording(path: Path) -> None:
    """Raise `InvalidInput` unless there is a file of that name, or a folder that is a rosbag2."""
    with reading(path):
        if not path.is_dir():
            require_file(path)
            return
        if (path / METADATA).is_file():
            if path.suffix.lower() == ".bag":
                raise InvalidInput(
                    f"{path} must not end in .bag, which ROS 1 files do, got a folder; rename it"
                )
            return
        inside = sorted(each.name for each in path.iterdir() if each.suffix.lower() in STORED)
    if inside:
        raise InvalidInput(
            f"{path} must have a {METADATA} like every rosbag2 folder, got none; name "
            f"{shown(legible(inside[0]))} in it, or run ros2 bag reindex"
        )
    raise InvalidInput(
        f"file must be a file or a rosbag2 folder with a {METADATA}, got the folder "
        f"{str(path)!r}; name a file in it"
    )


def require_whole(path: Path, limits: Limits) -> None:
    """Raise `InvalidInput` unless a rosbag2 folder has what its `metadata.yaml` says.

    That file must be YAML without aliases, which may stand for any amount of text; the files that
    it names must be there, and what is compressed as a whole must inflate to no more than
    ``limits.block_bytes``.
    """
    told = _metadata(path)
    names = told.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise InvalidInput(
            f"{path / METADATA} must name the files of the bag under relative_file_paths, got "
            f"{shown(names)!r}; run ros2 bag reindex"
        )
    files = [Path(name).name for name in names]
    for file in files:
        if not (path / file).is_file():
            raise InvalidInput(
                f"{path} must have the files that its {METADATA} names, got none called "
                f"{shown(file)!r}; put it there, or run ros2 bag reindex"
            )
        if files.count(file) > 1:
            raise InvalidInput(
                f"{path / METADATA} must name each file once, got {shown(file)!r} twice; run ros2 "
                "bag reindex"
            )
    if str(told.get("compression_mode", "")).lower() == "file":
        _require_small([path / file for file in files], limits, f"{path}")


def _metadata(path: Path) -> dict[str, Any]:
    """What a bag's own file says of it."""
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.events import AliasEvent
    except ImportError as error:
        raise MissingExtra("reading ROS bags", "ros") from error
    file = path / METADATA
    with reading(file), file.open("rb") as opened:
        data = opened.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise InvalidInput(
            f"{file} must be at most {LARGEST:,} bytes, got more; run ros2 bag reindex"
        )
    try:
        text = data.decode()
        aliased = any(isinstance(event, AliasEvent) for event in YAML(typ="safe").parse(text))
        told = None if aliased else YAML(typ="safe").load(text)[TOLD]
    except Exception as error:  # of a dozen kinds
        raise InvalidInput(
            f"{file} must be YAML that tells of a bag, got {type(error).__name__}: {shown(error)}; "
            "run ros2 bag reindex"
        ) from error
    if not isinstance(told, dict):
        said = "an alias in it" if aliased else shown(told)
        raise InvalidInput(
            f"{file} must be a table of what is in the bag, got {said}; run ros2 bag reindex"
        )
    return told


def _require_small(files: list[Path], limits: Limits, place: str) -> None:
    """Raise where files that are compressed as a whole inflate to more than may be read at once."""
    import sys

    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd

    size = 0
    for file in files:
        with reading(file), zstd.open(file, "rb") as inflated:
            while piece := inflated.read(PIECE):
                size += len(piece)
                limits.require("block_bytes", size, place, "record it in smaller files")
