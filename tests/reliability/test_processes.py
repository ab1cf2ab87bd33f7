"""Forks, threads, processes and copies of cores and views: `docs/processes.md`."""

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import count as count_from
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import pytest

from coopenv import Body, Scene, Transport, wrench
from coopenv.arrays import FloatArray
from coopenv.compiled.parallel import shared
from coopenv.envs.registry import find_config
from coopenv.errors import BodyLost, CoreInUse, InvalidInput, ResetNeeded
from coopenv.logs import Layout, decompose_file
from coopenv.physics.shard import Shard, Space
from coopenv.physics.world import SHARD_SIZE, World
from tests.helpers import IDS
from tests.logs import cases
from tests.reliability.processes import in_fork, needs_fork

TWO_SHARDS = 2 * SHARD_SIZE  # the fewest worlds that are stepped in threads


def actions(count: int, steps: int = 3) -> FloatArray:
    return np.random.default_rng(0).uniform(-1, 1, (steps, count, 2, 3))


def started(count: int = TWO_SHARDS, **keywords: Any) -> Transport:
    core = Transport(num_worlds=count, **keywords)
    core.reset(seed=0)
    return core


def ride(core: Transport, steps: int = 3) -> npt.NDArray[np.float32]:
    """Observations of some steps."""
    return np.array([core.step(action)[0] for action in actions(core.num_worlds, steps)])


class Waiting:
    """A reward term during which another thread can act: the core is in the middle of a step."""

    def __init__(self):
        self.entered, self.leave = threading.Event(), threading.Event()
        self.armed = False

    def __call__(self, transition: Any) -> Any:
        if self.armed:
            self.armed = False
            self.entered.set()
            assert self.leave.wait(60)
        return np.zeros((len(transition.success), 2))


class UnderWay:
    """A core that another thread is stepping for as long as the block lasts."""

    def __init__(self, count: int):
        self.term = Waiting()
        self.core = started(count, reward=self.term)
        self.found: list[Any] = []
        self._thread = threading.Thread(target=self._step)

    def _step(self) -> None:
        self.found.append(self.core.step(actions(self.core.num_worlds)[0]))

    def __enter__(self):
        self.term.armed = True
        self._thread.start()
        assert self.term.entered.wait(60)
        return self

    def __exit__(self, *_: object) -> None:
        self.term.leave.set()
        self._thread.join(60)
        assert not self._thread.is_alive()


@needs_fork
def test_a_core_steps_on_in_a_forked_child_and_to_the_same_bits(tmp_path):
    core = started()
    ride(core)
    in_fork(lambda: np.save(tmp_path / "seen.npy", ride(core)))
    np.testing.assert_array_equal(np.load(tmp_path / "seen.npy"), ride(core))


@needs_fork
def test_a_core_that_is_made_in_a_forked_child_steps():
    expected = ride(started())
    in_fork(lambda: np.testing.assert_array_equal(ride(started()), expected))


@needs_fork
def test_a_core_that_was_being_stepped_when_its_process_forked_says_so():
    def child() -> None:
        with pytest.raises(CoreInUse):
            core.step(actions(1)[0])
        ride(started(1))  # another one works

    with UnderWay(1) as under_way:
        core = under_way.core
        in_fork(child)


@pytest.mark.parametrize("count", [1, TWO_SHARDS])
def test_a_second_thread_in_a_core_is_refused(count):
    action = actions(count)[0]
    with UnderWay(count) as under_way:
        core = under_way.core
        for call in (core.reset, lambda: core.step(action), lambda: core.advance(action)):
            with pytest.raises(
                CoreInUse, match=r"must be .* by one thread at a time, got a second"
            ):
                call()
    alone = started(count)
    np.testing.assert_array_equal(under_way.found[0][0], alone.step(action)[0])
    np.testing.assert_array_equal(core.step(action)[0], alone.step(action)[0])


