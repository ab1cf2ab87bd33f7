"""A cell of a grid: one run, what it is told from others by, and the files it leaves."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from typing_extensions import Self

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.files import reading, written

from ..algorithms import RECIPES, Recipe, recipe_of
from ..algorithms.recipes import plain
from ..differences import differences
from ..settings import TrainConfig
from .levels import LEARNER, LEARNERS
from .revision import revision

CELL, RESULT, FAILURE = "cell.json", "evaluation.json", "failure.txt"  # in the folder of a cell
FORMAT = 1  # of CELL and RESULT; raised when one of before would mean something else
NO_PART = ("out", "threads", "checkpoint_every", "environment")  # of what a run is told by


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One run of a grid: everything that makes it what it is."""

    levels: Mapping[str, str]
    """Axis -> label of its level."""
    seed: int
    algorithm: str
    training: TrainConfig
    """Of no meaning but ``control`` to an algorithm that learns nothing, or by a recipe."""
    environment: TransportConfig
    """All of it; the one that ``training`` names may lack terms of the reward."""
    episodes: int
    evaluation: int
    """Number of the evaluation (`coopenv.agents.seeds`)."""
    continues: bool = False
    """Whether it goes on from a checkpoint when it was killed, or begins anew."""
    wandb: str | None = None
    """Project of Weights & Biases that its curves go to."""
    recipe: Recipe | None = None
    """Settings of an algorithm that learns and is not PPO."""

    @property
    def setting(self) -> str:
        """Its levels in one word, as part of a path."""
        return setting_name(self.levels)

    @property
    def folder(self) -> str:
        """Where it lies in the folder of its experiment."""
        return f"cells/{self.setting}/seed_{self.seed}"

    @property
    def learns(self) -> bool:
        """Whether there is a training."""
        return self.algorithm in LEARNERS

    @property
    def steps(self) -> int:
        """Control steps of its training; 0 without one."""
        settings = self.training if self.recipe is None else self.recipe
        return settings.steps if self.learns else 0

    def identity(self) -> dict[str, Any]:
        """What a result depends on, as JSON has it."""
        training = self.training.to_dict()
        kept = {name: value for name, value in training.items() if name not in NO_PART}
        is_ppo = self.algorithm == LEARNER
        return {
            "levels": dict(self.levels),
            "seed": self.seed,
            "algorithm": self.algorithm,
            "training": kept if is_ppo else {"control": self.training.control},
            **({} if self.recipe is None else {"recipe": plain(self.recipe)}),
            "environment": json.loads(self.environment.to_json()),
            "episodes": self.episodes,
            "evaluation": self.evaluation,
            "continues": self.continues,
        }

    def digest(self) -> str:
        """Mark of `identity`."""
        return digest_of(self.identity())

    def at(self, folder: Path) -> Self:
        """The same with the folder of its run."""
        return replace(self, training=replace(self.training, out=folder))

    def save(self, folder: Path) -> None:
        """Write it into its folder, with the revision of the code that is about to run it."""
        content = {
            "format": FORMAT,
            "revision": revision(),
            "settings": self.training.to_dict(),
            "wandb": self.wandb,
            **self.identity(),
        }
        with written(folder / CELL) as part:
            part.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> Self:
        """What `save` wrote.

        Raises
        ------
        InvalidInput
            If it cannot be read, or is of another format.
        """
        given = read_json(folder / CELL)
        with reading(folder / CELL):
            settings = {**given["settings"], "out": str(folder)}
            return cls(
                levels=given["levels"],
                seed=given["seed"],
                algorithm=given["algorithm"],
                training=TrainConfig.from_dict(settings, str(folder / CELL)),
                environment=TransportConfig.from_json(json.dumps(given["environment"])),
                episodes=given["episodes"],
                evaluation=given["evaluation"],
                continues=given["continues"],
                wandb=given["wandb"],
                recipe=recipe_of(given["algorithm"], given["recipe"])
                if given["algorithm"] in RECIPES
                else None,
            )

    def check(self, folder: Path) -> None:
        """Raise `InvalidInput` if the folder holds another cell, or something that is none."""
        if (folder / CELL).exists():
            given = read_json(folder / CELL)
            mine = self.identity()
            found = differences({name: given.get(name) for name in mine}, mine)
            if found:
                raise InvalidInput(
                    f"out must hold no other experiment, got {folder}, which differs in "
                    f"{', '.join(found)}; choose another out (--out), or move it away"
                )
        elif folder.exists() and any(not path.name.startswith(".") for path in folder.iterdir()):
            raise InvalidInput(
                f"out must hold cells alone, got {folder}, whose files no experiment wrote; choose "
                "another out (--out), or move it away"
            )

    def is_finished(self, folder: Path) -> bool:
        """Whether its result is there."""
        path = folder / RESULT
        return path.exists() and read_json(path).get("cell") == self.digest()


def setting_name(levels: Mapping[str, str]) -> str:
    """Levels in one word."""
    return ",".join(f"{axis}={label}" for axis, label in levels.items()) or "all"


def digest_of(identity: Mapping[str, Any]) -> str:
    """Mark of the identity of a cell, as JSON has it."""
    return sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()


def read_json(path: Path) -> dict[str, Any]:
    """An object of our format.

    Raises
    ------
    InvalidInput
        If it cannot be read, or is of another format.
    """
    with reading(path):
        given = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(given, dict) or given.get("format") != FORMAT:
        raise InvalidInput(
            f"{path} must be of format {FORMAT}, got {str(given)[:60]!r}; read it with the coopenv "
            "that wrote it, or move it away"
        )
    return given
