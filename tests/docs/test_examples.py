"""Every example runs as a user would run it, training with a tiny budget."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
ARGUMENTS = {
    "train_ppo.py": ["--total-steps", "2048"],
    "train_torchrl.py": ["--total-steps", "512", "--num-worlds", "8", "--rollout", "32",
                         "--epochs", "1", "--episodes", "2"],
}  # fmt: skip
NEEDS = {
    "decompose_recording.py": "pyarrow",
    "train_ppo.py": "stable_baselines3",
    "train_torchrl.py": "torchrl",
}


@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_the_example_runs_and_prints_something(name: str, tmp_path: Path):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    command = [sys.executable, str(EXAMPLES / name), *ARGUMENTS.get(name, [])]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


@pytest.mark.slow
def test_ppo_of_torchrl_learns_to_carry_the_beam(tmp_path: Path):
    pytest.importorskip("torchrl")
    command = [sys.executable, str(EXAMPLES / "train_torchrl.py"), "--seed", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[1]) > 0.8  # "success 0.95 in 200 other episodes"