def test_a_core_is_free_again_for_any_thread_after_a_step_that_raised():
    core = started(1)
    for wrong in (np.zeros(3), np.full((1, 2, 3), np.nan)):
        with pytest.raises(InvalidInput):
            core.step(wrong)
    with pytest.raises(InvalidInput):
        core.reset(goal=(1e9, 0, 0))
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(ride, core).result().shape[0] == 3


@needs_fork
@pytest.mark.parametrize("count", [1, TWO_SHARDS])
def test_threads_that_race_for_a_core_do_not_crash(count):
    def child() -> None:
        core, until = started(count, horizon=10**6), time.monotonic() + 2.0
        done: list[int] = []

        def race(seed: int) -> None:
            rng, steps = np.random.default_rng(seed), 0
            while time.monotonic() < until:
                try:
                    if rng.random() < 0.1:
                        core.reset()
                    else:
                        core.step(rng.uniform(-1, 1, (count, 2, 3)))
                        steps += 1
                except (CoreInUse, ResetNeeded):
                    time.sleep(1e-4)
            done.append(steps)

        threads = [threading.Thread(target=race, args=(seed,)) for seed in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sum(done) > 0
        assert len(done) == 3

    in_fork(child)


def test_threads_with_a_core_each_get_the_bits_of_one_alone():
    expected = ride(started())
    with ThreadPoolExecutor(3) as pool:
        for found in pool.map(lambda _: ride(started()), range(3)):
            np.testing.assert_array_equal(found, expected)


def test_a_step_that_fails_waits_for_all_shards():
    push = np.zeros((TWO_SHARDS, 3))
    push[:, 0] = 1.0
    kept, lost = (
        World([Body()] * TWO_SHARDS, [Scene()] * TWO_SHARDS, dt=0.05, substeps=2) for _ in "ab"
    )
    lost.twist[3, 0] = 1e6
    kept.step(push)
    with shared(2), pytest.raises(BodyLost):
        lost.step(push)
    others = slice(SHARD_SIZE, None)
    np.testing.assert_array_equal(lost.pose[others], kept.pose[others])


def test_after_a_call_that_broke_off_no_episode_goes_on(monkeypatch):
    core = started(2)
    calls = {
        "step": lambda: core.step(actions(2)[0]),
        "place": lambda: core.reset(mask=np.array([True, False])),
    }
    for name, call in calls.items():
        with monkeypatch.context() as patched:
            patched.setattr(core.world, name, interrupted)
            with pytest.raises(KeyboardInterrupt):
                call()
        with pytest.raises(ResetNeeded, match="after a call that broke off"):
            core.step(actions(2)[0])
        core.reset(seed=0)
        np.testing.assert_array_equal(ride(core), ride(started(2)))


@pytest.mark.parametrize("moment", ["_clear", "_build", "after"])
def test_obstacles_are_whole_again_after_a_reset_that_broke_off_among_them(moment, monkeypatch):
    keywords = {"horizon": 30}
    core, fresh = (Transport(num_worlds=3, config=find_config(IDS[1], keywords)) for _ in range(2))
    core.reset(seed=7)
    count = len(core.world.spaces[0].shapes)
    kept = core.get_state()
    with monkeypatch.context() as patched:
        if moment == "after":  # in the second world, of which one obstacle is there
            patched.setattr(Space, "add", interrupted_at(2, Space.add))
        else:
            patched.setattr(Shard, moment, interrupted_at(2, getattr(Shard, moment)))
        with pytest.raises(KeyboardInterrupt):
            core.reset(seed=0)
    core.reset(seed=0)
    fresh.reset(seed=0)
    assert len(core.world.spaces[0].shapes) == count
    np.testing.assert_array_equal(ride(core, 30), ride(fresh, 30))
    with monkeypatch.context() as patched:
        patched.setattr(Shard, "_build", interrupted_at(1, Shard._build))
        with pytest.raises(KeyboardInterrupt):
            core.set_state(kept)
    core.set_state(kept)
    fresh.set_state(kept)
    assert len(core.world.spaces[0].shapes) == count
    np.testing.assert_array_equal(ride(core, 30), ride(fresh, 30))


def interrupted_at(number: int, method: Any) -> Any:
    """The method, of which a call breaks off: the ``number``-th, counted from 0."""
    calls = count_from(0)

    def interrupting(*arguments: Any) -> Any:
        if next(calls) == number:
            raise KeyboardInterrupt
        return method(*arguments)

    return interrupting


def interrupted(*_: Any) -> None:
    raise KeyboardInterrupt


PAIR = np.array([[-0.9, 0.0], [0.9, 0.0]])
CASES: dict[str, tuple[FloatArray, int, dict[str, Any]]] = {  # grips, wrenches, settings
    "pair on an axis": (PAIR, 20_000, {}),
    "pair off an axis": (np.array([[-0.9, 0.1], [0.7, 0.3]]), 20_000, {}),
    "structured, in space": (np.random.default_rng(1).normal(size=(4, 3)), 300, {}),
    "conic": (PAIR, 10, {"solver": "conic"}),
    "max_internal": (PAIR, 10, {"method": "max_internal"}),
    "virtual_linkage": (PAIR, 1000, {"method": "virtual_linkage"}),
}


def decomposer(case: str) -> tuple[wrench.Decomposer, FloatArray]:
    grips, count, settings = CASES[case]
    size = 3 if grips.shape[1] == 2 else 6
    applied = np.random.default_rng(0).normal(size=(count, len(grips), size))
    if settings.get("method") == "max_internal":
        applied[..., 2:] = 0.0  # splits forces only
    return wrench.Decomposer(grips, wrench.Settings(**settings)), applied


@pytest.mark.parametrize("case", CASES)
def test_threads_may_share_a_decomposer(case):
    split, applied = decomposer(case)
    expected = split(applied)
    with ThreadPoolExecutor(3) as pool:
        for found in pool.map(lambda _: split(applied), range(6)):
            np.testing.assert_array_equal(found.manipulation, expected.manipulation)
            np.testing.assert_array_equal(found.relative_cost, expected.relative_cost)


@needs_fork
@pytest.mark.parametrize("case", CASES)
def test_a_decomposer_works_in_a_forked_child(case):
    split, applied = decomposer(case)
    expected = split(applied).manipulation

    def child() -> None:
        np.testing.assert_array_equal(split(applied).manipulation, expected)
        again, _ = decomposer(case)
        np.testing.assert_array_equal(again(applied).manipulation, expected)

    in_fork(child)


def test_threads_may_ask_one_decomposition_at_the_same_time():
    split, applied = decomposer("pair on an axis")
    alone, shared = split(applied), split(applied)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: shared.relative_cost + shared.internal[:, 0, 0], range(8)):
            np.testing.assert_array_equal(found, alone.relative_cost + alone.internal[:, 0, 0])


