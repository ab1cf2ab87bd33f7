"""What coopenv reads from files, each with a whole file and the function that reads it."""

import gzip
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from benchmarks.soak.commands.scenes import RUN, STEPS, TRAIN, input_of, undisturbed
from benchmarks.soak.commands.server import Task, is_sentence, server
from coopenv.agents.evaluate import evaluate
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.settings import TrainConfig
from coopenv.cli.evaluate import Evaluate
from coopenv.cli.train import Train
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.logs import Layout, decompose_file

BEAM = Layout(grips=(-0.9, 0.0, 0.9, 0.0))
SETTINGS = """\
steps = 300_000
hidden = [64, 64]
out = "runs/heavy"

[environment]
env = "coopenv/BeamDoorway-v0"
reward = "harmony"
observe = ["goal", "twist", "own_wrench"]
body = { mass = 12.0, grips = [[-0.9, 0.0], [0.9, 0.0]] }
task = { position_tolerance = 0.05 }

[environment.weights]
progress = 5.0

[evaluation]
episodes = 200
"""
LAYOUT = """\
grips = [[-0.9, 0.0], [0.9, 0.0]]
frame = "world"
force = "kN"
angle = "deg"
trial_columns = ["pair"]

[columns]
f1x = "Fx_left"
f1y = "-Fy_left"
time = "t"
"""
LAYOUT_JSON = (
    '{"grips": [-0.9, 0.0, 0.9, 0.0], "y": "down", "columns": {"f1x": "-Fx", "time": ""}}\n'
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """A kind of file."""

    name: str
    file: str
    """What it is called; its suffix says the format."""
    whole: Callable[[], bytes]
    read: Callable[[Path], object]
    """Raises one of coopenv's errors, or reads all of it."""


def decompose(path: Path) -> None:
    """A recording, to a table."""
    out = path.with_name(f"out{path.suffix if path.suffix in ('.npz', '.parquet') else '.csv'}")
    decompose_file(path, out, layout=BEAM, picture=False)


def as_matlab() -> bytes:
    """The recording as a MATLAB file, compressed."""
    with np.load(io.BytesIO(input_of("a.npz"))) as arrays:
        columns = {name: values for name, values in arrays.items() if values.dtype.kind == "f"}
    file = io.BytesIO()
    savemat(file, columns, do_compression=True)
    return file.getvalue()


def act(path: Path) -> None:
    """A policy, for two short episodes."""
    policy = SB3Policy.load(path)
    config = environment()
    evaluate(policy, config, episodes=2, num_worlds=2)


@cache
def environment() -> TransportConfig:
    """That of the training."""
    return TrainConfig.from_dict(_settings()).environment.config()


def _settings() -> dict[str, Any]:
    given = json.loads(_of_run("config.json"))
    given.pop("provenance")
    return given


def go_on(path: Path) -> None:
    """A training that finds the file in its folder."""
    run = path.parent / RUN
    run.mkdir()
    path.rename(run / path.name)
    words = TRAIN.words.replace(f"--steps {STEPS}", f"--steps {STEPS + 80}").split()
    said(Task(folder=str(path.parent), arguments=(*words, "--no-gif")))


def said(task: Task) -> None:
    """Run a command that succeeds, or raise `InvalidInput` with its one sentence."""
    ended = server().run(task)
    if ended.code:
        assert ended.code == 1, str(ended)
        assert is_sentence(ended.err), str(ended)
        raise InvalidInput(ended.err.rstrip())


def evaluate_file(path: Path) -> None:
    """A policy on the command line."""
    words = ("evaluate", path.name, "--episodes", "2", "--num-worlds", "2")
    said(Task(folder=str(path.parent), arguments=words))


def _of_run(name: str) -> bytes:
    return undisturbed(TRAIN).files[f"{RUN}/{name}"]


READERS = (
    *(
        Reader(
            name="recordings",
            file=name,
            whole=lambda name=name: input_of(name),
            read=decompose,
        )
        for name in ("a.csv", "a.npz", "a.parquet")
    ),
    Reader(
        name="recordings",
        file="a.csv.gz",
        whole=lambda: gzip.compress(input_of("a.csv"), mtime=0),
        read=decompose,
    ),
    Reader(name="recordings", file="a.mat", whole=as_matlab, read=decompose),
    Reader(name="layouts", file="a.toml", whole=LAYOUT.encode, read=Layout.load),
    Reader(name="layouts", file="a.json", whole=LAYOUT_JSON.encode, read=Layout.load),
    Reader(name="settings", file="a.toml", whole=SETTINGS.encode, read=Train.configured),
    Reader(name="settings", file="a.toml", whole=SETTINGS.encode, read=Evaluate.configured),
    Reader(
        name="settings",
        file="config.json",
        whole=lambda: _of_run("config.json"),
        read=Train.configured,
    ),
    Reader(
        name="settings",
        file="config.json",
        whole=lambda: _of_run("config.json"),
        read=TrainConfig.load,
    ),
    Reader(
        name="environments",
        file="environment.json",
        whole=lambda: environment().to_json().encode(),
        read=lambda path: TransportConfig.from_json(path.read_text(errors="surrogateescape")),
    ),
    Reader(name="policies", file="policy.zip", whole=lambda: _of_run("policy.zip"), read=act),
    Reader(
        name="policies", file="policy.zip", whole=lambda: _of_run("policy.zip"), read=evaluate_file
    ),
    Reader(name="runs", file="policy.zip", whole=lambda: _of_run("policy.zip"), read=go_on),
    Reader(name="runs", file="checkpoint.zip", whole=lambda: _of_run("policy.zip"), read=go_on),
)
