"""Runner of the soak test: workers in shifts, a schedule by shares, and the watch over growth.

Each slot runs one worker process after another. A worker serves one campaign for a shift; then the
campaign that is farthest behind its share of the time has its turn.
"""

import itertools
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

from benchmarks.soak.frame.campaign import Campaign
from benchmarks.soak.frame.handle import Worker
from benchmarks.soak.frame.ledger import Ledger, Shift, Trial
from benchmarks.soak.frame.worker import Size

SHIFT = 120.0, 5.0  # [s] longest and shortest
GROWTH = Size(64 * 2**20, 8)  # bytes and descriptors by which a worker may grow
FEWEST_READINGS = 12  # below, nothing is said of growth


class Runner:
    """A soak test under way.

    Parameters
    ----------
    ledger
        What was tried, and is.
    campaigns
        Whose trials are run.
    seconds
        How long it takes, all runs of the ledger together.
    folder
        For logs and the folders of trials.
    workers
        How many run side by side.
    first_seed
        Of every campaign.
    trials
        Of each campaign at most; ``None``: as many as there is time for.
    again
        Whether to begin with the trials that failed.
    tell
        Called with every failure.
    """

    def __init__(
        self,
        ledger: Ledger,
        campaigns: Sequence[Campaign],
        *,
        seconds: float,
        folder: Path,
        workers: int,
        first_seed: int,
        trials: int | None,
        again: bool,
        tell: Callable[[Trial], None],
    ):
        self._ledger, self._campaigns, self._tell = ledger, campaigns, tell
        self._seconds, self._folder, self._workers = seconds, folder, workers
        self._seeds: dict[str, Iterator[int]] = {}
        open_ = {(trial.campaign, trial.seed) for trial in ledger.failures if again}
        for campaign in campaigns:
            done = {
                trial.seed
                for trial in ledger.of(campaign.NAME)
                if (campaign.NAME, trial.seed) not in open_
            }
            every = itertools.islice(itertools.count(first_seed), trials)
            self._seeds[campaign.NAME] = itertools.filterfalse(done.__contains__, every)
        self._lock, self._stopped = threading.RLock(), threading.Event()
        self._busy: dict[int, str] = {}  # slot -> its campaign
        self._running: dict[int, Worker] = {}  # slot -> its worker
        self._origin = time.monotonic() - ledger.elapsed
        fair = seconds * workers / (4 * len(campaigns))  # every campaign has some in the time
        self._shift = min(SHIFT[0], max(SHIFT[1], fair))

    @property
    def clock(self) -> float:
        """Seconds that the soak test has run for, all runs together."""
        return time.monotonic() - self._origin

    def run(self, beat: Callable[[], None]) -> None:
        """Run to the end; ``beat`` is called now and then. An interrupt ends all workers."""
        pool = ThreadPoolExecutor(self._workers)
        slots = [pool.submit(self._slot, slot) for slot in range(self._workers)]
        try:
            while wait(slots, timeout=0.2).not_done:
                beat()
            for slot in slots:
                slot.result()
        finally:
            self._stopped.set()
            for worker in [*self._running.values()]:
                worker.kill()
            pool.shutdown()
            shutil.rmtree(self._folder / "trials", ignore_errors=True)

    def _goes_on(self) -> bool:
        return self.clock < self._seconds and not self._stopped.is_set()

    def _slot(self, slot: int) -> None:
        while self._goes_on():
            with self._lock:
                campaign = self._most_behind()
                if campaign is None:
                    return
                self._busy[slot] = campaign.NAME
            self._work(slot, campaign)
            del self._busy[slot]

    def _most_behind(self) -> Campaign | None:
        """The campaign with trials left that has had the least of its share of the time."""
        under_way = [*self._busy.values()]

        def had(campaign: Campaign) -> float:
            spent = sum(trial.seconds for trial in self._ledger.of(campaign.NAME))
            return (spent + under_way.count(campaign.NAME) * self._shift) / campaign.SHARE

        left = [each for each in self._campaigns if each.NAME in self._seeds]
        return min(left, key=had, default=None)

    def _work(self, slot: int, campaign: Campaign) -> None:
        """One worker's shift; it ends early if the worker does."""
        folder = self._folder / "trials" / str(slot)
        shutil.rmtree(folder, ignore_errors=True)
        sizes, seeds = [], []
        worker = Worker(campaign, folder, self._folder / f"worker-{slot}.log")
        self._running[slot] = worker
        worker.wait()
        began = self.clock
        while worker.alive and self._goes_on() and self.clock < began + self._shift:
            seed = self._next_seed(campaign)
            if seed is None:
                break
            seeds.append(seed)
            outcome, size = worker.attempt(seed)
            if self._stopped.is_set():
                break  # what was cut short has not failed
            trial = Trial(
                campaign=campaign.NAME,
                seed=seed,
                at=self.clock,
                seconds=outcome.seconds,
                counts=outcome.counts,
                failure=outcome.failure,
                trace=outcome.trace,
            )
            self._record(trial)
            if size is not None:
                sizes.append(size)
        worker.end()
        del self._running[slot]
        if seeds and not self._stopped.is_set():
            self._judge(campaign, seeds[0], began, sizes)

    def _next_seed(self, campaign: Campaign) -> int | None:
        """A seed of it that was not tried, unless it has had all its trials."""
        with self._lock:
            seed = next(self._seeds.get(campaign.NAME, iter(())), None)
            if seed is None:
                self._seeds.pop(campaign.NAME, None)
            return seed

    def _record(self, trial: Trial) -> None:
        with self._lock:
            self._ledger.add(trial)
            if trial.failure is not None:
                self._tell(trial)

    def _judge(self, campaign: Campaign, seed: int, began: float, sizes: Sequence[Size]) -> None:
        """Write the shift down; a worker that grew is a failure of its own."""
        grown, now = growth(sizes), self.clock
        with self._lock:
            self._ledger.add(
                Shift(
                    campaign=campaign.NAME,
                    seed=seed,
                    at=now,
                    seconds=now - began,
                    grown_bytes=grown and grown.resident,
                    grown_descriptors=grown and grown.descriptors,
                )
            )
        if grown and (grown.resident > GROWTH.resident or grown.descriptors > GROWTH.descriptors):
            said = (
                f"a worker grew by {grown.resident / 2**20:.0f} MB and {grown.descriptors} "
                f"descriptors in {now - began:.0f} s from seed {seed} on"
            )
            self._record(
                Trial(campaign=campaign.NAME, seed=seed, at=now, failure=said, is_shift=True)
            )


def growth(sizes: Sequence[Size]) -> Size | None:
    """By how much the least of the last quarter is above that of the second, if there are enough.

    The first quarter is warm-up; the least of several readings forgives what comes and goes.
    """
    quarter = len(sizes) // 4
    if len(sizes) < FEWEST_READINGS:
        return None
    warm, late = sizes[quarter : 2 * quarter], sizes[-quarter:]
    return Size(
        min(size.resident for size in late) - min(size.resident for size in warm),
        min(size.descriptors for size in late) - min(size.descriptors for size in warm),
    )
