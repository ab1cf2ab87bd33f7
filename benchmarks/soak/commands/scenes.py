"""Scenes: small commands, the files that they read and write, and what the whole run leaves."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.soak.commands.server import Ended, Task, server
from benchmarks.soak.commands.whole import require_whole
from coopenv.logs.formats import open_sink

ROWS = 3000  # of a recording
RUN = "run"  # folder of the training
PICTURES = (".gif", ".pdf", ".png")  # they need not have the same bits every time
SETTINGS = "--num-worlds 4 --rollout 20 --batch-size 40 --hidden 8 --epochs 1 --horizon 20"
OLD = b"what was there before\n"
STEPS = 80 * 12  # of the training: so many updates of 80


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A command in a folder of its own."""

    name: str
    words: str
    """Of the command line."""
    inputs: tuple[str, ...] = ()
    """Files that it reads; see `input_of`."""

    @property
    def is_training(self) -> bool:
        """Whether it leaves something from which the next run goes on."""
        return self.name == "train"

    def task(self, folder: Path, fault: tuple[str, int, int] | None = None) -> Task:
        """What the server is asked for."""
        return Task(folder=str(folder), arguments=tuple(self.words.split()), fault=fault)

    def run(self, folder: Path, fault: tuple[str, int, int] | None = None) -> Ended:
        """Run it to its end."""
        return server().run(self.task(folder, fault))

    def prepare(self, folder: Path, rng: np.random.Generator | None = None) -> dict[str, bytes]:
        """Write what it reads and, with ``rng``, some files that it will replace; all of them."""
        old = {name: input_of(name) for name in self.inputs}
        if rng is not None and not self.is_training:  # which takes a foreign file for another run
            names = [name for name in undisturbed(self).files if name not in old]
            old |= {name: OLD for name in names if rng.random() < 0.5}
        for name, content in old.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
        return old


GRIPS = "--grips -0.9 0 0.9 0"
TRAIN = Scene(
    name="train",
    words=f"train --out {RUN} --steps {STEPS} {SETTINGS} --checkpoint-every 1 --episodes 4",
)
SCENES = (
    TRAIN,
    Scene(name="decompose", words=f"decompose a.csv {GRIPS}", inputs=("a.csv",)),
    Scene(
        name="decompose",
        words=f"decompose a.npz {GRIPS} --no-picture --method moore_penrose",
        inputs=("a.npz",),
    ),
    Scene(
        name="decompose", words=f"decompose a.parquet {GRIPS} --no-picture", inputs=("a.parquet",)
    ),
    Scene(
        name="evaluate",
        words="evaluate random scripted --horizon 20 --episodes 6 --out table.csv",
    ),
    Scene(
        name="evaluate",
        words="evaluate policy.zip random --episodes 6 --out table.json",
        inputs=("policy.zip",),
    ),
    Scene(name="study", words="study walker-turn --out turn"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Whole:
    """What a command leaves that nobody disturbs."""

    files: dict[str, bytes]
    seconds: float
    """Of processor time."""


@cache
def undisturbed(scene: Scene) -> Whole:
    """Run a scene to its end once."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene.prepare(folder)
        ended = scene.run(folder)
        assert ended.code == 0, f"an undisturbed run failed: {ended}"
        return Whole(files=files_in(folder), seconds=ended.seconds)


def input_of(name: str) -> bytes:
    """A file that commands read: a recording, one a format, or a policy."""
    if name == "policy.zip":
        return undisturbed(TRAIN).files[f"{RUN}/policy.zip"]
    return _recording(name)


@cache
def _recording(name: str) -> bytes:
    """Random wrenches and motion, in the format that the name says."""
    rng = np.random.default_rng(0)
    columns = {"time": np.arange(ROWS) * 0.01}
    for each in ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z", "x", "y", "theta", "vx", "vy", "omega"):
        columns[each] = rng.normal(size=ROWS)
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        sink = open_sink(path)
        sink.write(columns)
        sink.close()
        return path.read_bytes()


def files_in(folder: Path) -> dict[str, bytes]:
    """Name → content of all files below a folder, but TensorBoard's logs."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in paths
        if "tensorboard" not in path.parts
    }


def is_left_over(name: str) -> bool:
    """Whether a file is there for the time of a command: under a temporary name, or a lock."""
    return Path(name).name.startswith(".")


def check_files(scene: Scene, folder: Path, old: dict[str, bytes]) -> None:
    """Raise unless each file is what it was, or what the undisturbed command writes, or whole.

    Files with temporary names are left out; what was there may not be missing.
    """
    wanted, found = undisturbed(scene).files, files_in(folder)
    missing = [name for name in old if name not in found]
    assert not missing, f"{', '.join(missing)} was there and is lost"
    for name, content in found.items():
        if is_left_over(name) or content == old.get(name):
            continue
        assert name in wanted or scene.is_training, f"{name} is no file that the command writes"
        if scene.is_training or Path(name).suffix in PICTURES:
            require_whole(folder / name)
        else:
            assert content == wanted[name], f"{name} is neither what it was nor what it should be"


def check_end(scene: Scene, folder: Path) -> None:
    """Raise unless the folder holds what the undisturbed command leaves, and nothing else."""
    wanted, found = undisturbed(scene).files, files_in(folder)
    check_files(scene, folder, {})
    left = sorted(set(found) - set(wanted))
    assert not left, f"the next run leaves {', '.join(left)}"
    missing = sorted(set(wanted) - set(found))
    assert not missing, f"the next run does not write {', '.join(missing)}"
