"""What is entered: scripted ones, functions of the user's own, files of trained policies."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput
from coopenv.transition import Transition

from ..controllers import find_controller
from ..policy import Policy, RandomPolicy
from ..pretrained.catalogue import FILES, read
from ..pretrained.naming import file_of, is_name
from ..provenance import Provenance
from .own import Own
from .scenario import Scenario
from .seated import Seated
from .trained import Trained, recorded, told

TASK = "{task}"  # stands for the environment of a scenario in the name of a file
WORDS = ("nobody", "random", "scripted")
REMEDY = (
    f"give {', '.join(WORDS)}, module:function, the file of a trained policy, or pretrained:TASK/"
    f"joint, in which {TASK} stands for the task of each scenario"
)


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What is entered in the benchmark under a name."""

    name: str
    given: str
    sees: str
    """``nothing``, the ``observation`` alone, or the whole ``state``, which it may read."""
    policy: Callable[[Scenario], Policy]
    """What acts in a scenario; raises `InvalidInput` or `UnknownName` where it cannot."""
    digest: Callable[[Scenario], str | None]
    """SHA-256 of the file behind it."""
    trained: Callable[[Scenario], Trained | None]
    """How much training is behind it; ``None`` where it is not told."""


class Nobody:
    """Gives a zero action: no wrench; by hands, hands that stay where they are."""

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        return np.zeros((*obs.shape[:2], transition.action.shape[2]))


def read_entry(
    given: str,
    *,
    name: str | None = None,
    trust: bool = False,
    trained: int | None = None,
    seeds: int | None = None,
) -> Entry:
    """What a name enters.

    Parameters
    ----------
    given
        ``nobody``, ``random``, ``scripted`` or ``scripted:METHOD``; ``module:function``
        (`coopenv.agents.benchmark.own.Own`); or a policy's file, ``pretrained:BeamDoorway/joint``
        for example, in whose name ``{task}`` stands for the task of each scenario.
    name
        What it is called; made of ``given`` by default.
    trust
        Whether files may run what they hold (`coopenv.agents.pretrained.load`).
    trained, seeds
        How much training is behind it (`coopenv.agents.benchmark.trained.Trained`); ``None``: what
        a file of ``coopenv train`` records, and one seed.

    Raises
    ------
    InvalidInput, UnknownName
        If there is nothing of that name, or it can be nothing that acts; or if less training is
        told than a file records.
    """
    name = _label(given) if name is None else name
    if not name or _safe(name) != name:
        raise InvalidInput(
            f"name must be of letters, digits, dots, underscores and dashes, got {name!r}; a file "
            "will bear it"
        )
    training = {"steps": trained, "seeds": seeds}
    if is_name(given) or given.endswith(FILES):
        return _of_file(given, name, trust, training)
    if given.partition(":")[0] in WORDS:
        return _of_word(given, name, training)
    if ":" not in given:
        raise InvalidInput(f"entry must be something that acts, got {given!r}; {REMEDY}")
    own = Own(given)
    return Entry(
        name=name,
        given=given,
        sees=own.sees,
        policy=lambda scenario: own.policy(scenario.config),
        digest=lambda scenario: own.sha256,
        trained=lambda scenario: told(given, **training),
    )


def _of_word(given: str, name: str, training: Mapping[str, Any]) -> Entry:
    word, _, method = given.partition(":")
    if method and word != "scripted":
        raise InvalidInput(f"entry must have no method behind {word}, got {given!r}; leave it out")
    options = {"method": method} if method else {}
    makers: dict[str, Callable[[Scenario], Policy]] = {
        "nobody": lambda scenario: Nobody(),
        "random": lambda scenario: RandomPolicy(scenario.config),
        "scripted": lambda scenario: find_controller(scenario.config, **options),
    }
    return Entry(
        name=name,
        given=given,
        sees="state" if word == "scripted" else "nothing",
        policy=makers[word],
        digest=lambda scenario: None,
        trained=lambda scenario: told(given, **training, known=0),
    )


def _of_file(given: str, name: str, trust: bool, training: Mapping[str, Any]) -> Entry:
    def file(scenario: Scenario) -> Path:
        path = file_of(given.replace(TASK, scenario.env))
        if not path.is_file():
            raise InvalidInput(f"entry must be the file of a policy, got {str(path)!r}; {REMEDY}")
        return path

    def policy(scenario: Scenario) -> Policy:
        return _acting(read(file(scenario), trust=trust), scenario)

    def trained(scenario: Scenario) -> Trained | None:
        record = Provenance.read(file(scenario))
        known = None if record is None else recorded(record.training)
        return told(given, **training, known=known)

    if TASK not in given:  # then it is there or not, whatever the scenario
        read(file(Scenario(name="", env="")), trust=trust)
    return Entry(
        name=name,
        given=given,
        sees="observation",
        policy=policy,
        digest=lambda scenario: sha256(file(scenario).read_bytes()).hexdigest(),
        trained=trained,
    )


def _acting(trained: Any, scenario: Scenario) -> Policy:
    """A trained policy with the blocks of its record, or where these are set with no others."""
    if "sensing" in scenario.settings and scenario.config.partner is None:
        return trained
    try:
        return Seated(trained, scenario.config)
    except InvalidInput:
        if scenario.config.partner is not None:
            raise
        return trained  # of no record, or through sensors: it fits the environment or is left out


def _label(given: str) -> str:
    """A name for it: of a function its own, of a file without suffix."""
    is_file = is_name(given) or given.endswith(FILES)
    word = given.partition(":")[0]
    if not is_file and word not in WORDS:
        return _safe(given.rpartition(":")[2])
    for suffix in FILES:
        given = given.removesuffix(suffix)
    return _safe(given.replace(TASK, ""))


def _safe(text: str) -> str:
    return re.sub(r"[^\w.]+", "-", text).strip("-.")