def test_recordings_are_decomposed_in_threads_and_in_forked_children(tmp_path):
    for needed in ("pyarrow", "pandas"):
        pytest.importorskip(needed)
    path = cases.save(cases.planar(rows=300), tmp_path / "trial.csv")

    def table(number: int) -> bytes:
        out = tmp_path / f"out{number}.csv"
        decompose_file(path, out, layout=Layout(grips=cases.BEAM), picture=False)
        return out.read_bytes()

    expected = table(0)
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(table, range(1, 4))) == [expected] * 3
    if hasattr(os, "fork"):
        in_fork(lambda: table(4))
        assert (tmp_path / "out4.csv").read_bytes() == expected


@needs_fork
@pytest.mark.parametrize("name", IDS)
def test_a_vector_steps_on_in_a_forked_child_and_the_parent_goes_on(name, tmp_path):
    venv: Any = gymnasium.make_vec(name, num_envs=TWO_SHARDS, partner="noisy")
    venv.reset(seed=0)
    action = np.random.default_rng(0).uniform(-1, 1, venv.action_space.shape)
    venv.step(action)
    in_fork(lambda: np.save(tmp_path / "seen.npy", venv.step(action)[0]))
    np.testing.assert_array_equal(np.load(tmp_path / "seen.npy"), venv.step(action)[0])
