"""Campaign of kills: commands that end at any moment, by SIGKILL and SIGTERM.

A trial starts a command in a folder, kills it after a random time, looks at the files, does so a
few times and then lets it end. Every file is what it was, or what it should be, at any time; what
was trained is not lost; the last run ends as one that nobody disturbed and leaves nothing else.
"""

import signal
import time
from pathlib import Path

import numpy as np

from benchmarks.soak.commands import cold, compiling, training
from benchmarks.soak.commands.scenes import (
    SCENES,
    TRAIN,
    Scene,
    check_files,
    files_in,
    is_left_over,
    undisturbed,
)
from benchmarks.soak.commands.server import Ended, Task, is_sentence, server

NAME = "kills"
SHARE = 0.3
KILLS = 4  # a trial
WAIT = 60.0  # [s] at most for its moment
SIGNALS = (signal.SIGKILL, signal.SIGTERM)
STOPPED = (128 + signal.SIGTERM, -signal.SIGTERM)  # exit codes of a command that was told to end
TRAINED, COMPILED, COLD = 0.4, 0.15, 0.02  # of the trials; a cold start takes long


def warm_up() -> None:
    """As commands on files do."""
    training.warm_up()


def trial(seed: int, folder: Path) -> dict[str, int]:
    """One command, killed a few times."""
    rng = np.random.default_rng([2, seed])
    kind, is_cold = rng.random(), rng.random() < COLD
    if is_cold:
        kills = _kill_cold_start(rng, folder)
    elif kind < COMPILED:
        kills = _kill_compiling(rng, folder)
    else:
        others = [scene for scene in SCENES if scene is not TRAIN]
        is_training = kind < COMPILED + TRAINED
        scene = TRAIN if is_training else others[rng.integers(len(others))]
        kills = _kill_command(scene, rng, folder)
    return {"kills": kills}


def _kill_command(scene: Scene, rng: np.random.Generator, folder: Path) -> int:
    old = scene.prepare(folder, rng)
    kills = steps = 0
    for _ in range(KILLS):
        before = left_over(folder)
        ended = killed(scene.task(folder), rng, undisturbed(scene).seconds)
        try:
            check_words(ended)
            check_files(scene, folder, old)
            if ended.code > 0:  # it cleaned up behind itself
                left = left_over(folder) - before  # a killed one's stay until that file is written
                assert not left, f"SIGTERM leaves {', '.join(left)}"
            if scene.is_training:
                steps = training.check_progress(folder, steps)
        except AssertionError as error:
            raise AssertionError(f"{error}\nafter {ended}") from error
        kills += ended.code != 0
    training.finish(scene, folder, f"{kills} kills")
    return kills


def _kill_compiling(rng: np.random.Generator, folder: Path) -> int:
    task = compiling.task(folder)
    kills = 0
    for _ in range(KILLS):
        ended = killed(task, rng, compiling.seconds())
        check_words(ended)
        kills += ended.code != 0
    compiling.check(server().run(task))
    compiling.check(server().run(task))  # from the cache alone
    return kills


def _kill_cold_start(rng: np.random.Generator, folder: Path) -> int:
    kills = sum(cold.kill(folder, rng) for _ in range(KILLS))
    cold.check(folder)
    cold.check(folder)  # from the cache alone
    return kills


def killed(task: Task, rng: np.random.Generator, seconds: float) -> Ended:
    """Start a command, and end it at a moment of the ``seconds`` of processor time it takes."""
    number = SIGNALS[rng.integers(len(SIGNALS))]
    delay = rng.uniform(0.0, seconds)
    child = server().start(task)
    latest = time.monotonic() + WAIT
    while child.seconds() < delay and time.monotonic() < latest:
        time.sleep(0.001)
    child.kill(number)
    return child.wait()


def check_words(ended: Ended) -> None:
    """Raise unless it ended well, by the signal, or as one that was told to end."""
    assert ended.code in (0, -signal.SIGKILL, *STOPPED), f"a kill ends it otherwise: {ended}"
    assert ended.code <= 0 or is_sentence(ended.err), f"a kill is told in many words: {ended}"
    assert "Traceback" not in ended.err, f"a kill shows a traceback: {ended}"


def left_over(folder: Path) -> set[str]:
    """Names of temporary files that are there."""
    return {name for name in files_in(folder) if is_left_over(name)}
