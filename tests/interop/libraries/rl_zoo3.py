"""RL Zoo: ``rl_zoo3 train`` and ``enjoy``, whose evaluations say how often the team succeeds."""

import csv
import io
import json
import os
import re
import sys
from collections.abc import Callable
from contextlib import chdir, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import rl_zoo3
from rl_zoo3.enjoy import enjoy
from rl_zoo3.train import train

IDS = ["coopenv/BeamTransport-v0", "coopenv/BeamDoorway-v0"]
SETTINGS = """\
{view}:
  n_timesteps: 512
  n_envs: 2
  policy: MlpPolicy
  n_steps: 64
  batch_size: 64
  n_epochs: 2
  normalize: true
  env_kwargs: {{horizon: 20}}
  monitor_kwargs: "dict(info_keywords=('is_success',))"
"""


def main() -> None:
    """Run all of it, and print one line of JSON."""
    for view in IDS:
        with TemporaryDirectory() as folder, chdir(folder):
            train_and_enjoy(view)
    checked = (
        "train with VecNormalize, then enjoy: both tell a success rate, evaluations.npz and "
        "monitor.csv, asked for is_success, one of every episode"
    )
    version = rl_zoo3.__version__
    told = {"library": "RL Zoo", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def train_and_enjoy(view: str) -> None:
    """As a user types it, in an empty folder."""
    Path("settings.yml").write_text(SETTINGS.format(view=view))
    named = ["--algo", "ppo", "--env", view, "--gym-packages", "coopenv", "-f", "logs"]
    seeded = ["--seed", "0", "--num-threads", "1", "--device", "cpu"]
    run(train, *named, *seeded, "--conf-file", "settings.yml", "--eval-freq", "256")
    (evaluations,) = Path("logs").rglob("evaluations.npz")
    with np.load(evaluations) as told:
        assert told["successes"].shape == told["results"].shape == (2, 5)
        assert set(np.unique(told["successes"])) <= {False, True}
    (monitor,) = Path("logs").rglob("0.monitor.csv")
    with monitor.open() as lines:
        next(lines)  # a header of JSON
        rows = list(csv.DictReader(lines))
    assert len(rows) >= 512 // 20 // 2
    assert {row["is_success"] for row in rows} <= {"False", "True"}
    said = run(enjoy, *named, *seeded, "--no-render", "-n", "100")
    rate = re.search(r"Success rate: ([\d.]+)%", said)
    assert rate, said
    assert 0 <= float(rate[1]) <= 100


def run(command: Callable[[], None], *words: str) -> str:
    """What ``python -m rl_zoo3.COMMAND WORDS`` prints."""
    kept, sys.argv = sys.argv, [command.__name__, *words]
    said = io.StringIO()
    try:
        with redirect_stdout(said):
            command()
    finally:
        sys.argv = kept
    return said.getvalue()


if __name__ == "__main__":
    os.environ["SDL_VIDEODRIVER"] = "dummy"
    main()
