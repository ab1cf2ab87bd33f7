"""BenchMARL: any environment as a task, trained by any of its algorithms."""

from collections.abc import Callable
from typing import Any

from tensordict import TensorDictBase
from torchrl.data import Composite
from torchrl.envs import EnvBase

from coopenv.config import ACTIONS
from coopenv.envs.registry import find_config
from coopenv.errors import MissingExtra

from .env import make_env
from .specs import GROUP

try:
    from benchmarl.environments import TaskClass  # pyright: ignore[reportMissingImports]
except ImportError as error:
    raise MissingExtra("coopenv.agents.torchrl.benchmarl", "benchmarl") from error

DISCRETE = "discrete"  # the name of numbers of pushes among actions
INFOS = ("relative_cost", "wasted_cost", "internal_force_level")  # that are logged


def make_task(env: str = "coopenv/BeamTransport-v0", **keywords: Any) -> "TransportTask":
    """A task for ``benchmarl.experiment.Experiment``.

    Parameters
    ----------
    env
        A Gymnasium id of this package.
    **keywords
        Fields of `coopenv.TransportConfig`, over those of the id.

    Raises
    ------
    InvalidInput, UnknownName
        If they do not make an environment.
    """
    find_config(env, keywords)
    return TransportTask(env.rpartition("/")[2], {"env": env, **keywords})


class TransportTask(TaskClass):
    """An id with its keywords, which are the task's ``config``; all agents are one group.

    Beside returns, BenchMARL logs γ, the wasted cost and F_I as infos, and the share of episodes
    that terminated as ``collection/success_rate``: in success, but in a task that can fail
    (``BeamLift``) in failure too.
    """

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], EnvBase]:
        """How a batch of ``num_envs`` worlds is made."""
        env, keywords = self.config["env"], _keywords(self.config)
        if not continuous_actions:
            keywords["action"] = DISCRETE
        return lambda: make_env(env, num_envs, device=device, seed=seed, info=INFOS, **keywords)

    def supports_continuous_actions(self) -> bool:
        """Forces and torques, unless numbers of pushes are asked for."""
        return self.config.get("action") != DISCRETE

    def supports_discrete_actions(self) -> bool:
        """Numbers of pushes, where environments have them."""
        return DISCRETE in ACTIONS

    def has_render(self, env: EnvBase) -> bool:
        """Pictures are of the first world."""
        return True

    def max_steps(self, env: EnvBase) -> int:
        """The horizon, in control steps."""
        return find_config(self.config["env"], _keywords(self.config)).horizon

    def group_map(self, env: Any) -> dict[str, list[str]]:
        """All agents that learn, in one group."""
        return env.group_map

    def observation_spec(self, env: EnvBase) -> Composite:
        """What an agent sees."""
        return _without(env.full_observation_spec_unbatched, "info")

    def info_spec(self, env: EnvBase) -> Composite:
        """What is logged of a step."""
        return _without(env.full_observation_spec_unbatched, "observation")

    def action_spec(self, env: EnvBase) -> Composite:
        """What an agent does."""
        return env.full_action_spec_unbatched

    def state_spec(self, env: EnvBase) -> None:
        """Central critics get what all agents see."""

    def action_mask_spec(self, env: EnvBase) -> None:
        """Every action is allowed."""

    @staticmethod
    def env_name() -> str:
        """What logs are named after."""
        return "coopenv"

    @staticmethod
    def log_info(batch: TensorDictBase) -> dict[str, float]:
        """Share of the episodes that terminated: in success, or where a task can fail in either."""
        ends = batch["next", "done"]
        if not ends.any():
            return {}
        return {"collection/success_rate": batch["next", "terminated"][ends].float().mean().item()}


def _keywords(config: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in config.items() if name != "env"}


def _without(spec: Composite, entry: str) -> Composite:
    rest = spec.clone()
    del rest[GROUP, entry]
    return rest
