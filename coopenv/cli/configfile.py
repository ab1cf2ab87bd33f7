"""Files of options, ``--config``: TOML or JSON in the form of a run's ``config.json``.

On top are the options of ``coopenv train``, under ``environment`` those that say which environment
it is, under ``evaluation`` the options of ``coopenv evaluate``. Both commands take the same file;
what is given on the command line wins.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from coopenv.agents.differences import differences
from coopenv.agents.overrides import GROUPS, entries_of
from coopenv.agents.provenance import Provenance, versions
from coopenv.agents.settings import NOTED, UNSAVED, EnvironmentChoice, TrainConfig
from coopenv.agents.training.presets import preset
from coopenv.config.own_code import Trust
from coopenv.envs.registry import require_trusted
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.files import reading, toml

ENVIRONMENT = tuple(entry.name for entry in fields(EnvironmentChoice))
TRAINING = tuple(entry.name for entry in fields(TrainConfig))
COMPARISON = ("episodes", "gif")  # of coopenv train, beside the training's own
EVALUATION = ("episodes", "seed", "num_worlds", "out")
PLACES = {
    **dict.fromkeys(TRAINING, "put it on top of the file, before the first [table]"),
    **dict.fromkeys(ENVIRONMENT, "put it under [environment]"),
}


def load(path: Path, trust: Trust = False) -> dict[str, Any]:
    """The content of a file of options, of which every name is known.

    Parameters
    ----------
    path
        Of the file.
    trust
        Modules that may be imported because the file's ``env`` names them; ``True``: any. The
        file itself cannot say.

    Raises
    ------
    InvalidInput
        If the file cannot be read, is neither TOML nor JSON, has another form or says ``fresh``;
        or if it is of a run in another environment than its options name, or names a module that
        is not trusted.
    UnknownName
        If a name is not an option.
    """
    if path.suffix not in (".toml", ".json"):
        raise InvalidInput(f"config must be a .toml or .json file, got {str(path)!r}; rename it")
    with reading(path):
        text = path.read_text(encoding="utf-8-sig")  # editors of some systems begin with a mark
        content = toml.loads(text) if path.suffix == ".toml" else json.loads(text)
    top = (*TRAINING, *COMPARISON, "evaluation")
    noted, content = _parted(content)
    content = _without_fresh(_checked(content, f"option in {path}", top), path)
    for name, known in (("environment", ENVIRONMENT), ("evaluation", EVALUATION)):
        content[name] = _checked(content.get(name, {}), f"option in {path}, {name}", known)
    require_trusted(_plain(content["environment"].get("env", ""), "env"), trust, str(path))
    if noted is not None:
        _check_recorded(noted, content, path)
    return content


def training(path: Path, trust: Trust = False, env: str | None = None) -> dict[str, Any]:
    """Options of ``coopenv train`` in a file, as its fields.

    Settings that the file does not name are the preset of ``env``, or if that is ``None`` of the
    file's id.
    """
    content = load(path, trust)
    values = {name: content[name] for name in TRAINING if name in content}
    values["environment"] = environment(content["environment"], EnvironmentChoice())
    if isinstance(values.get("hidden"), list):
        values["hidden"] = tuple(values["hidden"])
    if "out" in values:
        values["out"] = _path(values["out"])
    comparison = {name: content[name] for name in COMPARISON if name in content}
    if not isinstance(comparison.get("gif", True), bool):
        raise InvalidInput(f"gif must be true or false, got {comparison['gif']!r}; write one")
    settings = {**preset(env or values["environment"].env), **values}
    return {"training": TrainConfig(**settings), **comparison}


def evaluation(path: Path, start: EnvironmentChoice, trust: Trust = False) -> dict[str, Any]:
    """Options of ``coopenv evaluate`` in a file, as its fields."""
    content = load(path, trust)
    values = dict(content["evaluation"])
    if "out" in values:
        values["out"] = _path(values["out"])
    return {"environment": environment(content["environment"], start), **values}


def environment(given: Mapping[str, Any], start: EnvironmentChoice) -> EnvironmentChoice:
    """What a file says of the environment, over ``start``."""
    values = {
        name: entries_of(value, name) if name in GROUPS else _plain(value, name)
        for name, value in given.items()
    }
    return replace(start, **values)


def _parted(content: Any) -> tuple[Any, Any]:
    """What a run notes beside its options, None if there is nothing; and the options.

    Runs of before wrote ``fresh``, said for their one call, among the options.
    """
    if not isinstance(content, dict) or not set(NOTED) & set(content):
        return None, content
    options = {name: content[name] for name in content if name not in (*NOTED, *UNSAVED)}
    return content, options


def _without_fresh(content: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """The options; raise if they would remove a run whenever the file is used.

    ``false`` is what runs of before wrote, and removes nothing.
    """
    for name in UNSAVED:
        if content.get(name, False) is not False:
            raise InvalidInput(
                f"{name} must be given on the command line, got {content[name]!r} in {path}, which "
                f"would remove a run each time; take it out of the file and give --{name}"
            )
    return {name: value for name, value in content.items() if name not in UNSAVED}


def _check_recorded(noted: Mapping[str, Any], content: Mapping[str, Any], path: Path) -> None:
    """Raise if the file's options name another environment than its run had.

    A run that was given its environment from Python has options that do not tell of it.
    """
    provenance = Provenance.from_notes(noted, str(path))
    if provenance is None:
        return
    choice = environment(content["environment"], EnvironmentChoice())
    named = json.loads(choice.config().to_json())
    found = differences(provenance.environment, named)
    if not found:
        return
    _require_readable(provenance, path)
    causes = [
        "the run was given its environment from Python (train it there with "
        "TransportConfig.from_json of the record, evaluate its policy.zip without --config)",
        "the options were changed (then take provenance out of the file)",
    ]
    then, now = provenance.versions.get("coopenv"), versions()["coopenv"]
    if then != now:
        causes.append(
            f"coopenv {then}, which wrote it, had other defaults than {now} (then give its numbers "
            "as options, and take provenance out)"
        )
    raise InvalidInput(
        f"config must name the environment that its run had, got {path}, whose options differ "
        f"from its record in {', '.join(found)}; {', or '.join(causes)}"
    )


def _require_readable(provenance: Provenance, path: Path) -> None:
    """Raise if the record is no environment; one with code of somebody's own is not run for it."""
    if provenance.has_own_code:
        return
    try:
        provenance.config()
    except CoopenvError as error:
        raise InvalidInput(
            f"config must hold the environment of its run as it was written, got {path}, whose "
            f"provenance.environment cannot be read ({error}); copy the file again, or take "
            "provenance out of it if its options name the environment"
        ) from error


def _checked(content: Any, what: str, known: Iterable[str]) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise InvalidInput(f"{what} must be a name with a value, got {content!r}; write a table")
    names = {name: name.replace("-", "_") for name in content}
    for name in names.values():
        if name not in known:
            raise UnknownName(what, name, known, PLACES)
    return {names[name]: value for name, value in content.items()}


def _plain(value: Any, name: str) -> Any:
    if name == "observe" and isinstance(value, list):
        return tuple(value)
    if name == "env" and not isinstance(value, str):
        raise InvalidInput(f"env must be an id, got {value!r}; coopenv/BeamTransport-v0 is one")
    return value


def _path(value: Any) -> Path:
    if not isinstance(value, str):
        raise InvalidInput(f"out must be the name of a place, got {value!r}; put it in quotes")
    return Path(value)
