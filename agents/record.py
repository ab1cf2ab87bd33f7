"""Recording of held-out episodes: their steps, and a GIF of one."""

import os

import numpy as np
import numpy.typing as npt

from coopenv.config import TransportConfig
from coopenv.errors import MissingExtra
from coopenv.transition import Transition
from coopenv.transport import Transport

from .policy import Policy, check_environment, forget
from .seeds import evaluation_seeds

PAUSE = 0.8  # [s] for which the last picture stays


def record_episode(
    policy: Policy, config: TransportConfig, path: str | os.PathLike, *, seed: int = 0
) -> None:
    """Run the first episode of evaluation number ``seed`` and write its pictures as a GIF.

    Raises
    ------
    MissingExtra
        If the extra ``render`` is not installed.
    """
    try:
        from coopenv.render import save_gif
    except ImportError as error:
        raise MissingExtra("the picture of an episode", "render") from error
    pictures = episode_pictures(policy, config, seed=seed)
    fps = max(1, round(1 / config.dt))
    save_gif(path, pictures + pictures[-1:] * round(PAUSE * fps), fps=fps)


def episode_pictures(
    policy: Policy, config: TransportConfig, *, seed: int = 0
) -> list[npt.NDArray[np.uint8]]:
    """Every control step of the episode, from its start to its end, ``(height, width, 3)``."""
    from coopenv.render import Renderer

    steps = episode_steps(policy, config, seed=seed)
    conditions = steps[0].conditions
    renderer = Renderer(conditions.bodies, conditions.scenes, mode="rgb_array")
    return [renderer.picture(step) for step in steps]


def episode_steps(
    policy: Policy, config: TransportConfig, *, seed: int = 0, episode: int = 1
) -> list[Transition]:
    """Run one episode of an evaluation.

    Parameters
    ----------
    policy
        Asked for the actions of a batch of one world.
    config
        The environment.
    seed
        Number of the evaluation; see `coopenv.agents.seeds`.
    episode
        Which of its episodes; the first is 1.

    Returns
    -------
    One transition a control step, after that of the start, in which nothing was applied.
    """
    core = Transport(num_worlds=1, config=config)
    check_environment(policy, core)
    seeds = [evaluation_seeds(seed, episode)[-1]]
    obs, _ = core.reset(seed=seeds)
    forget(policy, np.ones(1, dtype=np.bool_), seeds)
    assert core.transition is not None
    steps, over = [core.transition], np.zeros(1, dtype=np.bool_)
    while not over[0]:
        obs, _, terminated, truncated, _ = core.step(policy(obs, core.transition))
        steps.append(core.transition)
        over = terminated | truncated
    return steps
