"""Experiments whose cells take milliseconds, and how to run them in this process."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from coopenv.agents.experiments import Experiment
from coopenv.agents.experiments.report import pictures
from coopenv.agents.experiments.work import work
from coopenv.errors import CoopenvError

TEXT = """
[experiment]
name = "tiny"
seeds = 2
episodes = 3

[environment]
horizon = 60
task = { position_tolerance = 0.3 }

[training]
steps = 128
num_worlds = 4
rollout = 8
batch_size = 16
epochs = 1
hidden = [8]

[grid]
algorithm = ["scripted", "random"]

[grid.reward]
none = "task"
squeeze.terms.squeeze = { kind = "InternalForce", settings = { method = "moore_penrose" } }

[grid.reward.share]
preset = "harmony"
weights = { relative_cost = 0.5 }

[grid.reward.share.terms.share]
kind = "LoadShare"
wanted = [0.8, 0.2]

[[exclude]]
algorithm = "scripted"
reward = "squeeze"
"""

ENVIRONMENT = {"horizon": 60, "task": {"position_tolerance": 0.3}}
TRAINING = {"steps": 128, "num_worlds": 4, "rollout": 8, "batch_size": 16, "epochs": 1}


def small(out: Path, **changes: Any) -> Experiment:
    """Two settings of two seeds; nothing learns."""
    given = {"grid": {"algorithm": ["scripted", "random"]}, "seeds": 2, "episodes": 3}
    return Experiment(
        **{**given, "environment": ENVIRONMENT, "training": TRAINING, **changes}, out=out
    )


def here(folder: Path, report: Callable[[dict[str, Any]], None]) -> str | None:
    """Work on a cell in this process, as one of its own would."""
    try:
        work(folder, report)
    except CoopenvError as error:
        return str(error)
    return None


@contextmanager
def no_pictures() -> Iterator[None]:
    """Reports without pictures, which take most of their time."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("intervals", "profiles", "curves", "pareto"):
            patch.setattr(pictures, f"draw_{name}", lambda *given: None)
        yield


def files(out: Path) -> dict[str, bytes]:
    """What the report's files hold."""
    return {path.name: path.read_bytes() for path in (out / "report").iterdir()}
