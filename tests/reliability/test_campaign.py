"""The campaigns of the soak test in short, and its runner: kills, faults, tables."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

import tyro
from rich.console import Console

from benchmarks.soak import actions, command, memory
from benchmarks.soak.campaigns import CAMPAIGNS, chosen
from benchmarks.soak.frame.ledger import FILE, Ledger, Shift, Trial
from benchmarks.soak.frame.report import reproduction, table
from benchmarks.soak.frame.runner import FEWEST_READINGS, growth
from benchmarks.soak.frame.worker import Size, attempt
from coopenv.errors import InvalidInput, UnknownName
from tests.docs.snippets import ROOT
from tests.reliability import planted

SEEDS = {  # a few of each, that take a second or so
    "actions": (3, 4, 9),
    "wrenches": (0, 1, 4),
    "memory": (0, 3),
    "processes": (9, 10),
}
CASES = [(each, seed) for each in CAMPAIGNS for seed in SEEDS.get(each.NAME, ())]
ALSO = ("--also", "tests.reliability.planted", "--only", "planted")


@pytest.mark.parametrize(
    ("campaign", "seed"), CASES, ids=[f"{each.NAME}-{seed}" for each, seed in CASES]
)
def test_a_trial_of_every_campaign_breaks_nothing(campaign, seed, tmp_path, monkeypatch):
    monkeypatch.setattr(actions, "WORLD_STEPS", 10_000)
    monkeypatch.setattr(actions, "EPISODES", 100)
    monkeypatch.setattr(memory, "WARM", 50)
    monkeypatch.setattr(memory, "REPEATS", 120)
    outcome = attempt(campaign, seed, tmp_path / "trial")
    assert outcome.failure is None, outcome.trace
    assert sum(outcome.counts.values()) > 0
    assert not list(tmp_path.iterdir())


def test_campaigns_have_names_and_shares_of_their_own():
    assert len({each.NAME for each in CAMPAIGNS}) == len(CAMPAIGNS)
    assert all(each.SHARE > 0 for each in CAMPAIGNS)
    assert [each.NAME for each in chosen("wrenches")] == ["wrenches"]
    with pytest.raises(UnknownName, match="did you mean 'actions'"):
        chosen("action")


def start(folder: Path, *options: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "benchmarks.soak", *ALSO, "--out", str(folder), *options]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "200"}
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment,
    )


def run_here(folder: Path, *options: str) -> tuple[int, str]:
    """What the command returns and prints, in this process; its workers have their own."""
    told = io.StringIO()
    soak = tyro.cli(command.Soak, args=[*ALSO, "--out", str(folder), *options])
    return command.run(soak, Console(file=told, width=200)), told.getvalue()


def seeds(folder: Path) -> list[int]:
    """Of the trials that are written down."""
    file = folder / FILE
    lines = file.read_text().splitlines() if file.exists() else []
    return [json.loads(line)["seed"] for line in lines if '"counts"' in line]


def test_planted_faults_are_told_with_how_to_meet_them_again(tmp_path):
    run = start(tmp_path, "--trials", "12", "--workers", "1")
    out, err = run.communicate(timeout=300)
    assert run.returncode == 1, err
    assert "Traceback" not in out + err
    found = dict(re.findall(r"FAILED planted, seed (\d+)\n((?:  .*\n)+)", out))
    wanted = (planted.WRONG, planted.CRASHES, planted.HANGS, planted.EXITS)
    assert [int(seed) for seed in found] == list(wanted)
    for seed, told in found.items():
        assert told.count("\n") < 10
        again = (
            "python -m benchmarks.soak --only planted --seed {} --also tests.reliability.planted"
        )
        assert again.format(seed) in told
    wrong, crashed, hung, left = (found[str(seed)] for seed in wanted)
    assert "world 3 left its room" in wrong
    assert "SIGSEGV" in crashed
    assert "string_at" in crashed
    assert "no end within 3 s" in hung
    assert "planted.py" in hung
    assert "code 7" in left
    assert seeds(tmp_path) == list(range(12))
    assert "noise" not in out
    assert "| planted | 12 | 4 | 8 steps |" in out


def test_a_killed_run_goes_on_where_it_was(tmp_path):
    options = ("--first-seed", "100", "--workers", "1", "--trials", "12")
    run = start(tmp_path, *options)
    until(lambda: len(seeds(tmp_path)) >= 3, run)
    run.send_signal(signal.SIGKILL)
    run.communicate()
    with (tmp_path / FILE).open("a") as file:
        file.write('{"campaign": "planted", "se')  # a line that the kill has cut
    before = (tmp_path / FILE).read_text().rpartition("\n")[0]
    code, out = run_here(tmp_path, *options)
    assert code == 0, out
    after = (tmp_path / FILE).read_text()
    assert after.startswith(before + "\n")
    assert seeds(tmp_path) == list(range(100, 112))
    clocks = [json.loads(line).get("at", 0.0) for line in after.splitlines()]
    assert clocks == sorted(clocks)  # of both runs together
    assert not (tmp_path / "trials").exists()


def test_what_failed_is_tried_again_once_it_is_mended_and_stays_in_the_table(tmp_path, monkeypatch):
    options = ("--first-seed", str(planted.WRONG), "--trials", "2", "--workers", "1")
    assert "| planted | 2 | 1 | 1 steps |" in run_here(tmp_path, *options)[1]
    monkeypatch.setenv("PLANTED_MENDED", "1")
    assert "| planted | 2 | 1 | 1 steps |" in run_here(tmp_path, *options)[1]
    code, out = run_here(tmp_path, *options, "--again")
    assert code == 0, out
    assert "| planted | 3 | 0 (1 mended) | 2 steps |" in out


def until(holds, run: subprocess.Popen[str]) -> None:
    """Wait until it holds, while the process runs."""
    while not holds():
        assert run.poll() is None, run.communicate()
        time.sleep(0.1)


def test_one_trial_shows_its_traceback(tmp_path):
    code, out = run_here(tmp_path, "--seed", str(planted.WRONG))
    assert code == 1
    assert "in trial" in out
    assert not list(tmp_path.iterdir())


def test_a_stopped_run_leaves_nobody_behind_and_says_how_to_go_on(tmp_path):
    run = start(tmp_path, "--first-seed", "100")
    until(lambda: len(seeds(tmp_path)) >= 1, run)
    run.terminate()
    out, err = run.communicate(timeout=60)
    assert run.returncode == 130, err
    assert "the same command goes on" in out
    assert not (tmp_path / "trials").exists()


def test_a_folder_in_use_or_of_another_machine_is_refused(tmp_path):
    ledger = Ledger(tmp_path, {"cores": "2"})
    with pytest.raises(InvalidInput, match="out must be a folder that nobody else runs in"):
        Ledger(tmp_path, {"cores": "2"})
    ledger.close()
    with pytest.raises(InvalidInput, match=r"out must be of the same cores, got .* of 2;"):
        Ledger(tmp_path, {"cores": "4"})
    Ledger(tmp_path, {"cores": "2"}).close()
    assert Ledger(tmp_path, {"cores": "4"}, fresh=True).machine == {"cores": "4"}


def test_growth_is_told_after_warm_up_and_forgives_what_comes_and_goes():
    flat = [Size(100 + 50 * (k % 3), 7) for k in range(40)]
    warm = [Size(10 * k, k) for k in range(10)] + flat[10:]
    leak = [Size(100 + 2 * k, 7 + k // 4) for k in range(40)]
    assert growth(flat) == growth(warm) == (0, 0)
    assert growth(leak) == (40, 5)
    assert growth(leak[: FEWEST_READINGS - 1]) is None


def test_the_table_adds_up_what_was_tried(tmp_path):
    ledger = Ledger(tmp_path, {"system": "Linux", "cores": "2"})
    for seed in range(3):
        wrong = "off" if seed == 2 else None
        counts = {} if wrong else {"steps": 1000, "bad_files": 1}
        ledger.add(
            Trial(campaign="planted", seed=seed, at=60.0, seconds=20, counts=counts, failure=wrong)
        )
    shift = {"campaign": "planted", "seed": 0, "at": 90.0, "seconds": 90.0}
    ledger.add(Shift(**shift, grown_bytes=3 * 2**20, grown_descriptors=0))
    ledger.add(Trial(campaign="planted", seed=0, at=90.0, failure="grew", is_shift=True))
    ledger.close()
    ledger = Ledger(tmp_path, ledger.machine)
    made = table(ledger, [planted])
    ledger.close()
    assert made.startswith("2 minutes by the clock. System Linux, cores 2.\n")
    row = "| planted | 3 | 2 | 2,000 steps, 2 bad files | 1.0 | 3.0 MB, 0 descriptors |"
    assert made.endswith(row)
    told = reproduction(ledger.failures[1])
    assert told.endswith("--only planted --first-seed 0 --minutes 1 --workers 1")


def test_options_that_make_no_sense_are_refused():
    from benchmarks.soak.command import Soak

    with pytest.raises(InvalidInput, match="seed must come with the campaign"):
        Soak(seed=3)
    with pytest.raises(InvalidInput, match="write must be for all campaigns"):
        Soak(only="actions", write=True)
    with pytest.raises(InvalidInput, match="minutes must be positive"):
        Soak(minutes=0.0)


def test_the_campaign_of_memory_tells_a_leak_and_forgives_a_pool_that_fills_late():
    kept: list[object] = []
    with pytest.raises(AssertionError, match=r"one a reset: \d+ objects more in each half of 100"):
        memory.check_flat(lambda: kept.append([]), 10, 100, "one a reset")
    files: list[int] = []
    try:
        with pytest.raises(AssertionError, match="descriptors more"):
            memory.check_flat(lambda: files.append(os.dup(0)), 5, 20, "a file a reset")
    finally:
        for file in files:
            os.close(file)
    chunks: list[bytearray] = []
    with pytest.raises(AssertionError, match="MB more"):
        memory.check_flat(lambda: chunks.append(bytearray(b"x" * 2**20)), 5, 20, "a MB a reset")
    pool: list[object] = []
    memory.check_flat(lambda: pool.append([]) if len(pool) < 55 else None, 10, 100, "a pool")
