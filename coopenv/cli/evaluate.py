"""``coopenv evaluate``: compare policies on the same held-out episodes."""

from dataclasses import dataclass, field
from pathlib import Path

from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.cli.policies import find_policy, labels
from coopenv.errors import InvalidInput


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
            for label, name in zip(labels(self.policies), self.policies, strict=True)
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
