"""A sample of mutants, tried one after the other, with the tests that reach each."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from benchmarks.mutants import equivalent
from benchmarks.mutants.reach import Reach, Selected, within
from benchmarks.mutants.recording import Recorder
from benchmarks.mutants.results import CAUGHT, EQUIVALENT, SURVIVED, Result, Results
from benchmarks.mutants.sample import sample
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.tree import Project, Tree
from benchmarks.mutants.trial import Verdict, tried

MOST_RECORDED = 3  # files of tests that a mutant may have recorded for it


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """What is tried, and how much of the tests it may cost."""

    project: Project
    folder: Path  # for copies, compiled code, recordings and results
    mutants: int = 200
    seed: int = 0
    budget: float = 60.0  # [s] of tests for a mutant, as recorded
    again: bool = False  # try survivors anew
    record_all: bool = True  # before the first mutant; otherwise files that are close, when needed
    jobs: int = 1  # files of tests recorded at a time

    def run(self) -> list[Result]:
        """Try what has no result yet; all results of the sample."""
        tree = Tree.copied(self.project, self.folder)
        place = self.folder / self.project.digest()
        recorder = Recorder(tree, place / "records")
        if self.record_all:
            recorder.complete(recorder.missing(), self.jobs, twice=True)
        results = Results(place / f"seed-{self.seed}.jsonl")
        drawn = sample(self.project, self.mutants, self.seed)
        reach = Reach(project=tree.project, recording=recorder.recording)
        waiting = [
            (source, change)
            for source, change in drawn
            if self._is_open(results.of.get(change.key))
        ]
        for (source, change), left in zip(waiting, _left(len(waiting)), strict=True):
            known = equivalent.reason(change, source)
            if known:
                verdict = Verdict(status=EQUIVALENT, by=known)
            else:
                verdict = self._verdict(tree, reach, recorder, change, source)
            result = Result.made(change, source, verdict)
            results.add(result)
            print(
                f"{left} {result.status} {result.file}:{result.line} {result.operator} "
                f"{result.by or '-'} {result.cpu:.0f} s",
                flush=True,
            )
        return [results.of[change.key] for _, change in drawn]

    def finished(self) -> dict[int, list[Result]]:
        """Results by seed, of all seeds whose mutants, as many as here, have been tried."""
        found = {}
        for path in sorted((self.folder / self.project.digest()).glob("seed-*.jsonl")):
            seed, results = int(path.stem.removeprefix("seed-")), Results(path).of
            keys = [change.key for _, change in sample(self.project, self.mutants, seed)]
            if all(key in results for key in keys):
                found[seed] = [results[key] for key in keys]
        return found

    def _is_open(self, result: Result | None) -> bool:
        return result is None or (self.again and result.status in SURVIVED)

    def _verdict(
        self, tree: Tree, reach: Reach, recorder: Recorder, change: Change, source: Source
    ) -> Verdict:
        """Try a change with the tests that reach it, also those of files recorded for it."""
        verdict, cpu = Verdict(status="unreached"), 0.0
        chosen: list[Selected] = []
        ran: list[Selected] = []
        for more in range(MOST_RECORDED, -1, -1):
            chosen = reach.tests(change, source)
            close = within(chosen, self.budget)
            first = [*takewhile(lambda one: one.recorded, close)] if more else close
            new = [one for one in first if one.recorded and one not in ran]
            verdict = tried(tree, change, source.text, new)
            ran += new
            cpu += verdict.cpu
            unknown = [one.test for one in close if not one.recorded]
            if verdict.status == CAUGHT or not unknown:
                break
            if more:
                recorder.complete(unknown[:1])
        return replace(verdict, **_all(ran, chosen, verdict), cpu=round(cpu, 1))


def _all(ran: Sequence[Selected], chosen: Sequence[Selected], last: Verdict) -> dict[str, Any]:
    """What a verdict says of all tests that ran, and not of the last ones alone."""
    names = tuple(one.test for one in ran)
    counts = {"ran": len(ran), "reached_by": len({*ran, *chosen})}
    if last.status == CAUGHT:
        return counts
    return counts | {"status": "survived" if ran else "unreached", "tests": names}


def _left(total: int) -> Iterator[str]:
    """How many are done, and how long the rest will take, before each is begun."""
    begun = time.monotonic()
    for done in range(total):
        minutes = (time.monotonic() - begun) / max(done, 1) * (total - done) / 60
        yield f"{done + 1}/{total}" + (f" ({minutes:.0f} min left)" if done else "")
