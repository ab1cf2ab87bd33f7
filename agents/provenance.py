"""Provenance of a trained policy: its environment, settings, versions and command, as JSON.

It is kept in the file of a policy, beside the entries of Stable-Baselines3, so that what is asked
of the file later does not depend on the folder it lies in.
"""

import json
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import gymnasium
from typing_extensions import Self

from coopenv.config import TransportConfig
from coopenv.config.own_code import Trust
from coopenv.envs.registry import PREFIX, find_config
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.files import reading

from .differences import differences
from .environment import EnvironmentChoice
from .settings import TrainConfig

KEY, FORMAT = "provenance", 1  # in the notes; raised when one of before would mean something else
PACKAGES = ("coopenv", "numpy", "torch", "stable-baselines3", "pymunk")


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where a policy comes from; plain JSON values."""

    environment: dict[str, Any]
    """All of the environment: `TransportConfig.to_json`."""
    training: dict[str, Any]
    """Settings of the run: `TrainConfig.to_dict`, or those of another algorithm, with its name as
    ``algorithm``. Of a policy that a program of the user's own trained, ``control`` and the id that
    its environment is nearest to; the rest is not known."""
    versions: dict[str, str]
    """Of Python and of what computed the run."""
    command: list[str]
    """Program and arguments of the process."""

    @classmethod
    def of(cls, training: TrainConfig, environment: TransportConfig) -> Self:
        """That of a run which begins now.

        Raises
        ------
        InvalidInput
            If something in the environment cannot be written; the message says what to do.
        """
        return cls._now(_written(environment), training.to_dict())

    @classmethod
    def of_recipe(
        cls, training: TrainConfig, environment: TransportConfig, recipe: Mapping[str, Any]
    ) -> Self:
        """That of a run of another algorithm than PPO which begins now.

        Parameters
        ----------
        training
            Of the run, of which control, seed and environment are its own as well.
        environment
            All of it.
        recipe
            ``algorithm``, and its settings.

        Raises
        ------
        InvalidInput
            If something in the environment cannot be written; the message says what to do.
        """
        said = training.to_dict()
        common = {name: said[name] for name in ("environment", "control", "seed")}
        return cls._now(_written(environment), {**common, **recipe})

    @classmethod
    def of_environment(
        cls, environment: TransportConfig, control: str, teams: Sequence[int] = ()
    ) -> Self:
        """That of a policy that a program of the user's own trains, perhaps in ``teams`` of sizes.

        Raises
        ------
        InvalidInput
            If something in the environment cannot be written; the message says what to do.
        """
        values = _written(environment)
        training = {"control": control, "environment": {"env": _nearest(values)}}
        return cls._now(values, {**training, **({"teams": list(teams)} if teams else {})})

    @classmethod
    def _now(cls, environment: dict[str, Any], training: dict[str, Any]) -> Self:
        return cls(
            environment=environment, training=training, versions=versions(), command=_command()
        )

    @classmethod
    def from_notes(cls, notes: Mapping[str, Any], source: str = "") -> Self | None:
        """What `to_notes` wrote; ``None`` if the notes say nothing of it.

        Parameters
        ----------
        source
            What the notes are of, for the error.

        Raises
        ------
        InvalidInput
            If it is of another format, or damaged.
        """
        given = notes.get(KEY)
        if given is None:
            return None
        names = {entry.name for entry in fields(cls)}
        where = f" ({source})" if source else ""
        if (
            not isinstance(given, Mapping)
            or given.get("format") != FORMAT
            or {*given, "training"} != {"format", *names}
        ):
            raise InvalidInput(
                f"{KEY} must be of format {FORMAT}, got {given!r:.80}; read it with the "
                f"coopenv that wrote it, or a newer one{where}"
            )
        values: dict[str, Any] = {name: given.get(name) for name in names}
        if values["training"] is None:  # of a policy that no run of ours trained
            values["training"] = {}
        for name, value in values.items():
            if not _is_right(name, value):
                raise InvalidInput(
                    f"{KEY}.{name} must be what a run wrote there, got {value!r:.80}; the file is "
                    f"damaged: copy it again{where}"
                )
        return cls(**values)

    @classmethod
    def read(cls, path: str | os.PathLike) -> Self | None:
        """That of a policy's file; ``None`` if the file does not say.

        Raises
        ------
        InvalidInput
            If the file cannot be read, or is of another format.
        """
        from .trained import read_notes

        return cls.from_notes(read_notes(path), f"policy {os.fspath(path)!r}")

    @classmethod
    def read_beside(cls, path: str | os.PathLike) -> Self | None:
        """That of a run's ``config.json``; ``None`` if the file does not say.

        Raises
        ------
        InvalidInput
            If the file cannot be read, or is of another format.
        """
        with reading(path):
            notes = json.loads(Path(path).read_text(encoding="utf-8"))
        return cls.from_notes(notes if isinstance(notes, dict) else {}, os.fspath(path))

    def to_notes(self) -> dict[str, Any]:
        """An entry for `coopenv.agents.trained.NOTES`."""
        return {KEY: {"format": FORMAT, **asdict(self)}}

    def config(self, *, trust: Trust = False) -> TransportConfig:
        """The environment; ``trust`` as in `TransportConfig.from_json`.

        Raises
        ------
        InvalidInput, UnknownName
            If it holds code of somebody's own that is not trusted, or not what it was.
        """
        return TransportConfig.from_json(json.dumps(self.environment), trust=trust)

    @property
    def has_own_code(self) -> bool:
        """Whether the environment names code that is not of this package."""
        return '"sha256"' in json.dumps(self.environment)  # which no other entry has

    @property
    def env(self) -> str:
        """The Gymnasium id that was named, or the nearest; the default where none is known."""
        return self.training["environment"]["env"] if self.training else EnvironmentChoice().env

    def differences(self, other: Self) -> list[str]:
        """Dotted names of what keeps one run from going on from the other's checkpoint."""
        return differences(self.identity(), other.identity())

    def other_versions(self) -> list[str]:
        """What has another version now, in words."""
        now = versions()
        return [
            f"{name} {then} (now {now.get(name, 'missing')})"
            for name, then in self.versions.items()
            if now.get(name) != then
        ]

    def identity(self) -> dict[str, Any]:
        """What two runs must have in common for one to go on from the other's checkpoint.

        A field that an older record does not have is at its default, which stands for what was
        before.
        """
        settings = TrainConfig.from_dict(self.training).identity()
        return {**settings, "environment": {**_written(TransportConfig()), **self.environment}}


