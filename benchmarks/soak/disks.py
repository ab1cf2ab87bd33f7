"""Campaign of disks that fail: the n-th call that opens, writes or renames a file is refused.

A trial runs a command in a folder where things lie from before, lets one call fail, and looks: the
command says so in one sentence, old files are what they were, nothing is half written or left
over, and the next run ends as one that nobody disturbed.
"""

from pathlib import Path

import numpy as np

from benchmarks.soak.commands import training
from benchmarks.soak.commands.faults import ERRORS, KINDS
from benchmarks.soak.commands.scenes import (
    OLD,
    SCENES,
    TRAIN,
    Scene,
    check_files,
    files_in,
    is_left_over,
    undisturbed,
)
from benchmarks.soak.commands.server import Ended, is_sentence

NAME = "disks"
SHARE = 0.12
FAULTS = 3  # a trial
CALLS = {"open": 12, "write": 6, "fsync": 12, "rename": 6, "mkdir": 3}  # about so many in a command
TRAINED = 4  # times as many in a training
SIZES = 3.3, 5.3  # powers of ten between which the largest file lies [byte]; below, words are cut


def warm_up() -> None:
    """As commands on files do."""
    training.warm_up()


def trial(seed: int, folder: Path) -> dict[str, int]:
    """One command on a disk that fails a few times, and then no more."""
    rng = np.random.default_rng([3, seed])
    scene = TRAIN if rng.random() < 0.3 else SCENES[rng.integers(len(SCENES))]
    old = scene.prepare(folder, rng)
    failures = steps = 0
    for _ in range(FAULTS):
        fault = _fault(rng, TRAINED if scene.is_training else 1)
        ended = scene.run(folder, fault)
        try:
            failures += _check(scene, folder, old, ended)
            if scene.is_training:
                steps = training.check_progress(folder, steps)
        except AssertionError as error:
            raise AssertionError(f"{error}\n{fault}: {ended}") from error
    training.finish(scene, folder, f"{failures} failures")
    return {"failed_writes": failures}


def _fault(rng: np.random.Generator, times: int) -> tuple[str, int, int]:
    kind = str(rng.choice(KINDS))
    error = int(rng.choice(ERRORS))
    if kind == "size":
        return kind, int(10 ** rng.uniform(*SIZES)), error
    return kind, int(rng.integers(times * CALLS[kind])), error


def _check(scene: Scene, folder: Path, old: dict[str, bytes], ended: Ended) -> bool:
    """Whether something failed; raise where it was not said, or something is torn or left."""
    check_files(scene, folder, old)
    left = [name for name in files_in(folder) if is_left_over(name)]
    assert not left, f"a failure leaves {', '.join(left)}"
    if ended.code:
        assert ended.code == 1, f"a failure has exit code {ended.code}"
        assert is_sentence(ended.err), "a failure is no sentence"
    else:
        assert not ended.err, "something was said, and the exit code is 0"
        found = files_in(folder)
        missing = [name for name in undisturbed(scene).files if name not in found]
        assert not missing, f"{', '.join(missing)} is missing, and the exit code is 0"
        torn = [name for name in old if found[name] == OLD]
        assert not torn, f"{', '.join(torn)} is as before, and the exit code is 0"
    return ended.struck or ended.code != 0
