"""Nodes that are threads of this process, and can be lost on the way."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from threading import Event, Lock
from typing import Any

from coopenv.agents.experiments.nodes import NodeLost, Told, work_on
from tests.agents.experiments.cases import here


@dataclass(eq=False)
class Here:
    """What a node tells, or that it is lost."""

    parcel: bytes
    is_lost: bool
    launch: Any
    cancelled: Event = field(default_factory=Event)

    def __iter__(self) -> Iterator[Told]:
        if self.is_lost:
            raise NodeLost("the machine is gone")
        for said in work_on(self.parcel, self.launch):
            if self.cancelled.is_set():
                raise NodeLost("cancelled")
            yield said

    def cancel(self) -> None:
        self.cancelled.set()


@dataclass
class Threads:
    """Nodes of which the first so many are lost before they send anything home."""

    losses: int = 0
    launch: Any = here
    begun: list[bytes] = field(default_factory=list)
    lock: Lock = field(default_factory=Lock)

    def begin(self, parcel: bytes) -> Here:
        with self.lock:
            self.begun.append(parcel)
            lost = len(self.begun) <= self.losses
        return Here(parcel, lost, self.launch)
