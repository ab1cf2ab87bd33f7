"""Report of a soak test: the machine, the table by campaign, and how to meet a failure again."""

import os
import platform
from collections.abc import Iterable, Sequence
from importlib.metadata import version

from benchmarks.pages import markdown
from benchmarks.soak.frame.campaign import Campaign
from benchmarks.soak.frame.ledger import Ledger, Shift, Trial, totals

PACKAGES = ("coopenv", "numpy", "numba", "pymunk", "gymnasium", "stable-baselines3", "torch")
COLUMNS = (
    "campaign",
    "trials",
    "failed",
    "what was tried",
    "worker minutes",
    "most that grew",
)


def machine() -> dict[str, str]:
    """On what a test runs: as much as a result may depend on."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "cores": str(os.cpu_count()),
        "Python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
    }


def table(ledger: Ledger, campaigns: Sequence[Campaign]) -> str:
    """A line on machine and time, and a row a campaign."""
    told = ", ".join(f"{name} {value}" for name, value in ledger.machine.items())
    rows = [_row(ledger, campaign) for campaign in campaigns]
    clock = f"{ledger.elapsed / 60:.0f} minutes by the clock. {told[0].upper()}{told[1:]}."
    return f"{clock}\n\n{markdown(COLUMNS, rows)}"


def _row(ledger: Ledger, campaign: Campaign) -> list[str]:
    name = campaign.NAME
    trials = ledger.of(name)
    failing = sum(trial.campaign == name for trial in ledger.failures)
    mended = sum(campaign == name for campaign, _, _ in ledger.ever_failed) - failing
    counts = totals(trials)
    return [
        name,
        f"{len(trials):,}",
        f"{failing:,}" + (f" ({mended:,} mended)" if mended else ""),
        ", ".join(f"{number:,} {what.replace('_', ' ')}" for what, number in counts.items()),
        f"{sum(trial.seconds for trial in trials) / 60:.1f}",
        _growth(shift for shift in ledger.shifts if shift.campaign == name),
    ]


def _growth(shifts: Iterable[Shift]) -> str:
    """Of the workers of a campaign, the most that one grew by."""
    found = [shift for shift in shifts if shift.grown_bytes is not None]
    if not found:
        return "-"
    resident = max(shift.grown_bytes or 0 for shift in found) / 2**20
    descriptors = max(shift.grown_descriptors or 0 for shift in found)
    return f"{max(resident, 0):.1f} MB, {max(descriptors, 0)} descriptors"


def reproduction(trial: Trial, also: Iterable[str] = ()) -> str:
    """How to meet a failure again and what broke, in at most ten lines."""
    command = ["python -m benchmarks.soak", f"--only {trial.campaign}"]
    if trial.is_shift:
        command += [f"--first-seed {trial.seed}", "--minutes 1", "--workers 1"]
    else:
        command += [f"--seed {trial.seed}"]
    command += [f"--also {module}" for module in also]
    assert trial.failure is not None
    lines = [f"FAILED {trial.campaign}, seed {trial.seed}", *trial.failure.splitlines()]
    return "\n  ".join([*lines, " ".join(command)])
