"""Every view of an environment as something to repeat: an episode begun and stepped."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from benchmarks.soak.drawn.pushes import any_actions
from coopenv import Body, Scene, Transport, TransportConfig
from tests.helpers import PARALLEL

STEPS = 3  # of an episode that is begun

Repeat = Callable[[], None]


class View(NamedTuple):
    """What is done with a view, again and again, and its end."""

    episode: Repeat
    close: Repeat


def keywords_of(config: TransportConfig) -> dict[str, Any]:
    """The keywords that make it, with one body and one scene."""
    found = {entry.name: getattr(config, entry.name) for entry in fields(config)}
    del found["sensing"]  # a word for `observe`, which has what it stood for
    for name, kind in (("body", Body), ("scene", Scene)):
        if not isinstance(found[name], kind):
            found[name] = found[name][0]
    return found


def core(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """The core, of which some worlds begin anew each time."""
    made, rng = Transport(num_worlds=num_worlds, config=config), np.random.default_rng(seed)
    made.reset(seed=seed)

    def episode() -> None:
        made.reset(mask=rng.random(num_worlds) < 0.8)
        for action in any_actions(rng, made, STEPS):
            ended = made.transition is not None and (
                made.transition.terminated | made.transition.truncated
            )
            made.step(action, restart=np.broadcast_to(ended, num_worlds))

    return View(episode, lambda: None)


def single(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """Gymnasium's, one world."""
    return _stepped(gymnasium.make(env, **keywords_of(config)))


def pictures(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """Gymnasium's, drawn at every step."""
    made = gymnasium.make(env, render_mode="rgb_array", **keywords_of(config))
    return _stepped(made, made.render)


def _stepped(made: gymnasium.Env, draw: Callable[[], Any] = lambda: None) -> View:
    def episode() -> None:
        made.reset()
        for _ in range(STEPS):
            _, _, terminated, truncated, _ = made.step(made.action_space.sample())
            draw()
            if terminated or truncated:
                return

    return View(episode, made.close)


def vector(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """Gymnasium's, many worlds."""
    made = gymnasium.make_vec(env, num_envs=num_worlds, **keywords_of(config))

    def episode() -> None:
        made.reset()
        for _ in range(STEPS):
            made.step(made.action_space.sample())

    return View(episode, made.close)


def parallel(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """PettingZoo's, all agents at once."""
    made = PARALLEL[env].parallel_env(**keywords_of(config))

    def episode() -> None:
        made.reset()
        for _ in range(STEPS):
            if made.agents:
                made.step({name: made.action_space(name).sample() for name in made.agents})

    return View(episode, made.close)


def turns(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """PettingZoo's, agents in turn."""
    made = PARALLEL[env].env(**keywords_of(config))

    def episode() -> None:
        made.reset()
        for name in made.agent_iter(STEPS * len(made.possible_agents)):
            _, _, terminated, truncated, _ = made.last()
            ended = terminated or truncated
            made.step(None if ended else made.action_space(name).sample())

    return View(episode, made.close)


def sb3_rows(env: str, config: TransportConfig, num_worlds: int, seed: int) -> View:
    """Stable-Baselines3's."""
    from coopenv.agents import sb3  # which imports torch

    made = sb3.make_vec_env(config, num_worlds)

    def episode() -> None:
        made.reset()
        for _ in range(STEPS):
            made.step(np.array([made.action_space.sample() for _ in range(made.num_envs)]))

    return View(episode, made.close)


VIEWS: dict[str, Callable[[str, TransportConfig, int, int], View]] = {
    "core": core,
    "Gymnasium": single,
    "pictures": pictures,
    "Gymnasium vector": vector,
    "PettingZoo parallel": parallel,
    "PettingZoo in turn": turns,
    "SB3": sb3_rows,
}
