"""Settings of SAC; `models.sac_settings` makes keywords of Stable-Baselines3 of them."""

import re
from dataclasses import dataclass
from typing import ClassVar

from coopenv.arrays import number, positive, whole
from coopenv.errors import InvalidInput

from ..settings import MOST, layers

COUNTS = ("steps", "num_worlds", "gradient_steps", "batch_size", "n_steps", "buffer")
LEAST = {**dict.fromkeys(COUNTS, 1), "random_steps": 0}
MOST_OF = {
    **{name: MOST[name] for name in ("steps", "num_worlds", "batch_size")},
    "random_steps": MOST["steps"],
    "gradient_steps": 10**4,
    "n_steps": 10**4,
    "buffer": 10**7,  # beyond, observations fill the memory
}
LEARNED = re.compile(r"auto(?:_(\d*\.?\d+(?:e-?\d+)?))?")  # weight of the entropy, where it begins


@dataclass(frozen=True, slots=True, kw_only=True)
class SACConfig:
    """SAC of Stable-Baselines3; the defaults learn BeamTransport.

    Raises
    ------
    InvalidInput
        If a setting breaks its rule.
    """

    SHARED: ClassVar[tuple[str, ...]] = ("steps",)  # with PPO: they mean the same there
    LOG_INTERVAL: ClassVar[int] = 100  # episodes between two entries of TensorBoard's log

    steps: int = 150_000
    """Control steps, counted over all worlds."""
    num_worlds: int = 64
    """Worlds stepped together."""
    gradient_steps: int = 4
    """After each control step of all worlds."""
    batch_size: int = 256
    """Samples in a gradient step."""
    learning_rate: float = 1e-3
    """At the start."""
    falling: bool = True
    """Whether the learning rate falls linearly to zero at steps."""
    discount: float = 0.98
    """Per control step."""
    entropy: str | float = 0.02
    """Its weight [reward / nat]. With auto it is learned towards the target, with auto_0.1 from 0.1
    on."""
    target_entropy: float | str = "auto"
    """Of a weight that is learned [nat]. With auto it is -1 for each number of an action."""
    hidden: tuple[int, ...] = (64, 64)
    """Layers of the policy's and of the critics' networks."""
    tau: float = 0.01
    """Of the target's way to the critic, in a gradient step."""
    random_steps: int = 5_000
    """Control steps by random actions before the first gradient."""
    n_steps: int = 1
    """Control steps of the returns."""
    buffer: int = 300_000
    """Control steps kept."""
    scaled: bool = True
    """Whether features are brought to order one."""

    def __post_init__(self) -> None:
        _set = object.__setattr__
        for name, least in LEAST.items():  # 3e5 of a file is 300,000
            given = whole(getattr(self, name), name, at_least=least, at_most=MOST_OF[name])
            _set(self, name, given)
        for name, most in (("learning_rate", MOST["learning_rate"]), ("discount", 1), ("tau", 1)):
            positive(getattr(self, name), name, at_most=most)
        for name in ("falling", "scaled"):
            if not isinstance(getattr(self, name), bool):
                raise InvalidInput(
                    f"{name} must be True or False, got {getattr(self, name)!r}; give one of them"
                )
        if self.buffer < self.batch_size:
            raise InvalidInput(
                f"buffer must hold the {self.batch_size:,} samples of a gradient step, got "
                f"{self.buffer:,}; give more, or lower batch_size"
            )
        _check_entropy(self)
        _set(self, "hidden", layers(self.hidden))
        if self.steps <= self.random_steps:
            raise InvalidInput(
                f"random_steps must be fewer than the {self.steps:,} steps, got "
                f"{self.random_steps:,}, which learns nothing; lower it, or give more steps"
            )


def _check_entropy(config: SACConfig) -> None:
    """Raise unless the weight of the entropy and its target are numbers, or to be found."""
    weight, target = config.entropy, config.target_entropy
    if isinstance(weight, str):
        found = LEARNED.fullmatch(weight)
        if found is None or not 0 < float(found[1] or 1) <= MOST["entropy_weight"]:
            raise InvalidInput(
                f"entropy must be a weight or auto, got {weight!r}; write 0.02, or auto_0.1 to "
                "learn it from 0.1 on"
            )
    else:
        positive(weight, "entropy", or_zero=True, at_most=MOST["entropy_weight"])
    if target != "auto":
        number(target, "target_entropy")
