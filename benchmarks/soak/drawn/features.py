"""Environments of every id with features drawn at random: body, scene, team, time, decomposition.

A feature that the rest refuses is left out, so that what is left is one that can be made.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from benchmarks.soak.drawn.ranges import any_ranges
from benchmarks.soak.drawn.rewards import any_cost, any_reward
from benchmarks.soak.drawn.senses import any_bounds, any_senses
from benchmarks.soak.drawn.tasks import any_task
from benchmarks.soak.drawn.teams import any_actuators, any_team
from coopenv import Body, Box, Scene, Transport, TransportConfig
from coopenv.agents import partners
from coopenv.envs.registry import PREFIX, find_config
from coopenv.errors import CoopenvError
from coopenv.wrench import METHODS, Settings
from coopenv.wrench.settings import WITH_SURROUNDINGS

MOST_WORLDS = 600  # three pymunk spaces, on several threads
REFUSING = ("max_internal", "net_force", "one_dimensional")  # some wrenches, by their definition

Draw = Callable[[np.random.Generator, str, TransportConfig], dict[str, Any]]


class Drawn(NamedTuple):
    """A configuration of an id, and of how many worlds."""

    env: str
    config: TransportConfig
    num_worlds: int


def ids() -> list[str]:
    """Every id that this package registers."""
    return sorted(name for name in gymnasium.registry if name.startswith(PREFIX))


def any_environment(
    rng: np.random.Generator, most_worlds: int = MOST_WORLDS, fewest_worlds: int = 1
) -> Drawn:
    """An id, that many worlds, and each of `FEATURES` half of the time."""
    env = str(rng.choice(ids()))
    num_worlds = round(fewest_worlds * (most_worlds / fewest_worlds) ** rng.random())
    keywords: dict[str, Any] = {}
    for draw in rng.permutation(np.array(FEATURES, dtype=object)):
        if rng.random() < 0.5:
            continue
        tried = {**keywords, **draw(rng, env, find_config(env, keywords))}
        if is_possible(env, tried):
            keywords = tried
    config = find_config(env, keywords)
    if num_worlds > 20 and config.decomposition.solver == "conic":
        num_worlds = 20  # a millisecond a world
    if rng.random() < 0.2:
        config = different_worlds(rng, env, keywords, num_worlds) or config
    return Drawn(env, config, num_worlds)


def is_possible(env: str, keywords: dict[str, Any]) -> bool:
    """Whether these keywords make an environment."""
    try:
        Transport(config=find_config(env, keywords))
    except CoopenvError:
        return False
    return True


def different_worlds(
    rng: np.random.Generator, env: str, keywords: dict[str, Any], num_worlds: int
) -> TransportConfig | None:
    """The same with a body and a scene for each world, if that can be."""
    config = find_config(env, keywords)
    assert isinstance(config.body, Body)
    assert isinstance(config.scene, Scene)
    bodies, scenes = [config.body], [config.scene]
    for _ in range(3):
        tried = {**keywords, **any_body(rng, env, config), **any_scene(rng, env, config)}
        same = tried["body"].num_agents == config.num_agents
        if same and is_possible(env, tried):
            bodies.append(tried["body"])
            scenes.append(tried["scene"])
    which = rng.integers(len(bodies), size=num_worlds)
    several = {"body": [bodies[k] for k in which], "scene": [scenes[k] for k in which]}
    try:
        return find_config(env, {**keywords, **several})
    except CoopenvError:
        return None


def any_body(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """A beam, a plate or a walker."""
    values = {
        "mass": rng.uniform(3.0, 30.0),
        "linear_drag": rng.choice([0.0, rng.uniform(0.0, 20.0)]),
        "angular_drag": rng.choice([0.0, rng.uniform(0.0, 20.0)]),
        "friction": rng.choice([0.0, rng.uniform(0.0, 1.0)]),
        "ground_friction": rng.choice([0.0, 0.0, rng.uniform(0.0, 0.5)]),
    }
    if "Walker" in env:
        del values["ground_friction"]
        grips = ((rng.uniform(-0.6, -0.3), rng.choice([0.0, 0.2])), (0.0, 0.0))
        rolls = bool(rng.random() < 0.8)
        return {"body": Body.walker(**values, grips=grips, nonholonomic=rolls)}
    kind = rng.integers(4)
    if kind == 0:
        return {"body": Body.beam(length=rng.uniform(0.8, 2.2), width=0.1, **values)}
    if kind == 1:
        return {"body": Body.plate(int(rng.integers(1, 7)), radius=rng.uniform(0.3, 0.8), **values)}
    if kind == 2:
        size = (rng.uniform(0.5, 2.0), rng.uniform(0.2, 1.0))
        return {"body": Body.plate(int(rng.integers(1, 6)), size=size, **values)}
    count = int(rng.integers(1, 6))
    grips = tuple(zip(rng.uniform(-0.9, 0.9, count), rng.uniform(-0.05, 0.05, count), strict=True))
    return {"body": Body(grips=grips, **values)}


def any_scene(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """A room with up to four obstacles in it."""
    boxes = [
        Box(
            center=tuple(rng.uniform(-2.5, 2.5, 2)),
            size=tuple(rng.uniform(0.1, 0.8, 2)),
            angle=rng.uniform(-4.0, 4.0),
        )
        for _ in range(rng.integers(5))
    ]
    size = tuple(rng.uniform(6.0, 12.0, 2))
    friction = float(rng.choice([0.0, 1.0]))
    falling = rng.random() < 0.3 or "Lift" in env
    gravity = (0.0, -9.81) if rng.random() < 0.7 else tuple(rng.uniform(-5.0, 5.0, 2))
    scene = Scene(
        size=size,
        obstacles=tuple(boxes),
        friction=friction,
        gravity=gravity if falling else (0.0, 0.0),
        normal_gravity=float(rng.choice([0.0, 9.81, rng.uniform(0.0, 20.0)])),
    )
    return {"scene": scene}


def any_time(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Steps short enough that no body may pass a wall of 2 m in one."""
    substep = rng.uniform(0.002, 0.05)  # [s]
    substeps = int(rng.integers(1, 6))
    return {
        "dt": substep * substeps,
        "substeps": substeps,
        "horizon": int(rng.choice([1, 5, 50, 200, 200])),
    }


