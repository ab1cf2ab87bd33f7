"""Recording of held-out episodes: their steps, a table of them, and a GIF of one."""

import os

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray
from coopenv.config import TransportConfig
from coopenv.errors import MissingExtra
from coopenv.geometry.frames import rotated_back
from coopenv.info import Info
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, effector_names, wrench_names
from coopenv.logs.formats.chunks import Sink
from coopenv.render.film import PAUSE
from coopenv.transition import Transition
from coopenv.transport import Transport

from .policy import Policy, check_environment, forget
from .seeds import evaluation_seeds


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


class Recorder:
    """Writes every step of evaluated episodes as rows that `coopenv.logs.read` takes.

    It is a `coopenv.agents.evaluate.Watcher`, for the ``recorder`` of an evaluation.

    An episode is a trial; a row is the end of a step, with the wrenches that were held in it, in
    the columns of docs/recordings.md and the object frame. Beside them it carries the team's mean
    reward and the contacts' impulse [N·s].

    Parameters
    ----------
    sink
        Of the table; whoever opened it closes it.
    condition
        What the rows are called in the column of that name.
    """

    def __init__(self, sink: Sink, condition: str):
        self._sink, self._condition = sink, condition
        self._rows: list[FloatArray] = []
        self._worlds: list[npt.NDArray[np.int64]] = []
        self._num_agents = self._before = 0  # episodes that were written

    def add(
        self, transition: Transition, reward: FloatArray, info: Info, running: BoolArray
    ) -> None:
        """Remember the step of the worlds ``(world,)`` that run."""
        self._num_agents = transition.applied.shape[1]
        self._rows.append(_rows_of(transition, reward)[running])
        self._worlds.append(np.flatnonzero(running))

    def end(self, episodes: int) -> None:
        """Write what is remembered, which is that many whole episodes, one after the other."""
        worlds = np.concatenate(self._worlds)
        order = np.argsort(worlds, kind="stable")
        rows, trial = np.concatenate(self._rows)[order], self._before + worlds[order] + 1
        columns = dict(zip(column_names(self._num_agents), rows.T, strict=True))
        condition = np.full(len(rows), self._condition)
        self._sink.write({"condition": condition, "trial": trial, **columns})
        self._rows, self._worlds = [], []
        self._before += episodes


def column_names(num_agents: int) -> list[str]:
    """Columns of numbers of a `Recorder`."""
    grips = [name for group in effector_names("r", num_agents, 2) for name in group]
    pose = (*POSITION[2], *ORIENTATION[2], *TWIST[2])
    wrench = wrench_names(num_agents, 2)
    return ["time", *pose, *grips, *wrench, "reward", "contact_impulse"]


def _rows_of(transition: Transition, reward: FloatArray) -> FloatArray:
    """``(world, column)`` in the order of `column_names`."""
    state, count = transition.next_state, len(reward)
    angle = state.pose[:, 2]
    along, across = rotated_back(np.cos(angle), np.sin(angle), state.twist[:, 0], state.twist[:, 1])
    return np.column_stack(
        [
            state.time,
            state.pose,
            along,
            across,
            state.twist[:, 2],
            transition.team.grips.reshape(count, -1),
            transition.applied.reshape(count, -1),
            reward.mean(axis=1),
            transition.contact_impulse,
        ]
    )
