"""Processes and threads beside each other, and what each kind must come to.

    python -m benchmarks.soak.company fork 600 0    # kind, worlds, seed

The campaign of processes runs it in an interpreter of its own.
"""

import faulthandler
import multiprocessing
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from zlib import crc32

import gymnasium
import numpy as np

from benchmarks.soak.drawn.features import any_environment
from benchmarks.soak.drawn.pushes import any_actions
from coopenv import Transport, TransportConfig, wrench
from coopenv.errors import CoopenvError

STEPS, THREADS = 20, 4


def made(num_worlds: int, seed: int) -> Transport:
    """A core of that size with features drawn at random."""
    _, config, drawn = any_environment(np.random.default_rng([5, seed]), num_worlds)
    config = config if drawn == num_worlds else TransportConfig()  # bodies may be one a world
    return Transport(num_worlds=num_worlds, config=config)


def ridden(core: Transport, seed: int) -> int:
    """A checksum of some steps from a reset on."""
    core.reset(seed=seed)
    rng, check = np.random.default_rng(seed), 0
    restart = np.zeros(core.num_worlds, dtype=np.bool_)
    for action in any_actions(rng, core, STEPS):
        obs, reward, terminated, truncated, _ = core.step(action, restart=restart)
        check = crc32(reward.tobytes(), crc32(obs.tobytes(), check))
        restart = terminated | truncated
    return check


def in_child(core: Transport, seed: int) -> int:
    """The checksum that a forked child gets with its copy of the core."""
    context = multiprocessing.get_context("fork")
    reading, writing = context.Pipe(duplex=False)
    child = context.Process(target=lambda: writing.send(ridden(core, seed)))
    child.start()
    writing.close()
    found = reading.recv()  # EOFError where the child ended without a word
    child.join()
    return found


def fork(num_worlds: int, seed: int) -> None:
    """A forked child steps its copy of a core that was stepped before, as its parent does."""
    core = made(num_worlds, seed)
    wanted = ridden(core, seed)
    for _ in range(2):
        assert in_child(core, seed) == wanted, "a forked child steps differently"
    assert ridden(core, seed) == wanted, "the parent steps differently after a fork"


def pool(num_worlds: int, seed: int, method: str) -> None:
    """Cores that were not reset go to workers as pickles."""
    core = made(num_worlds, seed)
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(2, mp_context=context) as workers:
        found = list(workers.map(ridden, [core, core], [seed, seed + 1]))
    assert found == [ridden(core, seed), ridden(core, seed + 1)], f"{method} steps differently"


def spawn(num_worlds: int, seed: int) -> None:
    """Spawned workers."""
    pool(num_worlds, seed, "spawn")


def forkserver(num_worlds: int, seed: int) -> None:
    """Workers forked from a server."""
    pool(num_worlds, seed, "forkserver")


def gymnasium_workers(num_worlds: int, seed: int) -> None:
    """Gymnasium's own worker processes see what one process sees."""
    make = [lambda: gymnasium.make("coopenv/BeamDoorway-v0")] * 2
    several = gymnasium.vector.AsyncVectorEnv(make), gymnasium.vector.SyncVectorEnv(make)
    rng = np.random.default_rng(seed)
    seen = [envs.reset(seed=seed)[0] for envs in several]
    for _ in range(STEPS):
        assert np.array_equal(*seen), "a worker of Gymnasium's sees something else"
        action = rng.uniform(-1.0, 1.0, several[0].action_space.shape).astype(np.float32)
        seen = [envs.step(action)[0] for envs in several]
    for envs in several:
        envs.close()


def threads_apart(num_worlds: int, seed: int) -> None:
    """Threads with a core each get what they get one after another."""
    seeds = range(seed, seed + THREADS)
    wanted = [ridden(made(num_worlds, each), each) for each in seeds]
    cores = [made(num_worlds, each) for each in seeds]
    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(ridden, cores, seeds))
    assert found == wanted, "threads with cores of their own step differently"


def threads_together(num_worlds: int, seed: int) -> None:
    """Threads in one core take turns or get an error of ours, and the core is good afterwards."""
    core = made(num_worlds, seed)
    wanted = ridden(core, seed)

    def rush(which: int) -> None:
        for _ in range(3):
            try:
                ridden(core, seed + which)
            except CoopenvError:
                continue

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(rush, range(THREADS)))
    assert ridden(core, seed) == wanted, "a core steps differently after threads were in it"


def threads_decompose(num_worlds: int, seed: int) -> None:
    """Threads that decompose at the same time get what one gets."""
    rng = np.random.default_rng(seed)
    applied, grips = rng.normal(size=(THREADS, num_worlds, 3, 6)), rng.normal(size=(3, 3))
    wanted = [wrench.decompose(each, grips).internal for each in applied]
    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(lambda each: wrench.decompose(each, grips).internal, applied))
    assert np.array_equal(found, wanted), "threads decompose differently"


KINDS: dict[str, Callable[[int, int], None]] = {
    "fork": fork,
    "spawn": spawn,
    "forkserver": forkserver,
    "gymnasium-workers": gymnasium_workers,
    "threads-apart": threads_apart,
    "threads-together": threads_together,
    "threads-decompose": threads_decompose,
}


def main() -> None:
    """Run the kind that the command line names."""
    faulthandler.enable()
    kind, num_worlds, seed = sys.argv[1:]
    KINDS[kind](int(num_worlds), int(seed))


if __name__ == "__main__":
    main()
