"""Settings of recurrent PPO: those of PPO, and the units of its memory."""

from dataclasses import dataclass
from typing import ClassVar

from coopenv.arrays import whole
from coopenv.errors import InvalidInput

from ..settings import MOST_UNITS, TrainConfig

OF_PPO = (
    *("steps", "num_worlds", "rollout", "batch_size", "epochs", "learning_rate", "discount"),
    *("gae_lambda", "clip_range", "entropy_weight", "initial_std", "hidden"),
)
_PPO = TrainConfig()


@dataclass(frozen=True, slots=True, kw_only=True)
class RecurrentConfig:
    """Recurrent PPO of sb3-contrib, with settings of `coopenv.agents.settings.TrainConfig`.

    Raises
    ------
    InvalidInput
        If a setting breaks its rule.
    """

    SHARED: ClassVar[tuple[str, ...]] = OF_PPO
    LOG_INTERVAL: ClassVar[int] = 1  # rollouts between two entries of TensorBoard's log

    units: int = 64
    """Of the recurrent layer before the policy's network, and of that before the value's."""
    residual: bool = False
    """Whether features are added to what the recurrent layer makes of them, as far as it has
    units."""
    steps: int = 300_000
    """Control steps, counted over all worlds, in whole rollouts."""
    num_worlds: int = _PPO.num_worlds
    rollout: int = _PPO.rollout
    batch_size: int = _PPO.batch_size
    epochs: int = _PPO.epochs
    learning_rate: float = _PPO.learning_rate
    discount: float = _PPO.discount
    gae_lambda: float = _PPO.gae_lambda
    clip_range: float = _PPO.clip_range
    entropy_weight: float = _PPO.entropy_weight
    initial_std: float = _PPO.initial_std
    hidden: tuple[int, ...] = _PPO.hidden

    def __post_init__(self) -> None:
        of_ppo = self.of_ppo()
        for name in OF_PPO:
            object.__setattr__(self, name, getattr(of_ppo, name))
        if not isinstance(self.residual, bool):
            raise InvalidInput(
                f"residual must be True or False, got {self.residual!r}; give one of them"
            )
        units = whole(self.units, "units", at_least=1, at_most=MOST_UNITS)
        object.__setattr__(self, "units", units)

    def of_ppo(self, seed: int = 0) -> TrainConfig:
        """What it has in common with PPO, as settings of a run of that."""
        return TrainConfig(seed=seed, **{name: getattr(self, name) for name in OF_PPO})
