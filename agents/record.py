"""Recording of a held-out episode as a GIF."""

import os

import numpy as np
import numpy.typing as npt

from coopenv.config import TransportConfig
from coopenv.errors import MissingExtra
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

    core = Transport(num_worlds=1, config=config)
    check_environment(policy, core)
    seeds = [*evaluation_seeds(seed, 1)]
    obs, _ = core.reset(seed=seeds)
    forget(policy, np.ones(1, dtype=np.bool_), seeds)
    renderer = Renderer(core.bodies, core.scenes, mode="rgb_array")
    pictures, over = [], np.zeros(1, dtype=np.bool_)
    assert core.transition is not None
    pictures.append(renderer.draw(core.transition))
    while not over[0]:
        obs, _, terminated, truncated, _ = core.step(policy(obs, core.transition))
        pictures.append(renderer.draw(core.transition))
        over = terminated | truncated
    renderer.close()
    return pictures
