"""Reading of trained policies: those of the package by task and control, others by their files."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from coopenv.errors import InvalidInput

from ..evaluation import Evaluation
from ..policy import Policy
from ..trained.archive import read_notes
from ..trained.form import is_plain
from ..trained.policy import PlainPolicy
from .naming import CONTROLS, file_of, named, shipped

if TYPE_CHECKING:
    from ..learned import SB3Policy

ROW = "evaluation"  # entry of the notes: what held-out episodes of its own environment showed
FILES = (".zip", ".npz")


def load(
    policy: str | os.PathLike,
    control: str | None = None,
    *,
    deterministic: bool = True,
    seed: int = 0,
    trust: bool = False,
) -> Policy:
    """A trained policy: one of the package by its task, or that of a file.

    ``load("BeamDoorway", "joint")`` needs neither torch nor Stable-Baselines3, nor does a ``.npz``
    of ``coopenv export``. A ``.zip`` needs both.

    Parameters
    ----------
    policy
        A task as ``"BeamDoorway"`` or ``"coopenv/BeamDoorway-v0"``, or the path of a policy's file,
        with its suffix.
    control
        Of a task: ``"joint"`` (the default), one policy that moves the whole team, or
        ``"shared"``, the same one for every agent.
    deterministic
        Take the mean action instead of a sample.
    seed
        Of sampled actions.
    trust
        Whether a ``.zip`` may run what it holds (`coopenv.agents.sb3.SB3Policy.load`).

    Raises
    ------
    InvalidInput, UnknownName
        If there is no such policy, or its file is damaged or needs ``trust``.
    MissingExtra
        If a ``.zip`` is given and the extra ``train`` is not installed.
    """
    text = os.fspath(policy)
    if Path(text).suffix in FILES:
        if control is not None:
            raise InvalidInput(
                f"control must be left out beside a file, got {control!r} for {text!r}; the file "
                "says what it controls"
            )
        return read(text, deterministic=deterministic, seed=seed, trust=trust)
    if control not in (None, *CONTROLS):
        raise InvalidInput(f"control must be one of {', '.join(CONTROLS)}, got {control!r}; fix it")
    name = named(text, control)
    return read(name, deterministic=deterministic, seed=seed)


def read(
    name: str | os.PathLike, *, deterministic: bool = True, seed: int = 0, trust: bool = False
) -> "PlainPolicy | SB3Policy":
    """The policy of a name as ``pretrained:BeamDoorway/joint``, or of a file; see `load`."""
    file = file_of(name)
    if is_plain(file):
        return PlainPolicy.load(file, deterministic=deterministic, seed=seed)
    if file.suffix == FILES[1]:
        read_notes(file)  # raises what is wrong with it, without torch
    from ..learned import SB3Policy

    return SB3Policy.load(file, deterministic=deterministic, seed=seed, trust=trust)


def names() -> tuple[str, ...]:
    """Policies of the package, as ``BeamDoorway/joint``."""
    return shipped()


def row_of(name: str) -> Evaluation | None:
    """The evaluation that a policy's file says of itself; ``None`` where it says none.

    Raises
    ------
    InvalidInput
        If it says one that is damaged.
    """
    given = read_notes(file_of(name)).get(ROW)
    return None if given is None else Evaluation.from_dict(given)
