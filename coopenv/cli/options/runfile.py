"""Files of ``coopenv train`` and ``evaluate``: in the form of a run's ``config.json``.

On top are the options of ``coopenv train``, under ``environment`` those that say which environment
it is, under ``evaluation`` the options of ``coopenv evaluate``. Both commands take the same file;
what is given on the command line wins.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from coopenv.agents.differences import differences
from coopenv.agents.environment import EnvironmentChoice
from coopenv.agents.provenance import Provenance, versions
from coopenv.agents.settings import NOTED, UNSAVED, TrainConfig
from coopenv.agents.training.presets import preset
from coopenv.cli.options.content import (
    PLACES,
    TRAINING,
    checked,
    content_of,
    environment,
    environment_table,
    without_fresh,
)
from coopenv.config.own_code import Trust
from coopenv.errors import CoopenvError, InvalidInput

COMPARISON = ("episodes", "gif")  # of coopenv train, beside the training's own
EVALUATION = ("episodes", "seed", "num_worlds", "out")


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
    top = (*TRAINING, *COMPARISON, "evaluation")
    noted, content = _parted(content_of(path))
    content = without_fresh(checked(content, f"option in {path}", top, PLACES), path)
    what = f"option in {path}, evaluation"
    content["evaluation"] = checked(content.get("evaluation", {}), what, EVALUATION, PLACES)
    table = environment_table(content.get("environment", {}), path, trust)
    whole = noted is not None or ("observe" in table and "also_observe" not in table)
    also = {"also_observe": table.get("also_observe") or []} if whole else {}
    content["environment"] = {**table, **also}  # of a run, what is observed is all there
    if noted is not None:
        _check_recorded(noted, content, path)
    return content


def training(
    path: Path,
    trust: Trust = False,
    env: str | None = None,
    action: str | None = None,
    control: str | None = None,
) -> dict[str, Any]:
    """Options of ``coopenv train`` in a file, as its fields.

    Settings that the file does not name are the preset of ``env``, ``action`` and ``control``, or
    where they are ``None`` of the file's.
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
    chosen = values["environment"]
    which = env or chosen.env, action or chosen.action, control or values.get("control")
    settings = {**preset(*which), **values}
    return {"training": TrainConfig(**settings), **comparison}


def evaluation(path: Path, start: EnvironmentChoice, trust: Trust = False) -> dict[str, Any]:
    """Options of ``coopenv evaluate`` in a file, as its fields."""
    content = load(path, trust)
    values = dict(content["evaluation"])
    if "out" in values:
        values["out"] = _path(values["out"])
    return {"environment": environment(content["environment"], start), **values}


def _parted(content: Any) -> tuple[Any, Any]:
    """What a run notes beside its options, None if there is nothing; and the options.

    Runs of before wrote ``fresh``, said for their one call, among the options.
    """
    if not isinstance(content, dict) or not set(NOTED) & set(content):
        return None, content
    options = {name: content[name] for name in content if name not in (*NOTED, *UNSAVED)}
    return content, options


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


def _path(value: Any) -> Path:
    if not isinstance(value, str):
        raise InvalidInput(f"out must be the name of a place, got {value!r}; put it in quotes")
    return Path(value)
