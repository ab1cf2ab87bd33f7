"""Work in parts: every row once, by whoever takes it."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from numba import njit

from coopenv.compiled import compiled
from coopenv.compiled.parallel import Crew, crew, shared, sharing, spread
from tests.reliability.processes import in_fork, needs_fork


@compiled
def count_up(start, stop, seen, by):
    for row in range(start, stop):
        seen[row] += by


@compiled
def counted(board, parts, seen, by):
    spread(board, parts, len(seen), count_up, (seen, by))


@njit(error_model="numpy")
def counted_anew(board, parts, seen, by):
    """`counted`, in no cache."""
    spread(board, parts, len(seen), count_up, (seen, by))


@compiled
def told(start, stop, seen):
    return seen[start]


@compiled
def refused(board, seen):
    spread(board, 2, len(seen), told, (seen,))


@given(count=some.integers(0, 300), parts=some.integers(1, 70), helpers=some.integers(0, 3))
def test_every_row_is_done_once_by_any_crew(count, parts, helpers):
    crew = _CREWS[helpers]
    crew.wake(crew.most)
    seen = np.zeros(count, dtype=np.int64)
    for _ in range(20):
        counted(crew.board, parts, seen, 3)
    assert (seen == 60).all()


_CREWS = [Crew(helpers) for helpers in range(4)]


@pytest.mark.parametrize("parts", [1, 7])
def test_a_kernel_that_is_compiled_just_now_spreads_too(parts):
    seen = np.zeros(40, dtype=np.int64)
    counted_anew(0, parts, seen, 3)
    counted_anew(_CREWS[0].board, parts, seen, 2)
    assert (seen == 5).all()


def test_threads_that_have_work_at_the_same_time_do_not_mix_it_up():
    crew, rows = Crew(2), 999

    def work(by: int) -> bool:
        seen = np.zeros(rows, dtype=np.int64)
        for _ in range(2000):
            crew.wake(crew.most)
            counted(crew.board, 8, seen, by)
        return bool((seen == 2000 * by).all())

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, (1, 10, 100, 1000)))
    crew.close()


def test_helpers_sleep_where_there_is_nothing_to_do_wake_and_end():
    before = threading.active_count()
    crew = Crew(3)
    for _ in range(3):
        crew.wake(crew.most)
        _wait_until(lambda: crew.awake == 0)
    seen = np.zeros(50, dtype=np.int64)
    counted(crew.board, 5, seen, 1)  # all asleep: done alone
    assert (seen == 1).all()
    crew.close()
    _wait_until(lambda: threading.active_count() <= before)


def _wait_until(so: object) -> None:
    done = threading.Event()
    for _ in range(2000):
        if so():  # type: ignore[operator]
            return
        done.wait(0.01)
    raise AssertionError("it did not come")


def test_nothing_is_shared_but_within_a_block_that_says_so():
    assert sharing(1000) == (0, 1)
    with shared(2):
        board, parts = sharing(1000)
        assert board == crew().board
        assert parts > 1 or not crew().most
        assert sharing(1) == (0, 1)
        with shared(1):
            assert sharing(1000) == (0, 1)
    assert sharing(1000) == (0, 1)


def test_a_kernel_that_returns_something_cannot_be_spread():
    with pytest.raises(TypeError, match="must return nothing"):
        refused(0, np.zeros(3))


@compiled
def fails_late(start, stop, seen):
    for row in range(start, stop):
        if row == 57:
            raise MemoryError("as if there were none")
        seen[row] += 1


@compiled
def failing(board, parts, seen):
    spread(board, parts, len(seen), fails_late, (seen,))


@pytest.mark.parametrize("parts", [1, 6])
def test_a_part_that_fails_is_told_and_the_board_is_free_again(parts):
    crew, seen = _CREWS[2], np.zeros(100, dtype=np.int64)
    crew.wake(2)
    with pytest.raises(MemoryError, match="memory must suffice"):
        failing(crew.board, parts, seen)
    again = np.zeros(100, dtype=np.int64)
    counted(crew.board, 6, again, 1)
    assert (again == 1).all()


def test_where_the_system_gives_no_more_threads_fewer_help(monkeypatch):
    crew = Crew(3)
    crew.wake(1)
    monkeypatch.setattr(threading.Thread, "start", _refuse)
    crew.wake(3)
    assert crew.most == 1
    seen = np.zeros(50, dtype=np.int64)
    counted(crew.board, 5, seen, 1)
    assert (seen == 1).all()


def _refuse(_: threading.Thread) -> None:
    raise RuntimeError("can't start new thread")


def test_a_core_of_one_thread_uses_one_within_the_step_of_another():
    with shared(2), shared(1):
        assert sharing(1000) == (0, 1)


@needs_fork
def test_a_forked_child_has_a_crew_of_its_own():
    def work() -> None:
        seen = np.zeros(100, dtype=np.int64)
        with shared(2):
            counted(*sharing(10), seen, 1)
        assert (seen == 1).all()

    work()
    in_fork(work)
