"""Folder of a training run: what the run writes there, and what of it may be removed."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from coopenv.errors import CoopenvError, InvalidInput
from coopenv.files import reading

from ..settings import TrainConfig
from ..trained import read_notes
from ..trained.record import RECORD
from .checkpoint import CHECKPOINT, POLICY

LOGS, LOG = "tensorboard", "ppo"  # TensorBoard's folders, and what they begin with
SETTINGS = "config.json"
WRITTEN = (  # beside the policy; the last three by ``coopenv train``
    *(SETTINGS, "curves.csv", "curves.png"),
    *("table.csv", "table.json", "episode.gif"),
)
_SAID = ("environment", "steps", "num_worlds", "out")  # by the settings of every run


def require_room(out: Path, *, fresh: bool) -> None:
    """Raise `InvalidInput` if a run would write over, or remove, what no run wrote.

    Policies that a run cannot take are refused by who reads them; here only those that ``fresh``
    would remove.
    """
    found = [name for name in WRITTEN if (out / name).exists()]
    if shows_run(out):
        found = []
    if fresh:
        found += [name for name in (POLICY, CHECKPOINT) if _training(out / name) == {}]
    if found:
        raise InvalidInput(
            f"out must be a folder of a run, a new or an empty one, got {out}, which holds "
            f"{', '.join(found)} that no run wrote; choose another out, or move it away"
        )


def shows_run(out: Path) -> bool:
    """Whether something in a folder says that a run was there."""
    return _has_settings(out) or any(_training(out / name) for name in (POLICY, CHECKPOINT))


def clear(out: Path) -> None:
    """Remove the run that a folder holds, so that no later call takes it for the new one."""
    if not shows_run(out):
        return
    for name in (POLICY, CHECKPOINT, *WRITTEN):
        (out / name).unlink(missing_ok=True)
    clear_logs(out, LOG)


def clear_logs(out: Path, name: str) -> None:
    """Remove TensorBoard's events of runs that are called so; what else lies there stays."""
    for log in (out / LOGS).glob(f"{name}_*/events.out.tfevents.*"):
        log.unlink()
        with suppress(OSError):  # a folder with something else in it stays
            log.parent.rmdir()


def _training(path: Path) -> dict[str, Any] | None:
    """Settings of the run that a policy is of, empty if of none; None if damaged or absent."""
    try:
        record = read_notes(path).get(RECORD, {})
    except CoopenvError:
        return None
    training = record.get("training", {}) if isinstance(record, dict) else None
    if not isinstance(training, dict):
        return None
    return training if all(name in training for name in _SAID) else {}


def _has_settings(out: Path) -> bool:
    """Whether ``config.json`` is that of a run, and not somebody's own of that name."""
    path = out / SETTINGS
    try:
        with reading(path):
            given = json.loads(path.read_text(encoding="utf-8"))
        TrainConfig.load(path)
    except CoopenvError:
        return False
    return isinstance(given, dict) and all(name in given for name in _SAID)
