"""SAC of Stable-Baselines3 with one policy for the team."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from stable_baselines3 import SAC

from benchmarks.learning.algorithms.curve import Curve, Drawn
from coopenv.agents.sb3 import FallingRate, SB3Policy, Scaled, TransportVecEnv, feature_scale
from coopenv.agents.seeds import training_seeds
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Settings of SAC; the defaults are what came out of the search on BeamTransport."""

    steps: int  # control steps over all worlds
    num_worlds: int = 64  # stepped together
    gradient_steps: int = 2  # after each control step of all worlds
    batch_size: int = 256
    learning_rate: float = 1e-3
    falling: bool = True  # whether the learning rate falls to zero at the end
    discount: float = 0.98
    entropy: str | float = 0.02  # weight of the entropy [reward / nat]; auto: towards the target
    target_entropy: float | str = "auto"  # [nat]; auto: -1 an action
    hidden: tuple[int, ...] = (64, 64)
    tau: float = 0.01  # of the target's way to the critic, a gradient step
    random_steps: int = 5_000  # control steps before the first gradient
    n_steps: int = 1  # of the returns
    buffer: int = 300_000  # control steps kept
    scaled: bool = True  # features of order one


OF: Mapping[str, Mapping[str, Any]] = {  # what differs from the `Recipe`, by the search
    "BeamTransport": {"steps": 100_000},
    "BeamTracking": {"steps": 100_000},
    "WalkerTurn": {"steps": 400_000},
    "BeamDoorway": {"steps": 600_000},
    "WalkerAvoid": {"steps": 600_000},
    "BeamLift": {"steps": 500_000},
}


def settings(env: str) -> dict[str, Any]:
    """Those with which it is trained: of a `Recipe`."""
    return asdict(Recipe(**OF[env]))


def sac_settings(recipe: Recipe, scale: Sequence[float]) -> dict[str, Any]:
    """Keywords for ``SAC("MlpPolicy", venv, **keywords)``."""
    policy: dict[str, Any] = {"net_arch": list(recipe.hidden)}
    if recipe.scaled:
        policy["features_extractor_class"] = Scaled
        policy["features_extractor_kwargs"] = {"scale": list(scale)}
    rate = recipe.learning_rate
    return {
        "train_freq": 1,
        "gradient_steps": recipe.gradient_steps,
        "batch_size": recipe.batch_size,
        "learning_rate": FallingRate(rate) if recipe.falling else rate,
        "gamma": recipe.discount,
        "ent_coef": recipe.entropy,
        "target_entropy": recipe.target_entropy,
        "tau": recipe.tau,
        "learning_starts": recipe.random_steps,
        "n_steps": recipe.n_steps,
        "buffer_size": recipe.buffer,
        "policy_kwargs": policy,
        "device": "cpu",
    }


def learn(env: str, seed: int, given: dict[str, Any]) -> tuple[SB3Policy, Curve]:
    """Train with such settings of a `Recipe`."""
    recipe = Recipe(**given)
    environment = train_config(f"{PREFIX}{env}-v0").environment.config()
    curve = Curve(environment.horizon, recipe.num_worlds)
    venv = TransportVecEnv(environment, recipe.num_worlds)
    model = SAC("MlpPolicy", venv, seed=seed, **sac_settings(recipe, feature_scale(venv)))
    venv.seed(training_seeds(seed, recipe.num_worlds)[0])  # after the model, which seeds them too
    model.learn(recipe.steps, callback=Drawn(curve))
    return SB3Policy(model), curve
