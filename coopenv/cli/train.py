"""``coopenv train``: train PPO, compare, draw an episode."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from typing_extensions import Self

from coopenv.agents.environment import EnvironmentChoice
from coopenv.agents.seeds import evaluation_seeds
from coopenv.agents.settings import TrainConfig
from coopenv.agents.training.presets import observing, preset
from coopenv.arrays import whole
from coopenv.cli.environments import Environment
from coopenv.cli.options import runfile
from coopenv.config import TransportConfig
from coopenv.config.own_code import Trust
from coopenv.errors import MissingExtra
from coopenv.files import locked, require_folder
from coopenv.options import Common

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.curves import Row
    from coopenv.agents.evaluate import Evaluation
    from coopenv.agents.policy import Policy


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train PPO, then compare it with a random and the scripted policy on held-out episodes.

    Writes policy, curves, table and a GIF of an episode. A run that was interrupted goes on when
    the same command is given again, or with more steps; one that is finished is evaluated.
    """

    training: TrainConfig = field(default_factory=TrainConfig)
    episodes: int = 500
    """Held-out episodes of the comparison."""
    gif: bool = True
    """Draw an episode of the trained policy."""
    trust: bool = False
    """Import the module that the file of options names before its id (module:id), and run what the
    file of a partner holds."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv train --steps 300000 --out runs/first",
        "coopenv train --env coopenv/BeamDoorway-v0 --reward harmony --partner population",
        "coopenv train --config runs/first/config.json --seed 1 --out runs/second",
        "coopenv train --control shared --teams 2 6 --out runs/any_team",
    )

    @classmethod
    def suited(
        cls, env: str | None = None, action: str | None = None, control: str | None = None
    ) -> Self:
        """The command with the settings that an environment's id has, such actions and learners."""
        chosen = EnvironmentChoice() if env is None else EnvironmentChoice(env=env)
        settings = preset(chosen.env, action, control)
        return cls(training=TrainConfig(environment=chosen, **settings))

    @classmethod
    def configured(
        cls, path: Path, trust: Trust = False, env: str | None = None, **others: str | None
    ) -> Self:
        """The command with the options of a file, which may import the modules that are trusted.

        What the file does not say is as ``env``, ``action`` and ``control`` have it, or where they
        are ``None`` the file's.
        """
        return cls(**runfile.training(path, trust, env, **others))

    def __post_init__(self) -> None:
        evaluation_seeds(0, whole(self.episodes, "episodes", at_least=1))

    def run(self) -> dict[str, Any]:
        """Train, evaluate, draw, while nobody else does in the same folder."""
        require_folder(self.training.out)
        with locked(self.training.out):
            return replace(self, training=observing(self.training)).run_alone()

    def run_alone(self) -> dict[str, Any]:
        """`run` where nobody else works in the folder, with all that is observed said."""
        from rich.console import Console

        from coopenv.agents.partners import trusting
        from coopenv.agents.train import train
        from coopenv.agents.training.threads import torch_threads

        config = self.training.environment.config()
        config = trusting(config) if self.trust else config
        console = Console()
        tell = partial(console.print, markup=False)
        with _training_progress(self.training.steps, console) as report:
            trained = train(self.training, environment=config, report=report, tell=tell)
        try:
            with torch_threads(self.training.threads):
                return self._evaluate(trained, config, console)
        except KeyboardInterrupt as stop:
            raise KeyboardInterrupt(
                f"interrupted; the trained policy is {self.training.out / 'policy.zip'}, and the "
                "same command goes straight to its evaluation"
            ) from stop

    def _evaluate(
        self, trained: "Policy", config: TransportConfig, console: "Console"
    ) -> dict[str, Any]:
        """Compare with other policies, draw an episode, say what was written."""
        from coopenv.agents.evaluate import save, table

        out = self.training.out
        with console.status(f"evaluating on {self.episodes} held-out episodes"):
            seen = self._compared(trained, config)
        for name in ("table.json", "table.csv"):
            save(seen, out / name)
        title = Environment(self.training.environment.env, config).title()
        console.print(table(seen, f"{title}, {self.episodes} episodes"))
        files = ["policy.zip", "config.json", "table.csv", "curves.png"]
        if self.gif:
            files += _draw_episode(trained, config, out / "episode.gif", console)
        console.print(f"in {out}: {', '.join(files)}", markup=False)
        return {"environment": title, "policies": seen, "folder": out, "files": files}

    def _compared(self, trained: "Policy", config: TransportConfig) -> "list[Evaluation]":
        """The trained, a random and the scripted policy, in each of the teams if there are some."""
        from coopenv.agents.controllers import RandomPolicy, find_controller
        from coopenv.agents.environment.teams import team_configs
        from coopenv.agents.evaluate import compare

        seen = []
        for each in team_configs(config, self.training.teams):
            policies: dict[str, Policy] = {
                "trained PPO": trained,
                "random": RandomPolicy(each),
                "scripted": find_controller(each),
            }
            of = f", team of {each.num_agents}" if self.training.teams else ""
            named = {f"{name}{of}": policy for name, policy in policies.items()}
            seen += compare(named, each, episodes=self.episodes)
        return seen


@contextmanager
def _training_progress(steps: int, console: "Console") -> "Iterator[Callable[[Row], None]]":
    """A progress bar over control steps with the newest success rate and γ beside it."""
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    bar = Progress(
        TextColumn("training"),
        BarColumn(),
        TextColumn("{task.completed:>9,.0f} of {task.total:,.0f} steps"),
        TextColumn("success {task.fields[success]}  γ {task.fields[relative_cost]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
    )
    with bar:
        task = bar.add_task("", total=steps, success="-", relative_cost="-")

        def report(row: "Row") -> None:
            bar.update(task, completed=min(row["steps"], steps))
            for name in {"success", "relative_cost"} & set(row):
                bar.tasks[task].fields[name] = f"{row[name]:.2f}"

        yield report
        if not bar.tasks[task].completed:  # it was finished before
            bar.update(task, visible=False)


def _draw_episode(
    policy: "Policy", config: TransportConfig, path: Path, console: "Console"
) -> list[str]:
    """Write the GIF, or say why there is none; what was written."""
    from coopenv.agents.record import record_episode

    try:
        with console.status("drawing an episode"):
            record_episode(policy, config, path)
    except MissingExtra as error:
        console.print(f"no GIF: {error}", markup=False)
        return []
    return [path.name]
