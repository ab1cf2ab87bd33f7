"""Batches in parts on several threads."""

import os
from threading import Event, get_ident

import pytest

from coopenv.wrench.cores import PARTS, on_all_cores


def cut(monkeypatch, *, cores, num_samples, num_per_thread=1.0):
    """The slices that are solved, in order."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(cores), raising=False)
    parts = []
    on_all_cores(parts.append, num_samples, num_per_thread)
    return sorted(parts, key=lambda part: part.start or 0)


@pytest.mark.parametrize("cores", [2, 3, 8])
@pytest.mark.parametrize("num_samples", [2, 31, 32, 1000])
def test_a_batch_is_cut_into_even_parts_that_make_it_up_several_for_each_core(
    cores, num_samples, monkeypatch
):
    parts = cut(monkeypatch, cores=cores, num_samples=num_samples)
    samples = range(num_samples)
    assert [k for part in parts for k in samples[part]] == [*samples]
    sizes = [len(samples[part]) for part in parts]
    assert max(sizes) - min(sizes) <= 1
    assert len(parts) == PARTS * min(cores, num_samples)


def test_what_keeps_one_core_busy_at_most_is_left_whole(monkeypatch):
    assert cut(monkeypatch, cores=1, num_samples=1000) == [slice(None)]
    assert cut(monkeypatch, cores=8, num_samples=99, num_per_thread=100.0) == [slice(None)]
    assert cut(monkeypatch, cores=8, num_samples=1) == [slice(None)]
    assert len(cut(monkeypatch, cores=8, num_samples=100, num_per_thread=100.0)) == 2 * PARTS


def test_parts_are_solved_at_the_same_time_and_what_one_raises_is_raised(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(2), raising=False)
    there = {}

    def solve(part):
        there.setdefault(get_ident(), Event()).set()
        if part.start == 0:  # wait for the other thread
            assert other.wait(60.0)
        else:
            other.set()

    other = Event()
    on_all_cores(solve, 100, 1.0)
    assert len(there) == 2

    def fail(part):
        raise ArithmeticError(str(part))

    with pytest.raises(ArithmeticError, match="slice"):
        on_all_cores(fail, 100, 1.0)
