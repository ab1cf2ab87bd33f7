"""Settings of a training with RLlib."""

from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Literal, get_args, get_type_hints

from coopenv.arrays import number, positive, whole
from coopenv.errors import InvalidInput, UnknownName

from ..environment import EnvironmentChoice
from ..seeds import evaluation_seeds, training_seeds

COUNTS = ("steps", "worlds", "batch_size", "minibatch_size", "epochs", "episodes")


@dataclass(frozen=True, slots=True, kw_only=True)
class RLlibConfig:
    """Multi-agent PPO of RLlib, each agent on what it sees itself."""

    environment: EnvironmentChoice = field(default_factory=EnvironmentChoice)
    policies: Literal["shared", "own"] = "shared"
    """One policy that every agent runs, or each agent its own."""
    address: str | None = None
    """Of a Ray cluster, HOST:6379, ray://HOST:10001 or auto; by default what RAY_ADDRESS says, or a
    Ray on this machine's cores that ends with the command."""
    runners: int = 0
    """Processes that collect, on whatever nodes have room, a core each; 0: the command's own."""
    worlds: int = 16
    """Environments of each, one after the other."""
    seed: int = 0
    """Number of the run; its episodes are none that an evaluation has (coopenv.agents.seeds)."""
    steps: int = 400_000
    """Control steps over all worlds, in whole batches."""
    batch_size: int = 4096
    """Control steps between two updates."""
    minibatch_size: int = 1024
    """Samples of a policy in a gradient step."""
    epochs: int = 10
    """Times each sample is used."""
    learning_rate: float = 1e-3
    """At the start; it falls linearly to zero at steps."""
    discount: float = 0.99
    """Per control step."""
    gae_lambda: float = 0.95
    """Per control step."""
    clip_range: float = 0.2
    """PPO's bound on the change of the action's probability ratio."""
    entropy_weight: float = 0.0
    """Reward for randomness [reward / nat]."""
    hidden: tuple[int, ...] = (64, 64)
    """Layers of each policy's and each value's network."""
    episodes: int = 200
    """Held-out ones, by which the policy is judged; evaluation 0, as coopenv evaluate."""
    out: Path = Path("runs/rllib")
    """Folder for policy.npz, evaluation.json and RLlib's own checkpoint."""

    def __post_init__(self) -> None:
        for name in COUNTS:
            whole(getattr(self, name), name, at_least=1)
        whole(self.runners, "runners", at_least=0)
        known = get_args(get_type_hints(RLlibConfig)["policies"])
        if self.policies not in known:
            raise UnknownName("policies", self.policies, known)
        positive(self.learning_rate, "learning_rate")
        positive(self.clip_range, "clip_range")
        for name, most in (("discount", 1.0), ("gae_lambda", 1.0), ("entropy_weight", inf)):
            if not 0 <= number(getattr(self, name), name) <= most:
                rule = "in [0, 1]" if most == 1 else "0 or more"
                raise InvalidInput(
                    f"{name} must be {rule}, got {getattr(self, name)!r}; give another one"
                )
        if not self.hidden:
            raise InvalidInput("hidden must be sizes of layers, got none; give at least one: 64")
        for units in self.hidden:
            whole(units, "hidden", at_least=1)
        if self.steps < self.batch_size:
            raise InvalidInput(
                f"steps must be at least one batch, {self.batch_size:,}, got {self.steps:,}; give "
                "more, or a smaller batch_size"
            )
        training_seeds(self.seed, (self.runners + 1) * self.worlds)
        evaluation_seeds(0, self.episodes)
