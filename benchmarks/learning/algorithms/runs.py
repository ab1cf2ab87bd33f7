"""Trainings of one algorithm or another, their tests on held-out episodes, and their files."""

import json
import time
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from benchmarks.learning.algorithms.environment import environment_of
from benchmarks.learning.algorithms.policies import file_of, keep
from benchmarks.learning.baselines import EPISODES, LEVELS, reached
from benchmarks.learning.run import Outcome
from benchmarks.pages import DOCS
from coopenv.agents.evaluate import evaluate
from coopenv.agents.training.threads import torch_threads
from coopenv.files import written

FOLDER = DOCS / "training" / "algorithms"
Name = Literal["sac", "mappo", "recurrent"]  # modules beside this one
NAMES: tuple[Name, ...] = ("sac", "mappo", "recurrent")


@dataclass(frozen=True, kw_only=True)
class Run(Outcome):
    """A training, whose settings are of the algorithm's module."""

    algorithm: Name
    action: str | None = None  # None: as the environment has it

    @property
    def task(self) -> str:
        """Environment and action, as names of files have them."""
        return task_of(self.env, self.action)

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it: an action is told where there is one."""
        given = asdict(self)
        return given if self.action else {k: v for k, v in given.items() if k != "action"}


def task_of(env: str, action: str | None) -> str:
    """BeamLift, or BeamLift_motion where agents give something else than the environment has."""
    return "_".join(filter(None, (env, action)))


def settings_of(name: Name, env: str, action: str | None = None) -> dict[str, Any]:
    """Those of today, as JSON brings them back."""
    module = import_module(f"{__package__}.{name}")
    return json.loads(json.dumps(module.settings(env, action)))


def learn(
    name: Name, env: str, seed: int, action: str | None = None, *, kept: Path | None = None
) -> Run:
    """Train and evaluate; keep the policy in a folder, if any."""
    module, settings = import_module(f"{__package__}.{name}"), settings_of(name, env, action)
    environment = environment_of(env, action)
    with torch_threads(1):
        began = time.process_time()
        policy, curve = module.learn(env, seed, settings, action)
        seconds = time.process_time() - began
        if kept is not None:
            path = file_of(kept, name, task_of(env, action), seed)
            keep(policy, path, environment, seed=seed, steps=curve.steps)
        seen = evaluate(policy, environment, episodes=EPISODES)
    whole = curve.num_worlds * environment.horizon  # control steps of one episode of each world
    assert seen.sampled_success_rate is not None
    return Run(
        algorithm=name,
        env=env,
        action=action,
        seed=seed,
        settings=settings,
        steps=curve.steps,
        seconds=round(seconds, 1),
        reached=tuple(reached(curve.points, level, whole) for level in LEVELS),
        success=seen.success_rate,
        sampled=seen.sampled_success_rate,
        time=round(seen.success_time, 2) if seen.success_rate else None,
        relative_cost=round(seen.relative_cost, 4),
    )


def saved(name: Name | None = None, task: str = "*") -> list[Run]:
    """What was run so far, of one algorithm and `Run.task` or of all."""
    given = [
        each
        for algorithm in (NAMES if name is None else (name,))
        for file in sorted(FOLDER.glob(f"{algorithm}/{task}.json"))
        for each in json.loads(file.read_text(encoding="utf-8"))
    ]
    return [Run(**{**each, "reached": tuple(each["reached"])}) for each in given]


def save(run: Run) -> None:
    """Write a run among those of its algorithm and environment, one a line."""
    others = (other for other in saved(run.algorithm, run.task) if other.seed != run.seed)
    runs = sorted([run, *others], key=lambda one: one.seed)
    lines = ",\n".join(json.dumps(one.to_dict()) for one in runs)
    with written(FOLDER / run.algorithm / f"{run.task}.json") as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")
