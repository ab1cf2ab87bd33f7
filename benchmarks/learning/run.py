"""A training run of the baselines, and the settings that name it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX

APART = ("environment", "control", "seed", "threads", "checkpoint_every", "out")


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a training cost, and what its policy does."""

    env: str  # without "coopenv/" and version
    seed: int
    settings: Mapping[str, Any]  # of what learns
    steps: int  # that were done
    seconds: float  # of the processor, imports aside
    reached: tuple[float | None, ...]  # [s] until each of the levels; None where it never was
    success: float  # of its mean actions
    sampled: float  # of sampled ones
    time: float | None  # [s] of the episodes that succeed
    relative_cost: float  # γ


@dataclass(frozen=True, kw_only=True)
class Run(Outcome):
    """A training of PPO, whose settings are of `TrainConfig`."""

    control: str
    partner: str | None = None  # who is beside the learner
    action: str | None = None  # None: as the environment has it

    @property
    def name(self) -> str:
        """Of its file: what it has in common with runs of other seeds."""
        return "_".join(filter(None, (self.env, self.control, self.partner, self.action)))

    @property
    def is_plain(self) -> bool:
        """Whether the whole team learns, with the actions that the environment has."""
        return self.partner is None and self.action is None

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it: a partner and an action are told where there is one."""
        absent = [name for name in ("partner", "action") if getattr(self, name) is None]
        return {name: value for name, value in asdict(self).items() if name not in absent}


def configured(
    env: str,
    control: str,
    seed: int,
    out: Path,
    *,
    partner: str | None = None,
    action: Any = None,
) -> TrainConfig:
    """A run as ``coopenv train`` has it, from its start, since its seconds count."""
    whole = f"{PREFIX}{env}-v0"
    own = EnvironmentChoice(env=whole).config().action
    choice = EnvironmentChoice(env=whole, partner=partner, action=None if action == own else action)
    config = train_config(choice, control=control, seed=seed, fresh=True)
    chosen = config.environment  # with the partner that is the default
    parts = (env, control, chosen.partner, chosen.action, f"{seed}")
    return replace(config, out=out / "_".join(filter(None, parts)))


def settings_of(config: TrainConfig) -> dict[str, Any]:
    """What the runs of an environment, a control and an action have in common."""
    own = {name: value for name, value in config.to_dict().items() if name not in APART}
    return {**own, "also_observe": [*(config.environment.also_observe or ())]}


def is_of(run: Run, env: str, config: TrainConfig) -> bool:
    """Whether a run is the one that is asked for, with the settings of today."""
    chosen = config.environment
    who = run.env, run.control, run.partner, run.action, run.seed
    asked = env, config.control, chosen.partner, chosen.action, config.seed
    return who == asked and dict(run.settings) == settings_of(config)
