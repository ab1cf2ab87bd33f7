"""The command line: ``coopenv <command> --help``.

A command is a dataclass whose fields are its options and whose ``run`` does it; `COMMANDS` lists
them. What needs an extra is imported when it runs.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.studies.commands import Beam, Dyads, WalkerAvoid, WalkerTurn
from coopenv.config import TransportConfig
from coopenv.errors import CoopenvError, InvalidInput, MissingExtra
from coopenv.logs.command import Decompose

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.curves import Row
    from coopenv.agents.policy import Policy


class Command(Protocol):
    """What the command line can run."""

    def run(self) -> None:
        """Do it, printing for people and writing files for programs."""
        ...


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train PPO, then compare it with a random and the scripted policy on held-out episodes.

    Writes policy, curves, table and a GIF of an episode. A run that was killed goes on from its
    last checkpoint when the same command is given again.
    """

    training: TrainConfig = field(default_factory=TrainConfig)
    episodes: int = 500
    """Held-out episodes of the comparison."""
    gif: bool = True
    """Draw an episode of the trained policy."""

    def run(self) -> None:
        """Train, evaluate, draw."""
        from rich.console import Console

        from coopenv.agents.controllers import RandomPolicy, find_controller
        from coopenv.agents.evaluate import compare, save, table
        from coopenv.agents.train import train

        out, config = self.training.out, self.training.environment.config()
        console = Console()
        if (out / "checkpoint.zip").exists() and not self.training.fresh:
            console.print(f"going on from the checkpoint in {out}", markup=False)
        with _training_progress(self.training.steps, console) as report:
            trained = train(self.training, report=report)
        with console.status(f"evaluating on {self.episodes} held-out episodes"):
            policies: dict[str, Policy] = {
                "trained PPO": trained,
                "random": RandomPolicy(config),
                "scripted": find_controller(config),
            }
            seen = compare(policies, config, episodes=self.episodes)
        for name in ("table.json", "table.csv"):
            save(seen, out / name)
        console.print(table(seen, f"{self.training.environment.env}, {self.episodes} episodes"))
        pictures = ["curves.png"]
        if self.gif:
            pictures += _draw_episode(trained, config, out / "episode.gif", console)
        console.print(
            f"in {out}: policy.zip, config.json, table.csv, {', '.join(pictures)}", markup=False
        )


@dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Compare policies on the same held-out episodes."""

    policies: tuple[str, ...]
    """Files of trained policies, random, scripted, or scripted:nonsqueezing and the like."""
    environment: EnvironmentChoice = field(default_factory=EnvironmentChoice)
    episodes: int = 500
    """How many, the same for every policy."""
    seed: int = 0
    """Number of the evaluation; see coopenv.agents.seeds."""
    num_worlds: int = 250
    """Episodes run side by side."""
    out: Path | None = None
    """File for the table, .csv or .json."""

    def run(self) -> None:
        """Evaluate and print the table."""
        from rich.console import Console

        from coopenv.agents.evaluate import compare, save, table

        if not self.policies:
            raise InvalidInput(
                "policies must name at least one, got none; for example: coopenv evaluate scripted"
            )
        environment = self._environment()
        config = environment.config()
        policies = {
            label: find_policy(name, config)
            for label, name in zip(_labels(self.policies), self.policies, strict=True)
        }
        console = Console()
        with console.status(f"evaluating on {self.episodes} held-out episodes"):
            seen = compare(
                policies,
                config,
                episodes=self.episodes,
                seed=self.seed,
                num_worlds=self.num_worlds,
            )
        console.print(table(seen, f"{environment.env}, {self.episodes} episodes"))
        if self.out is not None:
            save(seen, self.out)

    def _environment(self) -> EnvironmentChoice:
        """What was asked for; if nothing was, what the first trained policy was trained in."""
        if self.environment != EnvironmentChoice():
            return self.environment
        for name in self.policies:
            beside = Path(name).with_name("config.json")
            if name.endswith(".zip") and beside.exists():
                return TrainConfig.load(beside).environment
        return self.environment


@dataclass(frozen=True, kw_only=True)
class Study:
    """Run a study of the paper and check its claims, or analyse recorded trials the same way."""

    study: WalkerTurn | WalkerAvoid | Beam | Dyads

    def run(self) -> None:
        """Run it."""
        self.study.run()


COMMANDS: dict[str, type[Command]] = {
    "train": Train,
    "evaluate": Evaluate,
    "decompose": Decompose,
    "study": Study,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that ``arguments`` (by default those of the process) name."""
    try:
        _read(arguments).run()
    except CoopenvError as error:
        print(f"coopenv: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("coopenv: interrupted; give the same command again to go on", file=sys.stderr)
        return 130
    return 0


def _read(arguments: Sequence[str] | None) -> Command:
    """The command and its options; tyro prints help and stops where they make no sense."""
    try:
        import tyro
    except ImportError as error:
        wanted = list(sys.argv[1:] if arguments is None else arguments)[:1]
        extra = "analysis" if wanted == ["decompose"] else "train"
        raise MissingExtra("the command line", extra) from error
    return tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="coopenv",
        description="Learn to carry things together.",
        args=arguments,
        config=(
            tyro.conf.OmitArgPrefixes,
            tyro.conf.OmitSubcommandPrefixes,
            tyro.conf.PositionalRequiredArgs,
        ),
    )


def find_policy(name: str, config: TransportConfig) -> "Policy":
    """The policy of that name for an environment: a kind of scripted one, or a trained file."""
    from coopenv.agents.controllers import RandomPolicy, find_controller

    kind, _, allocation = name.partition(":")
    if kind == "scripted":
        return find_controller(config, **({"method": allocation} if allocation else {}))
    if name == "random":
        return RandomPolicy(config)
    if not Path(name).is_file():
        raise InvalidInput(
            f"policy must be random, scripted or the file of a trained policy, got {name!r}; "
            "coopenv train writes such a file"
        )
    from coopenv.agents.sb3 import SB3Policy

    return SB3Policy.load(name)


def _labels(names: Sequence[str]) -> list[str]:
    """What to call policies in a table: the folder of a ``policy.zip``, else the name itself."""
    short = [Path(name).parent.name if Path(name).name == "policy.zip" else name for name in names]
    return [
        label if label and short.count(label) == 1 else name
        for label, name in zip(short, names, strict=True)
    ]


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


if __name__ == "__main__":
    sys.exit(main())
