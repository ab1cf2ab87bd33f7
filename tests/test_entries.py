"""Infos whose entries are made when asked for are dictionaries to whoever uses them."""

import copy
import json
import pickle
import pprint
from collections import ChainMap
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

from coopenv import Transport
from coopenv.info import Info, copied, step_info
from coopenv.rewards import Success
from coopenv.tasks.transport import TransportTask
from tests.helpers import PARALLEL, actions, parallel_actions

ENTRIES = {"success": False, "reward/progress": 0.5, "reward/time": -0.1, "body/mass": 3.0}


class Counted:
    """A source that counts what is taken from it."""

    def __init__(self) -> None:
        self.taken: list[str] = []

    def __iter__(self) -> Iterator[str]:
        return iter(ENTRIES)

    def __contains__(self, name: object) -> bool:
        return name in ENTRIES

    def __getitem__(self, name: str) -> Any:
        self.taken.append(name)
        return ENTRIES[name]


READINGS: dict[str, Callable[[Info], Any]] = {
    "dict": dict,
    "unpacked": lambda info: {**info},
    "as keywords": lambda info: (lambda **words: words)(**info),
    "items": lambda info: dict(info.items()),
    "keys and values": lambda info: dict(zip(info.keys(), info.values(), strict=True)),
    "by name": lambda info: {name: info[name] for name in info},
    "got": lambda info: {name: info.get(name) for name in info},
    "backwards": lambda info: {name: info[name] for name in reversed(list(reversed(info)))},
    "on the left of a union": lambda info: info | {},
    "on the right of a union": lambda info: {} | info,
    "into another": lambda info: (lambda other: (other.update(info), other)[1])({}),
    "in a chain": lambda info: dict(ChainMap(info)),
    "copied": copy.copy,
    "copied by its method": lambda info: info.copy(),
    "copied deep": copy.deepcopy,
    "pickled": lambda info: pickle.loads(pickle.dumps(info)),
    "in JSON": lambda info: json.loads(json.dumps(info)),
    "written": lambda info: eval(repr(info)),
}


@pytest.mark.parametrize("reading", READINGS.values(), ids=READINGS)
@pytest.mark.parametrize("before", [(), ("reward/time",)], ids=["untouched", "after an entry"])
def test_whatever_reads_it_meets_all_entries_in_order(reading, before):
    info = Info.of(Counted())
    for name in before:
        assert info[name] == ENTRIES[name]
    read = reading(info)
    assert dict(read) == ENTRIES
    assert list(read) == list(ENTRIES)


def test_it_equals_what_it_will_hold_and_is_as_long():
    assert Info.of(Counted()) == ENTRIES
    assert dict(ENTRIES) == Info.of(Counted())
    assert (Info.of(Counted()) != Info(ENTRIES)) is False
    assert len(Info.of(Counted())) == len(ENTRIES)
    assert Info.of(Counted())
    assert Info.of(Counted()) != {}


def test_it_is_written_line_by_line_as_any_dictionary():
    assert pprint.pformat(Info.of(Counted()), width=20) == pprint.pformat(ENTRIES, width=20)


def test_changes_come_on_top_of_all_entries():
    changed = []
    for change in (
        lambda info: info.__setitem__("more", 1),
        lambda info: info.update(more=1),
        lambda info: info.setdefault("more", 1),
        lambda info: info.__ior__({"more": 1}),
    ):
        info = Info.of(Counted())
        change(info)
        changed.append(list(info.items()))
    assert all(items == [*ENTRIES.items(), ("more", 1)] for items in changed)
    info = Info.of(Counted())
    assert info.pop("success") is False
    del info["body/mass"]
    assert list(info) == ["reward/progress", "reward/time"]
    assert info.popitem() == ("reward/time", -0.1)
    assert info.setdefault("reward/progress", 9.0) == 0.5
    info.clear()
    assert info == {}


def test_only_what_is_indexed_is_made_and_once():
    source = Counted()
    info = Info.of(source)
    assert "body/mass" in info
    for other in ("reward/none", "reward_terms"):
        assert other not in info
    assert info.get("reward/none", 7) == 7
    assert info.get("reward_terms") is None
    assert list(info.names()) == list(ENTRIES)
    with pytest.raises(KeyError):
        info["reward/none"]
    assert source.taken == ["success"]
    assert info["reward_terms"] == {"progress": 0.5, "time": -0.1}
    assert info["success"] is info["success"] is False
    assert source.taken == ["success", "reward/progress", "reward/time"]
    assert dict(info) == ENTRIES
    assert sorted(source.taken) == sorted(ENTRIES)


def same(one: Any, other: Any) -> None:
    assert list(one) == list(other)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


@pytest.mark.parametrize(
    "keywords",
    [
        {},
        {"partner": "noisy", "cost": "waste", "bounded": True},
        {"action": "motion", "sensing": "own"},
    ],
    ids=["plain", "partner, cost and bounds", "hands"],
)
def test_infos_read_late_are_of_their_own_step(keywords):
    """Whatever happens between: steps, resets of some worlds, and changes of what was told."""
    core = Transport(num_worlds=4, horizon=9, **keywords)
    kept = [core.reset(seed=0)[1]]
    at_once = [copied(core._info)]
    for step, action in enumerate(actions(1, 24, *core.action_shape)):
        *_, terminated, truncated, info = core.step(action)
        kept.append(info)
        at_once.append(copied(core._info))
        for value in copied(core._info).values():
            value[...] = 0
        done = terminated | truncated
        done[0] |= step % 5 == 4
        if done.any():
            kept.append(core.reset(mask=done)[1])
            at_once.append(copied(core._info))
    for late, early in zip(kept, at_once, strict=True):
        same(late, early)


