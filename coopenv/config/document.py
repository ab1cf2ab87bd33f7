"""The JSON document of a whole configuration: its format, its fields, and that it comes back."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from coopenv.config.json_form import read, written
from coopenv.config.json_text import parsed, text_of
from coopenv.config.keywords import read_observe
from coopenv.config.own_code import Trust
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import BLOCKS, Block, Entry, RangeReading, Sensor

KIND = "coopenv.TransportConfig"
VERSION = 1  # raised when a text of before would mean something else


def document_of(config: Mapping[str, Any]) -> str:
    """The fields of a configuration as JSON; see `TransportConfig.to_json`."""
    task = config["task"]
    own = {block.name: block for block in task.blocks}
    given = {name: value for name, value in config.items() if name != "sensing"}
    given["observe"] = tuple(_spelt_out(entry, own) for entry in given["observe"])
    values = {name: written(value, name) for name, value in given.items()}
    for name, value in values.items():
        again, mine = read(value, name, trust=True), config[name]
        if name == "observe":
            again = read_observe(None, again, task)
        if again != mine:
            raise InvalidInput(
                f"{name} must compare by value to be written, got {mine!r}, which would come back "
                f"as {again!r}; make what is in it frozen dataclasses whose fields say everything"
            )
    return text_of({"kind": KIND, "version": VERSION, **values})


def fields_in(text: str, known: Sequence[str], trust: Trust) -> dict[str, Any]:
    """The fields that a document holds; see `TransportConfig.from_json`."""
    values = parsed(text)
    kind, version = values.pop("kind", None), values.pop("version", None)
    if kind != KIND:
        raise InvalidInput(f"text must be of kind {KIND!r}, got {kind!r}; pass what to_json wrote")
    if type(version) is not int or version != VERSION:
        raise InvalidInput(
            f"version must be {VERSION}, got {version!r}; read it with the coopenv that wrote it, "
            "or a newer one"
        )
    for name in values:
        if name not in known:
            raise UnknownName("field of the configuration", name, known)
    try:
        return {name: read(value, name, trust) for name, value in values.items()}
    except RecursionError as error:
        raise InvalidInput("text must not nest without end; pass what to_json wrote") from error


def _spelt_out(entry: Entry, own: Mapping[str, Block]) -> Entry:
    """An entry whose ranges show their numbers, and the task's ``own`` blocks their names."""
    if isinstance(entry, Sensor):
        return replace(entry, block=_spelt_out(entry.block, own))  # pyright: ignore[reportArgumentType]
    if isinstance(entry, Block):
        return entry.name if own.get(entry.name) == entry else entry
    block = BLOCKS[entry]
    return block if isinstance(block.read, RangeReading) else entry
