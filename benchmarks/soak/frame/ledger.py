"""Ledger of a soak test: what was tried, a JSON line each, from which a killed run goes on.

A line is on the disk before the next trial begins. One that a kill has cut is dropped.
"""

import fcntl
import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from coopenv.errors import InvalidInput

FILE = "trials.jsonl"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One trial."""

    campaign: str
    seed: int
    at: float  # [s] on the clock of the soak test, which stands still between runs
    seconds: float = 0.0  # [s] that it took
    counts: dict[str, int] = field(default_factory=dict)
    failure: str | None = None  # what broke, in a line or a few
    trace: str = ""  # where, for those who look into the file
    is_shift: bool = False  # whether it is the shift that began with this seed that failed


@dataclass(frozen=True, slots=True, kw_only=True)
class Shift:
    """What one worker did until it was replaced, and by how much it grew."""

    campaign: str
    seed: int  # its first
    at: float  # [s]
    seconds: float  # [s] from its start to its end
    grown_bytes: int | None  # of resident memory; None: too few trials to say
    grown_descriptors: int | None


class Ledger:
    """The file of a soak test, locked while it is open.

    Parameters
    ----------
    folder
        Where it is; made if it is not there.
    machine
        On what it runs, for a new file; one that goes on has to run on the same.
    fresh
        Whether to forget what is in it.

    Raises
    ------
    InvalidInput
        If the folder is in use, or its test ran on another machine or other versions.
    """

    def __init__(self, folder: Path, machine: dict[str, str], *, fresh: bool = False):
        self.trials: list[Trial] = []
        self.shifts: list[Shift] = []
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / FILE
        self._file = path.open("a+b")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise InvalidInput(
                f"out must be a folder that nobody else runs in, got {folder}; name another one"
            ) from error
        if fresh:
            self._file.truncate(0)
        self.machine = self._read() or machine
        if self.machine != machine:
            self._file.close()
            changed = [name for name in machine if machine[name] != self.machine.get(name)]
            raise InvalidInput(
                f"out must be of the same {', '.join(changed)}, got {folder} of "
                f"{', '.join(str(self.machine.get(name)) for name in changed)}; pass --fresh, or "
                "name another folder"
            )
        if not path.stat().st_size:
            self._write({"machine": machine})

    def _read(self) -> dict[str, str]:
        """Take in all whole lines and cut off what follows them; the machine."""
        self._file.seek(0)
        text = self._file.read()
        whole = text[: text.rfind(b"\n") + 1]
        self._file.truncate(len(whole))
        machine = {}
        for line in whole.splitlines():
            record = json.loads(line)
            if "machine" in record:
                machine = record["machine"]
            elif "grown_bytes" in record:
                self.shifts.append(Shift(**record))
            else:
                self.trials.append(Trial(**record))
        return machine

    def add(self, record: Trial | Shift) -> None:
        """Write a trial or a shift down."""
        self._write(asdict(record))
        if isinstance(record, Trial):
            self.trials.append(record)
        else:
            self.shifts.append(record)

    def _write(self, record: dict[str, Any]) -> None:
        self._file.write(json.dumps(record).encode() + b"\n")
        self._file.flush()

    def close(self) -> None:
        """Let others have the folder."""
        self._file.close()

    @property
    def elapsed(self) -> float:
        """Seconds that the soak test has run for."""
        return max((each.at for each in (*self.trials, *self.shifts)), default=0.0)

    @property
    def failures(self) -> list[Trial]:
        """Trials in which something broke, and did so when they were last tried."""
        last = {(trial.campaign, trial.seed, trial.is_shift): trial for trial in self.trials}
        return [trial for trial in last.values() if trial.failure is not None]

    @property
    def ever_failed(self) -> set[tuple[str, int, bool]]:
        """Campaign, seed and ``is_shift`` of trials in which something broke at any time."""
        return {
            (trial.campaign, trial.seed, trial.is_shift)
            for trial in self.trials
            if trial.failure is not None
        }

    def of(self, campaign: str) -> list[Trial]:
        """Its trials."""
        return [trial for trial in self.trials if trial.campaign == campaign and not trial.is_shift]


def totals(trials: Iterable[Trial]) -> Counter[str]:
    """The sum of their counts."""
    found: Counter[str] = Counter()
    for trial in trials:
        found.update(trial.counts)
    return found
