"""Spreading of cells over nodes: sent there, followed, brought home whole, run again if lost."""

import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from ..cell import Cell
from ..run import INTERRUPTED
from .parcel import packed, unpack

FAILED, PARCEL = "failed", "parcel"  # the last thing that is told: why, or the whole folder
LOSSES = 10  # times that a cell's node may be lost until the cell counts as failed
AT_A_TIME = 256  # cells that are handed over and not yet back

Told = dict[str, Any]
"""``{"steps": done}`` now and then, at last ``{"parcel": all files}`` or ``{"failed": why}``."""


class NodeLost(Exception):
    """A node ended, or was cut off, before it sent back what it worked on."""


class Stream(Protocol):
    """What a node tells of a cell, as it tells it; raises `NodeLost` where it cannot go on."""

    def __iter__(self) -> Iterator[Told]:
        """Each thing told, once."""
        ...

    def cancel(self) -> None:
        """Have the node stop; whoever iterates is told no more, or raised `NodeLost`."""
        ...


class Nodes(Protocol):
    """Machines that work on cells: what Ray fills, or any other scheduler."""

    def begin(self, parcel: bytes) -> Stream:
        """Have one of them do `coopenv.agents.experiments.nodes.work_on`, as soon as one can."""
        ...


@dataclass(slots=True)
class Spread:
    """Has nodes work on cells: a `coopenv.agents.experiments.run.Launch`.

    Parameters
    ----------
    nodes
        That work.
    say
        Told of each node that is lost; by default prints to standard error.
    """

    nodes: Nodes
    say: Callable[[str], object] = lambda sentence: print(sentence, file=sys.stderr)
    _running: set[Stream] = field(default_factory=set)
    _lock: Lock = field(default_factory=Lock)
    _stopped: bool = False

    def __call__(self, folder: Path, report: Callable[[Told], None]) -> str | None:
        """Have a node work on the cell in the folder; why it failed, or None."""
        sent, why = packed(folder), ""
        for _ in range(LOSSES):
            try:
                return self._followed(folder, sent, report)
            except NodeLost as lost:
                if self._stopped:
                    return INTERRUPTED
                why = str(lost)
                self.say(f"a node was lost, and its cell {folder.name} begins anew: {why}")
                report({"steps": 0})
        return f"its node was lost {LOSSES} times, the last time as {why}"

    def stop(self) -> None:
        """Have all nodes stop what they work on; nothing begins any more."""
        with self._lock:
            self._stopped = True
            running = [*self._running]
        for stream in running:
            stream.cancel()

    def _followed(self, folder: Path, sent: bytes, report: Callable[[Told], None]) -> str | None:
        with self._lock:
            if self._stopped:
                return INTERRUPTED
            stream = self.nodes.begin(sent)
            self._running.add(stream)
        try:
            return _end(stream, folder, sent, report)
        finally:
            with self._lock:
                self._running.discard(stream)


def _end(
    stream: Iterable[Told], folder: Path, sent: bytes, report: Callable[[Told], None]
) -> str | None:
    """What came of a cell: its files are home, or why there are none."""
    for said in stream:
        if FAILED in said:
            return said[FAILED]
        if PARCEL in said:
            unpack(said[PARCEL], folder, sent)
            if Cell.load(folder).is_finished(folder):
                return None
            return (
                "nodes must have the coopenv of the experiment, got a result of another "
                "configuration; install the same version there"
            )
        report(said)
    raise NodeLost("it went silent")