def _is_right(name: str, value: Any) -> bool:
    """Whether an entry is of its kind."""
    if name == "command":
        return isinstance(value, list) and all(isinstance(word, str) for word in value)
    if not isinstance(value, Mapping):
        return False
    if name == "versions":
        return all(isinstance(each, str) for each in value.values())
    if name == "training" and value:
        environment = value.get("environment")
        return isinstance(environment, Mapping) and isinstance(environment.get("env"), str)
    return True


def _written(environment: TransportConfig) -> dict[str, Any]:
    """All of an environment as plain values."""
    try:
        return json.loads(environment.to_json())
    except CoopenvError as error:
        raise InvalidInput(
            f"environment must be one that the policy's file can hold: {error}"
        ) from error


def _nearest(environment: Mapping[str, Any]) -> str:
    """The id of this package with the same kind of task and the fewest other values."""

    def distance(env: str) -> tuple[bool, int]:
        names = differences(json.loads(find_config(env, {}).to_json()), environment)
        return "task" in names, len(names)

    return min((env for env in gymnasium.registry if env.startswith(PREFIX)), key=distance)


def versions() -> dict[str, str]:
    """Versions of Python and of the packages whose code makes a run what it is."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # coopenv itself, run from its sources
            found[name] = "unknown"
    return found


def _command() -> list[str]:
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name  # python -m
    return [name, *sys.argv[1:]]
