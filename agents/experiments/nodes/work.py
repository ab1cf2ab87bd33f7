"""What a node does with a cell that it is sent: work on it, and send the whole folder back."""

from collections.abc import Iterator
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from ..run import Launch, Processes, Stoppable
from .parcel import packed, unpack
from .spread import FAILED, PARCEL, Told

LOOK = 0.2  # [s] between two looks, so that an interruption is heard
_ENDED = "ended"


def work_on(parcel: bytes, launch: Launch | None = None) -> Iterator[Told]:
    """Work on a cell; tell how far it is, and at last its whole folder or why it failed.

    Parameters
    ----------
    parcel
        Its folder, of `packed`.
    launch
        How it is worked on; by default in a process of its own, as on one machine, which ends with
        this one.
    """
    with TemporaryDirectory(prefix="coopenv-cell-") as name:
        folder = Path(name)
        unpack(parcel, folder)
        worker = Processes() if launch is None else launch
        told: SimpleQueue[Told] = SimpleQueue()
        thread = Thread(target=_work, args=(worker, folder, told), daemon=True)
        thread.start()
        said = _next(told)
        try:
            while _ENDED not in said:
                yield said
                said = _next(told)
        finally:
            if isinstance(worker, Stoppable):
                worker.stop()
            thread.join()
        why = said[_ENDED]
        yield {PARCEL: packed(folder)} if why is None else {FAILED: why}


def _work(worker: Launch, folder: Path, told: "SimpleQueue[Told]") -> None:
    """Whatever comes of it is told: nobody else hears of an error here."""
    why: Any = "nothing came of it"
    try:
        why = worker(folder, told.put)
    except BaseException as error:
        why = f"{type(error).__name__}: {error}"
    finally:
        told.put({_ENDED: why})


def _next(told: "SimpleQueue[Told]") -> Told:
    while True:
        try:
            return told.get(timeout=LOOK)
        except Empty:
            continue
