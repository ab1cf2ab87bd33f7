"""``coopenv evaluate``: compare policies on the same held-out episodes."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from typing_extensions import Self

from coopenv.agents.environment import EnvironmentChoice
from coopenv.agents.pretrained.naming import expanded
from coopenv.agents.pretrained.rows import told
from coopenv.agents.seeds import evaluation_seeds
from coopenv.arrays import whole
from coopenv.cli.environments import RECORDED, Environment, environments_of
from coopenv.cli.options import runfile
from coopenv.cli.policies import find_policy, labels
from coopenv.config.own_code import Trust
from coopenv.errors import InvalidInput
from coopenv.files import require_writable, written
from coopenv.options import POSITIONAL, Common

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.evaluate import Evaluation
    from coopenv.agents.policy import Policy
    from coopenv.logs.formats.chunks import Sink


@dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Compare policies on the same held-out episodes.

    Each trained policy is evaluated in the environment that its file records, with what the options
    of the environment change; random and scripted in that of the first trained one.
    """

    policies: Annotated[tuple[str, ...], POSITIONAL] = ()
    """Files of trained policies, random, scripted, or scripted:nonsqueezing and the like;
    pretrained for all that the package brings, pretrained:BeamDoorway/joint for one."""
    environment: EnvironmentChoice = field(default_factory=lambda: EnvironmentChoice(env=RECORDED))
    episodes: int = 500
    """How many, the same for every policy."""
    seed: int = 0
    """Number of the evaluation; see coopenv.agents.seeds."""
    num_worlds: int = 250
    """Episodes run side by side."""
    out: Path | None = None
    """File for the table, .csv or .json."""
    record: Path | None = None
    """File for every step of every episode, .csv, .npz or .parquet, which coopenv decompose and
    coopenv replay read."""
    trust: tuple[str, ...] | None = None
    """Run what the files hold: alone, behind the policies, all of it, pickles of Stable-Baselines3
    and code of your own; with names of modules, import these for a recorded environment, rewards of
    yours for example, and nothing else."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv evaluate scripted random --episodes 20",
        "coopenv evaluate runs/policy.zip scripted --out table.csv",
        "coopenv evaluate scripted --env coopenv/BeamDoorway-v0 --partner follower --json",
        "coopenv evaluate scripted random --episodes 20 --record steps.csv",
    )

    @classmethod
    def configured(cls, path: Path, trust: Trust = False) -> Self:
        """The command with the options of a file, which may import the modules that are trusted."""
        return cls(**runfile.evaluation(path, cls().environment, trust))

    def run(self) -> dict[str, Any]:
        """Evaluate and print the table."""
        from rich.console import Console

        from coopenv.agents.evaluate import save, table

        self._check()
        names = self._names()
        named = dict(zip(labels(names), names, strict=True))
        console, errors = Console(), Console(stderr=True)
        places, notes = environments_of(named, self.environment, self._trusted)
        title = self._title(places)
        for note in notes:
            errors.print(note, markup=False, soft_wrap=True)
        seen = self._seen(named, places, console)
        console.print(table(seen, title))
        if self.environment == EnvironmentChoice(env=RECORDED):
            for line in told(dict(zip(names, seen, strict=True))):
                console.print(line, markup=False, highlight=False, soft_wrap=True)
        if self.out is not None:
            save(seen, self.out)
        return {
            "environments": {label: place.title(self._trusted) for label, place in places.items()},
            "policies": seen,
            "files": [path for path in (self.out, self.record) if path is not None],
        }

    def _names(self) -> list[str]:
        """One for each policy: those of the package one by one."""
        return [each for name in self.policies for each in expanded(name)]

    @property
    def _trusted(self) -> Trust:
        """What the files may import: nothing, these modules, or anything."""
        return False if self.trust is None else self.trust or True

    def _check(self) -> None:
        """Raise where a policy is missing, a number is wrong or a table cannot be written."""
        from coopenv.agents.evaluate import table_format
        from coopenv.logs.formats import FORMATS, find_format

        if not self.policies:
            raise InvalidInput(
                "policies must name at least one, got none; for example: coopenv evaluate scripted"
            )
        for name in self.trust or ():
            if not name.replace(".", "").isidentifier() or Path(name).is_file():
                raise InvalidInput(
                    f"trust must be given alone or with names of modules, got {name!r}; put "
                    "--trust behind the policies"
                )
        names = self._names()
        for name in names:
            if names.count(name) > 1:
                raise InvalidInput(
                    f"policies must be named once each, got {name!r} again; its episodes would be "
                    "the same, so leave it out"
                )
        evaluation_seeds(self.seed, whole(self.episodes, "episodes", at_least=1))
        whole(self.num_worlds, "num_worlds", at_least=1)
        if self.out is not None:
            table_format(self.out)
            require_writable(self.out)
        if self.record is not None:
            find_format(self.record, FORMATS)
            require_writable(self.record)

    def _seen(
        self, named: Mapping[str, str], places: Mapping[str, Environment], console: "Console"
    ) -> "list[Evaluation]":
        from coopenv.agents.evaluate import evaluate
        from coopenv.agents.record import Recorder
        from coopenv.agents.training.threads import torch_threads

        policies = {label: self._found(name, places[label]) for label, name in named.items()}
        teams = {place.config.num_agents for place in places.values()}
        if self.record is not None and len(teams) > 1:
            raise InvalidInput(
                f"record must be of teams of one size, got {sorted(teams)}; evaluate the policies "
                "one by one"
            )
        status = console.status(f"evaluating on {self.episodes} held-out episodes")
        with torch_threads(1), status, self._recorded() as sink:  # one: networks are small
            return [
                evaluate(
                    policy,
                    places[label].config,
                    episodes=self.episodes,
                    seed=self.seed,
                    num_worlds=self.num_worlds,
                    name=label,
                    recorder=None if sink is None else Recorder(sink, label),
                )
                for label, policy in policies.items()
            ]

    @contextmanager
    def _recorded(self) -> "Iterator[Sink | None]":
        """Where steps go, whole or not at all."""
        from coopenv.logs.formats import open_sink

        if self.record is None:
            yield None
            return
        with written(self.record) as part:
            sink = open_sink(part)
            try:
                yield sink
                sink.close()
            except BaseException:
                with suppress(OSError, ValueError):  # what went wrong first is what is told
                    sink.abandon()
                raise

    def _found(self, name: str, place: Environment) -> "Policy":
        """The policy of that name for its environment."""
        try:
            return find_policy(name, place.config, trust=self._trusted is True)
        except InvalidInput as error:
            scripted = name.partition(":")[0] == "scripted"
            if not scripted or place.config.hands is None or self.environment.env != RECORDED:
                raise
            raise InvalidInput(
                f"{error}; {name} was to act where the trained policy did: evaluate it by itself, "
                f"for example by coopenv evaluate {name} --env {place.env} --action wrench"
            ) from error

    def _title(self, places: Mapping[str, Environment]) -> str:
        """Environments, what they have other than their ids' defaults, and the episodes."""
        groups: dict[str, list[str]] = {}
        for label, place in places.items():
            groups.setdefault(place.title(self._trusted), []).append(label)
        if len(groups) == 1:
            return f"{next(iter(groups))}, {self.episodes} episodes"
        lines = [f"{', '.join(group)}: {title}" for title, group in groups.items()]
        return "\n".join([*lines, f"{self.episodes} episodes each"])
