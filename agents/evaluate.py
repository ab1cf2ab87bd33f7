"""Evaluation of policies on held-out episodes, alone or side by side."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.info import Info
from coopenv.transition import Transition
from coopenv.transport import Transport

from .episodes import Episodes, EpisodeSums
from .evaluation import Evaluation, save, table, table_format, wilson_interval
from .policy import Policy, Samplable, check_environment, forget
from .seeds import evaluation_seeds

__all__ = [
    "Evaluation",
    "Watcher",
    "compare",
    "evaluate",
    "run_episodes",
    "save",
    "table",
    "table_format",
    "wilson_interval",
]


class Watcher(Protocol):
    """Is shown every step of `run_episodes`, to keep or measure what `Episodes` does not have."""

    def add(
        self, transition: Transition, reward: FloatArray, info: Info, running: BoolArray
    ) -> None:
        """A step.

        Parameters
        ----------
        transition
            Of all worlds.
        reward
            ``(world, agent)``.
        info
            Of the step.
        running
            ``(world,)`` worlds whose episode it is of; the others only fill the batch.
        """
        ...

    def end(self, episodes: int) -> None:
        """So many episodes have come to their end, that of world k being the k-th."""
        ...


def evaluate(
    policy: Policy,
    config: TransportConfig | None = None,
    *,
    episodes: int = 500,
    seed: int = 0,
    num_worlds: int = 250,
    name: str = "",
    recorder: Watcher | None = None,
) -> Evaluation:
    """Run held-out episodes and summarise them.

    Parameters
    ----------
    policy
        Asked for the actions of all worlds at once.
    config
        The environment; the default one if ``None``.
    episodes
        How many; each has a world seed of its own that no training uses.
    seed
        Number of the evaluation: the same starts and goals for every policy.
    num_worlds
        Episodes run side by side. It changes the figures by rounding only: random actions are
        keyed by episode and step (`coopenv.agents.policy.Seedable`).
    name
        What the policy is called in the table.
    recorder
        Is shown every step, of the policy as it is given: `coopenv.agents.record.Recorder`, or
        a `Watcher` of your own.

    Returns
    -------
    Means with a 95 % interval of the success rate. A policy that can sample its actions
    (`coopenv.agents.policy.Samplable`) runs the episodes once more that way, for
    ``sampled_success_rate``; all other figures are of the policy as it is given.
    """
    config = config if config is not None else TransportConfig()
    chosen: dict[str, Any] = {"episodes": episodes, "seed": seed, "num_worlds": num_worlds}
    seen = run_episodes(policy, config, **chosen, recorder=recorder)
    other = policy.sampled() if isinstance(policy, Samplable) else None
    sampled = (
        run_episodes(other, config, **chosen) if other is not None and other is not policy else seen
    )
    return Evaluation.of(
        seen,
        dt=config.dt,
        policy=name,
        seed=seed,
        sampled=sampled if other is not None else None,
    )


def compare(
    policies: Mapping[str, Policy],
    config: TransportConfig | None = None,
    *,
    episodes: int = 500,
    seed: int = 0,
    num_worlds: int = 250,
) -> list[Evaluation]:
    """`evaluate` several policies by name on the same episodes."""
    return [
        evaluate(policy, config, episodes=episodes, seed=seed, num_worlds=num_worlds, name=name)
        for name, policy in policies.items()
    ]


def run_episodes(
    policy: Policy,
    config: TransportConfig,
    *,
    episodes: int = 500,
    seed: int = 0,
    num_worlds: int = 250,
    recorder: Watcher | None = None,
) -> Episodes:
    """Run exactly ``episodes`` held-out episodes; entry k is that of the k-th world seed.

    Every world of a batch runs one episode to its end. Counting the first ones that end, as an
    autoreset loop does, would favour short episodes.
    """
    if not isinstance(config, TransportConfig):
        raise InvalidInput(
            f"config must be a TransportConfig, got {config!r:.80}; that of an id is "
            "coopenv.agents.settings.EnvironmentChoice(env=id).config()"
        )
    episodes = whole(episodes, "episodes", at_least=1)
    seeds = evaluation_seeds(seed, episodes)
    core = Transport(num_worlds=min(num_worlds, episodes), config=config)
    check_environment(policy, core)
    batches = [
        _run_batch(policy, core, [*seeds[first : first + core.num_worlds]], recorder)
        for first in range(0, episodes, core.num_worlds)
    ]
    return Episodes.joined(batches)


def _run_batch(
    policy: Policy,
    core: Transport,
    seeds: list[int],
    recorder: Watcher | None,
) -> Episodes:
    """One episode of each seed; worlds beyond the last seed idle beside them."""
    count = len(seeds)
    filled = seeds + seeds[-1:] * (core.num_worlds - count)
    obs, _ = core.reset(seed=filled)
    forget(policy, np.ones(core.num_worlds, dtype=np.bool_), filled)
    sums = EpisodeSums(core.num_worlds, core.num_agents)
    running = np.arange(core.num_worlds) < count
    order, ended = [], []
    while running.any():
        assert core.transition is not None
        obs, reward, terminated, truncated, info = core.step(policy(obs, core.transition))
        sums.add(reward, info)
        if recorder is not None:
            recorder.add(core.transition, reward, info, running)
        over = terminated | truncated
        if not over.any():
            continue
        worlds = np.flatnonzero(over)
        first = running[worlds]  # the others have had their episode and only fill the batch
        ended.append(sums.take(worlds).pick(np.flatnonzero(first)))
        order.append(worlds[first])
        running &= ~over
        obs, _ = core.reset(mask=over)
        forget(policy, over)
    if recorder is not None:
        recorder.end(count)
    return Episodes.joined(ended).pick(np.argsort(np.concatenate(order)))
