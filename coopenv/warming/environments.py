"""Environments that make up all that steps, observations, rewards and partners compile."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import gymnasium
import numpy as np

from coopenv import rewards
from coopenv.agents.partners import PARTNERS
from coopenv.config.environment import ACTIONS
from coopenv.envs.registry import PREFIX, find_config
from coopenv.observation import BLOCKS, Sensor
from coopenv.physics.actuators import Actuators
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.randomisation import Ranges
from coopenv.stepping.worlds import WORTH_A_THREAD
from coopenv.transport import Transport
from coopenv.wrench import Settings

NUM_WORLDS = 2
STEPS = 3

TERMS = rewards.RewardSum(
    {
        "progress": rewards.Progress(),
        "success": rewards.Success(),
        "time": rewards.TimeCost(),
        "relative_cost": rewards.RelativeCost(),
        "wasted_cost": rewards.WastedCost(),
        "internal_force": rewards.InternalForce(),
        "internal_torque": rewards.InternalTorque(),
        "internal_power": rewards.InternalPower(),
        "load_share": rewards.LoadShare(),
        "effort": rewards.Effort(),
        "action_rate": rewards.ActionRate(),
        "contact": rewards.Contact(),
    }
)
STORED = rewards.RewardSum({"stored_energy": rewards.StoredEnergy()})
TRACKING = rewards.RewardSum({"tracking": rewards.TrackingError()})

VARIANTS: dict[str, Mapping[str, Any]] = {
    "as it is": {},
    "own senses": {"sensing": "own", "bounded": True},
    "shared senses": {"sensing": "shared"},
    "all rewards": {"reward": TERMS},
    "stored energy": {"reward": STORED},
    "tracking": {"reward": TRACKING},
    "a cost": {"cost": "squeeze"},
    "late actuators": {"actuators": Actuators(delay=1, time_constant=0.1, rate_limit=4.0)},
    "gravity": {"scene": Scene(gravity=(0.0, -9.81))},
    "ground friction": {"body": Body.beam(ground_friction=0.2)},
    "a team of three": {"body": Body.plate(3)},
    "surroundings": {"decomposition": Settings(surroundings=True)},
    "a sensor": {"observe": (Sensor("goal", noise=0.01, bias=0.01, delay=1),), "informed": (0,)},
    "ranges": {
        "randomise": Ranges(
            mass=(3.0, 8.0),
            friction=(0.1, 0.9),
            length=(1.5, 2.5),
            force_limit=(8.0, 12.0),
            delay=(0, 2),
        )
    },
    **{f"partner {name}": {"partner": name} for name in PARTNERS},
}
OBSERVED = {f"block {name}": {"observe": (name,)} for name in BLOCKS}


def works() -> Iterator[tuple[str, Callable[[], object]]]:
    """What to compile: what it is, and a call that does it or is refused."""
    ids = sorted(name for name in gymnasium.registry if name.startswith(PREFIX))
    for env in ids:
        for action in ACTIONS:
            variants = VARIANTS | OBSERVED if env == ids[0] else VARIANTS
            for name, keywords in variants.items():
                label = f"{env.removeprefix(PREFIX)}, action {action}, {name}"
                yield label, partial(_step, env, {**keywords, "action": action})
        yield f"{env.removeprefix(PREFIX)}, Gymnasium", partial(_views, env)
    yield "threads", _share


def _share() -> None:
    """A step of a batch that is large enough for more than one thread."""
    core = Transport(num_worlds=2 * WORTH_A_THREAD, threads=2)
    core.reset(seed=0)
    core.step(np.zeros(core.action_shape))


def _step(env: str, keywords: Mapping[str, Any]) -> None:
    """Steps of few worlds: one that goes on, one that restarts them, one from a state."""
    core = Transport(num_worlds=NUM_WORLDS, config=find_config(env, keywords))
    core.reset(seed=0)
    action = np.zeros(core.action_shape, dtype=np.int64 if core.table is not None else np.float64)
    for _ in range(STEPS):
        core.step(action)
    core.step(action, restart=np.ones(NUM_WORLDS, dtype=np.bool_))
    core.set_state(core.get_state())
    core.step(action)


def _views(env: str) -> None:
    """The views of an id, whose arrays may be of other kinds than those of the core."""
    single, vector = gymnasium.make(env), gymnasium.make_vec(env, num_envs=NUM_WORLDS)
    for view in (single, vector):
        view.reset(seed=0)
        view.step(view.action_space.sample())
        view.close()