def any_decomposition(
    rng: np.random.Generator, env: str, config: TransportConfig
) -> dict[str, Any]:
    """Any method and solver, any cost, with surroundings where they may be an effector."""
    method = str(rng.choice([name for name in METHODS if name not in REFUSING]))
    solver = "auto"
    if rng.random() < 0.5:
        method, solver = "optimal", str(rng.choice(["pair", "structured", "conic"]))
    possible = method in WITH_SURROUNDINGS and solver != "pair"
    settings = Settings(
        method=method,
        solver=solver,
        torque_weight=rng.uniform(0.02, 0.98),
        include_induced=bool(rng.random() < 0.5),
        surroundings=possible and bool(rng.random() < 0.5),
    )
    return {"decomposition": settings}


def any_partner(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """A partner of any kind, beside whom the others learn."""
    able = config.hands is not None
    named = [name for name, kind in partners.PARTNERS.items() if able or not kind.needs_hands]
    partner: Any = str(rng.choice(named))
    if rng.random() < 0.3:
        partner = partners.Noisy(force=rng.uniform(0.0, 10.0), torque=rng.uniform(0.0, 5.0))
    agents = rng.permutation(config.num_agents)[: rng.integers(1, max(2, config.num_agents))]
    driven = None if rng.random() < 0.5 else tuple(int(k) for k in agents)
    return {"partner": partner, "partner_agents": driven}


FEATURES: tuple[Draw, ...] = (
    any_body,
    any_scene,
    any_ranges,
    any_team,
    any_actuators,
    any_time,
    any_decomposition,
    any_partner,
    any_task,
    any_reward,
    any_cost,
    any_senses,
    any_bounds,
)
