"""Trouble of the thread that writes TensorBoard's events."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def told_once() -> Iterator[None]:
    """Let trouble with a file be told by the training alone.

    The thread keeps the error and raises it again where the next event is given to it, in the
    training. That it ends by it would be printed beside, with a traceback.
    """
    before = threading.excepthook

    def hook(told: threading.ExceptHookArgs) -> None:
        writer = type(told.thread).__module__.startswith("tensorboard.")
        if not (writer and issubclass(told.exc_type, OSError)):
            before(told)

    threading.excepthook = hook
    try:
        yield
    finally:
        threading.excepthook = before
