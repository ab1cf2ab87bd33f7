"""Handle of a worker process: start it, give it seeds, notice that it crashed or hangs, end it."""

import multiprocessing
import os
import signal
import time
from contextlib import suppress
from pathlib import Path

from benchmarks.soak.frame.campaign import Campaign, module_of, timeout_of
from benchmarks.soak.frame.worker import LINES, WIDTH, Outcome, Size, serve

PARTING = 2.0  # [s] in which a worker that is let go has to end
START = 300.0  # [s] in which a worker has to be up
GRACE = 30.0  # [s] beyond a trial's time-out, in which a worker says where it hung


class Worker:
    """One worker of a campaign.

    Parameters
    ----------
    campaign
        What it tries.
    folder
        For the folders of its trials.
    log
        For what it prints.

    Attributes
    ----------
    alive
        Whether it can try more.
    """

    def __init__(self, campaign: Campaign, folder: Path, log: Path):
        self._campaign, self._log = campaign, log
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        arguments = far, module_of(campaign), folder, log
        self._process = context.Process(target=serve, args=arguments)
        self._process.start()
        far.close()
        self.alive, self._is_up, self._is_gone = True, False, False

    def wait(self) -> None:
        """Until it has warmed up for its campaign; if it never does, its first trial fails."""
        try:
            self._is_up = self._pipe.poll(START) and self._pipe.recv() is None
        except (EOFError, OSError):
            self._is_up = False

    def attempt(self, seed: int) -> tuple[Outcome, Size | None]:
        """Run one trial; a crash or a hang is its failure, and the worker's end."""
        began = time.monotonic()
        try:
            self._pipe.send(seed)
            if self._is_up and self._pipe.poll(timeout_of(self._campaign) + GRACE):
                return self._pipe.recv()
        except (EOFError, OSError):
            pass
        seconds = time.monotonic() - began
        self.end()
        return Outcome(seconds=seconds, failure=self._last_words(seconds)), None

    def end(self) -> None:
        """Let it go, or kill it, with its children."""
        self.alive = False
        with suppress(OSError):
            self._pipe.send(None)
        if not self._is_gone:
            self._process.join(PARTING)
        self.kill()

    def kill(self) -> None:
        """End it and its children at once; only once, since its number may then be another's."""
        self.alive = False
        if self._is_gone or self._process.pid is None:
            return
        self._is_gone = True
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        if self._process.is_alive():  # it had no group of its own yet
            self._process.kill()
        self._process.join()

    def _last_words(self, seconds: float) -> str:
        """How it ended, and where by its log."""
        code = self._process.exitcode or 0
        limit = timeout_of(self._campaign)
        if seconds >= limit:
            how = f"no end within {limit:g} s"
        elif code < 0:
            how = f"the interpreter ended by {signal.Signals(-code).name}"
        else:
            how = f"the interpreter ended with code {code}"
        log = self._log.read_text("utf-8", "replace").splitlines() if self._log.exists() else []
        heads = [k for k, line in enumerate(log) if line.endswith("(most recent call first):")]
        stack = log[heads[-1] + 1 :] if heads else log[-LINES:]  # the main thread's is the last
        frames = [line.strip()[:WIDTH] for line in stack if line.strip()]
        return "\n".join([how, *frames[:LINES]])