def test_what_is_done_to_an_info_changes_nothing_in_the_core():
    core = Transport(num_worlds=3)
    core.reset(seed=0)
    core.step(np.ones((3, 2, 3)))
    before = copied(core._info)
    *_, info = core.step(np.ones((3, 2, 3)) / 2)
    told = copied(core._info)
    for value in info.values():
        value[...] = 0
    same(core._info, told)
    assert not np.array_equal(told["internal_wrench"], before["internal_wrench"])
    assert core.transition is not None
    same(step_info(core.transition, told["reward_terms"], {}), told)


class Remembering(TransportTask):
    """A task that answers from the same memory every time."""

    def success(self, pose, twist, goal):
        answer = _memory.setdefault("success", np.zeros(len(pose), dtype=np.bool_))
        answer[:] = pose[:, 0] > 0
        return answer


_memory: dict[str, Any] = {}


def remembered(transition):
    """A term that answers from the same memory every time."""
    memory = _memory.setdefault("reward", np.zeros(transition.applied.shape[:2]))
    memory[:] = transition.next_state.time[:, None]
    return memory


def test_terms_and_tasks_may_answer_from_the_same_memory_every_time():
    core = Transport(task=Remembering(), reward={"time": remembered, "success": Success()})
    core.reset(seed=0, pose=(-0.01, 0, 0))
    infos, times, successes = [], [], []
    for _ in range(6):
        *_, done, _, info = core.step(np.ones((1, 2, 3)))
        assert core.transition is not None
        infos.append(info)
        times.append(core.transition.next_state.time.item())
        successes.append(bool(done[0]))
        if done[0]:
            core.reset(mask=done, pose=(-0.01, 0, 0))
    assert [info["reward/time"][0, 0] for info in infos] == times
    assert [bool(info["success"][0]) for info in infos] == successes


@pytest.mark.parametrize("num_envs", [None, 3], ids=["one world", "many"])
def test_gymnasium_views_hand_out_infos_of_their_own_step(num_envs):
    def run(*, late: bool) -> list[Any]:
        name = "coopenv/BeamTransport-v0"
        env: Any = (
            gymnasium.make(name, horizon=7)
            if num_envs is None
            else gymnasium.make_vec(name, num_envs=num_envs, horizon=7)
        )
        env.reset(seed=0)
        infos = []
        for action in actions(2, 12, *env.action_space.shape).astype(np.float32):
            *_, terminated, truncated, info = env.step(action)
            infos.append(info if late else dict(info))
            if num_envs is None and (terminated or truncated):
                env.reset()
        return infos

    for late, early in zip(run(late=True), run(late=False), strict=True):
        same(late, early)


def test_each_agent_is_told_of_its_own_step():
    def run(*, late: bool) -> list[Any]:
        env = PARALLEL["coopenv/BeamTransport-v0"].parallel_env(horizon=7)
        env.reset(seed=0)
        infos = []
        for action in actions(3, 7, 2, 3):
            told = env.step(parallel_actions(env, action))[4]
            infos += [info if late else dict(info) for info in told.values()]
        return infos

    for late, early in zip(run(late=True), run(late=False), strict=True):
        same(late, early)


def test_nobody_who_asks_for_no_decomposition_pays_for_one():
    core = Transport(sensing="own", reward="task")
    core.reset(seed=0)
    *_, info = core.step(np.ones((1, 2, 3)))
    assert core.transition is not None
    assert not core.transition._own
    assert info["relative_cost"].shape == (1,)
    assert core.transition._own


@pytest.mark.parametrize("keywords", [{}, {"action": "motion"}, {"cost": "contact"}])
def test_a_name_is_in_an_info_that_nobody_has_read_if_it_will_be_an_entry(keywords):
    core = Transport(**keywords)
    core.reset(seed=0)
    *_, info = core.step(np.zeros(core.action_shape))
    others = (
        "stored_energy",
        "cost",
        "cost/contact",
        "reward/nothing",
        "body/mass",
        "reward/",
        "",
        3,
    )
    found = {name: name in info for name in (*info.names(), *others)}
    entries = list(info)
    assert len(entries) > 15
    assert found == {name: name in entries for name in found}


def test_infos_that_nobody_has_read_compare_as_dictionaries_do():
    env = gymnasium.make("coopenv/BeamTransport-v0")
    env.reset(seed=0)
    one, other = (env.step(np.zeros(6, dtype=np.float32))[4] for _ in "ab")
    told = [Info.of(told_of({"success": False, "a": value})) for value in (1.0, 1.0, 2.0)]
    assert told[0] == told[1]
    assert told[0] != told[2]
    with pytest.raises(ValueError, match="ambiguous"):
        assert one == other  # of arrays, as with any dictionary


def told_of(entries: dict[str, Any]) -> Any:
    """A source of entries: a dictionary has all that one needs."""
    return entries
