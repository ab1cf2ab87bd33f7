"""Files of experiments: TOML, every key of it known, each mistake told with its line."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from coopenv.errors import InvalidInput, UnknownName
from coopenv.files import reading, toml

from .grid import Experiment
from .levels import AXES
from .lines import Source
from .search import Search

TABLES = ("experiment", "environment", "training", "grid", "exclude", "search")
OPTIONS = ("name", "seeds", "episodes", "problems", "continues", "wandb", "out")
ELSEWHERE = {
    **dict.fromkeys(OPTIONS, "put it under [experiment]"),
    **{axis: f"put it under [grid], as [grid.{axis}]" for axis in AXES},
    "steps": "put it under [training]",
}


def load(path: str | Path) -> tuple[Experiment, Search | None]:
    """The experiment that a file describes, and the search over its settings if it has one.

    Nothing is run or written. `Experiment.cells` checks the levels.

    Raises
    ------
    InvalidInput
        If the file cannot be read, is no TOML, has an unknown key or a value out of range; the
        message ends with file and line.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise InvalidInput(f"file must be a .toml file, got {str(path)!r}; rename it")
    with reading(path):
        text = path.read_text(encoding="utf-8-sig")
        content = toml.loads(text)
    source = Source.of(str(path), text.replace("\r\n", "\n"))
    for name in content:
        with source.at((name,)):
            if name not in TABLES:
                raise UnknownName("table of an experiment", name, TABLES, ELSEWHERE)
            kind = list if name == "exclude" else dict
            if not isinstance(content[name], kind):
                form = "[[exclude]]" if kind is list else f"[{name}]"
                raise InvalidInput(f"{name} must be a table, got {content[name]!r}; write {form}")
    given = _options(content.get("experiment", {}), source)
    values = {name: content[name] for name in TABLES[1:-1] if name in content}
    given.setdefault("name", path.stem)
    given.setdefault("out", Path("runs") / path.stem)
    experiment = Experiment(**given, **values, source=source)
    search = content.get("search")
    return experiment, None if search is None else Search.read(search, experiment)


def _options(given: Mapping[str, Any], source: Source) -> dict[str, Any]:
    """What stands under ``[experiment]``, of the right kinds."""
    kinds: Mapping[str, type] = {"name": str, "continues": bool, "wandb": str, "out": str}
    for name, value in given.items():
        with source.at(("experiment", name)):
            if name not in OPTIONS:
                raise UnknownName("option of experiment", name, OPTIONS)
            kind = kinds.get(name)
            if kind is not None and (not isinstance(value, kind) or value == ""):
                rule = "true or false" if kind is bool else "a text"
                raise InvalidInput(f"{name} must be {rule}, got {value!r}; write one")
    return {**given, **({"out": Path(given["out"])} if "out" in given else {})}
