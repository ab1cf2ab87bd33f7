"""Trouble of TensorBoard's thread is told by the training, and that of other threads by Python."""

import threading

import pytest

from coopenv.agents.training.events import told_once


class _Writer(threading.Thread):
    """As TensorBoard's, which knows nobody to raise an error to."""


_Writer.__module__ = "tensorboard.summary.writer.event_file_writer"


def ended(kind, error) -> None:
    """Have a thread of a kind end by an error."""

    def fail():
        raise error

    thread = kind(target=fail)
    thread.start()
    thread.join()


@pytest.fixture
def told(monkeypatch):
    """What Python prints of threads that end by an error."""
    seen: list[BaseException | None] = []
    monkeypatch.setattr(threading, "excepthook", lambda about: seen.append(about.exc_value))
    return seen


def test_only_the_writers_trouble_with_files_is_not_printed_and_only_in_the_block(told):
    full, wrong = OSError(28, "No space left on device"), ValueError("wrong")
    before = threading.excepthook
    with told_once():
        ended(_Writer, full)
        assert told == []
        ended(_Writer, wrong)
        ended(threading.Thread, full)
        assert told == [wrong, full]
    assert threading.excepthook is before
    ended(_Writer, full)
    assert told == [wrong, full, full]


def test_the_hook_is_put_back_where_the_training_fails(told):
    before = threading.excepthook
    with pytest.raises(ZeroDivisionError), told_once():
        raise ZeroDivisionError
    assert threading.excepthook is before
