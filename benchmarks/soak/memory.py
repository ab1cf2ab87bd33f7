"""Campaign of memory: episodes and lives of every view leave nothing behind.

A trial makes one view of an environment with features drawn at random, repeats something with it,
and counts objects and resident bytes before, halfway and after. What grows more slowly than a trial
can see is left to the watch over the workers.
"""

import gc
import itertools
from functools import _lru_cache_wrapper
from pathlib import Path

import numpy as np

import coopenv
from benchmarks.soak.drawn.features import any_environment
from benchmarks.soak.drawn.views import VIEWS, Repeat
from benchmarks.soak.frame.worker import size_of_process
from coopenv.envs.registry import find_config

NAME = "memory"
SHARE = 0.15
WARM, REPEATS, LIVES = 100, 400, 40  # episodes to begin with and then; views made and closed
FEWER = 0.1  # objects a repeat that a cache may take; a leak takes at least one
BYTES = 4 * 2**20  # by which half of it may grow: what is free comes back in large pieces only
DESCRIPTORS = 0
ENV = "coopenv/BeamTransport-v0"  # of the warm-up


def warm_up() -> None:
    """Use every view once: some import torch, Stable-Baselines3 or pygame when they are made."""
    for make in VIEWS.values():
        episode, close = make(ENV, find_config(ENV, {}), 2, 0)
        episode()
        close()


def trial(seed: int, folder: Path) -> dict[str, int]:
    """Episodes of one view, or views made, used and closed."""
    rng = np.random.default_rng([3, seed])
    env, config, num_worlds = any_environment(rng, most_worlds=8)
    name = str(rng.choice(list(VIEWS)))
    place = f"{name} of {env}"
    make = VIEWS[name]
    if rng.random() < 0.3:

        def live() -> None:
            episode, close = make(env, config, num_worlds, seed)
            episode()
            close()

        check_flat(live, LIVES // 4, LIVES, f"{place}, made and closed")
        return {"lives": LIVES + LIVES // 4}
    episode, close = make(env, config, num_worlds, seed)
    check_flat(episode, WARM, REPEATS, f"{place}, reset and stepped")
    close()
    return {"resets": (WARM + REPEATS) * num_worlds}


def check_flat(repeat: Repeat, warm: int, times: int, place: str) -> None:
    """Raise if ``times`` repeats, after ``warm`` ones, leave something behind in both halves.

    A leak grows in both alike. Pools and caches fill, be it late, and then grow no more: pymunk
    keeps as many shapes and contacts as there ever were at once.
    """
    for _ in range(warm):
        repeat()
    half, sizes = times // 2, [_held()]
    for _ in range(2):
        for _ in range(half):
            repeat()
        sizes.append(_held())
    steps = [np.subtract(now, then) for then, now in itertools.pairwise(sizes)]
    more, grown, opened = np.minimum(*steps).tolist()
    said = f"in each half of {2 * half} times"
    assert more <= FEWER * half, f"{place}: {more} objects more {said}"
    assert grown <= BYTES, f"{place}: {grown / 2**20:.1f} MB more {said}"
    assert opened <= DESCRIPTORS, f"{place}: {opened} descriptors more {said}"


def _held() -> tuple[int, int, int]:
    """Objects, resident bytes and descriptors; what a bounded cache still holds is not counted."""
    for cache in [one for one in gc.get_objects() if type(one) is _lru_cache_wrapper]:
        ours = str(cache.__module__).partition(".")[0] == coopenv.__name__
        if ours and cache.cache_parameters()["maxsize"] is not None:
            cache.cache_clear()
    size = size_of_process()
    return live_objects(), size.resident, size.descriptors


def live_objects() -> int:
    """Objects that Python's collector knows."""
    return len(gc.get_objects())
