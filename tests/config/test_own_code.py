"""Code of one's own in JSON: named, hashed, and imported only where it is trusted."""

import functools
import json
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from coopenv import Block, Sensor, Transport, TransportConfig, TransportTask, rewards
from coopenv.config import own_code
from coopenv.errors import InvalidInput

SOURCE = '''
"""A task, a partner, a term, a potential and a block of one's own."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import coopenv

Path(__file__).with_suffix(".imported").touch()


@dataclass(frozen=True, kw_only=True)
class Near(coopenv.TransportTask):
    """A `coopenv.TransportTask` with one field more."""

    kind: str = "near"  # a name that the text uses too


@dataclass(frozen=True, kw_only=True)
class Pusher:
    """Pushes with a constant force."""

    force: tuple[float, float] = (1.0, 0.0)

    def player(self, config, num_worlds, agents):
        return Pushing(self.force, num_worlds, len(agents))


class Pushing:
    """A `Pusher` at work."""

    def __init__(self, force, num_worlds, count):
        self.kind = np.zeros(num_worlds, dtype=np.int64)
        self._wrench = np.tile([*force, 0.0], (num_worlds, count, 1))

    def reset(self, worlds, generators, start):
        pass

    def act(self, transition):
        return self._wrench

    def plan(self, transition):
        return np.full((len(self.kind), 3), np.nan)


@dataclass(frozen=True)
class Speed:
    """A price on speed."""

    weight: float = 0.5

    def __call__(self, transition):
        speed = np.hypot(*transition.next_state.twist[:, :2].T)
        return transition.per_agent(speed, -self.weight)


def lateness(transition):
    return transition.per_agent(transition.next_state.time, -0.01)


class Named:
    @staticmethod
    def closeness(state):
        return -2.0 * state.distance


def spin(transition):
    return transition.per_agent(transition.next_state.twist[:, 2], 1.0)[..., None]
'''


def config_of(mine: Any) -> TransportConfig:
    terms = {
        "speed": mine.Speed(weight=0.25),
        "late": mine.lateness,
        "near": rewards.PotentialShaping(potential=mine.Named.closeness, discount=0.9),
    }
    spin = Block(name="spin", size=1, describe="spin", read=mine.spin)
    return TransportConfig(
        task=mine.Near(kind="far", clearance=0.2),
        reward=rewards.RewardSum(terms),
        observe=("goal", Sensor(spin, noise=0.1)),
        partner=mine.Pusher(force=(2.0, 1.0)),
    )


@pytest.fixture
def path(tmp_path, monkeypatch):
    path = tmp_path / "mine_of_the_test.py"
    path.write_text(SOURCE)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield path
    sys.modules.pop(path.stem, None)


@pytest.fixture
def mine(path):
    return __import__(path.stem)


@pytest.fixture
def text(mine, path):
    """The text of a configuration with code that is not imported any more."""
    text = config_of(mine).to_json()
    del sys.modules[path.stem]
    path.with_suffix(".imported").unlink()
    return text


@pytest.mark.parametrize("trust", [True, "mine_of_the_test", ("other", "mine_of_the_test")])
def test_trusted_code_comes_back_equal(mine, trust):
    config = config_of(mine)
    again = TransportConfig.from_json(config.to_json(), trust=trust)
    assert again == config
    assert again.to_json() == config.to_json()


def test_trusted_code_is_imported_and_does_the_same(text, mine):
    there = []
    for config in (TransportConfig.from_json(text, trust=True), config_of(mine)):
        core = Transport(num_worlds=2, config=config)
        core.reset(seed=3)
        there += [[core.step(np.full((2, 1, 3), 0.3))[:2] for _ in range(4)]]
    for first, second in zip(*there, strict=True):
        for one, other in zip(first, second, strict=True):
            np.testing.assert_array_equal(one, other)


def test_the_text_names_code_with_a_hash_of_its_file(mine):
    document = json.loads(config_of(mine).to_json())
    task = document["task"]
    assert task["kind"] == "mine_of_the_test:Near"
    assert task["fields"]["kind"] == "far"
    assert len(task["sha256"]) == 64
    function = document["reward"]["terms"][1]["term"]
    assert function == {**function, "kind": "function", "name": "mine_of_the_test:lateness"}


@pytest.mark.parametrize("trust", [False, (), ("mine",), "mine_of_the_test.part"])
def test_nothing_is_imported_without_trust(text, path, trust):
    with pytest.raises(InvalidInput, match=r"task must be of coopenv unless you trust the text"):
        TransportConfig.from_json(text, trust=trust)
    assert path.stem not in sys.modules
    assert not path.with_suffix(".imported").exists()


def test_what_is_imported_already_is_not_trusted_for_that(mine):
    with pytest.raises(InvalidInput, match=r"pass trust=\('mine_of_the_test',\)"):
        TransportConfig.from_json(config_of(mine).to_json())


def test_code_that_has_changed_is_refused_before_it_runs(text, path):
    path.write_text(SOURCE.replace("0.01", "0.02"))
    with pytest.raises(InvalidInput, match=r"mine_of_the_test.py has changed since: sha256 '\w+'"):
        TransportConfig.from_json(text, trust=True)
    assert not path.with_suffix(".imported").exists()
    old, new = json.loads(text)["task"]["sha256"], own_code.read_hash(path)
    TransportConfig.from_json(text.replace(old, new), trust=True)


def test_line_ends_make_no_difference(text, path):
    path.write_bytes(SOURCE.replace("\n", "\r\n").encode())
    TransportConfig.from_json(text, trust=True)


def test_code_that_is_not_there_any_more_is_refused(text, path):
    path.write_text("raise RuntimeError('no')\n")
    changed = text.replace(json.loads(text)["task"]["sha256"], own_code.read_hash(path))
    with pytest.raises(InvalidInput, match="RuntimeError: no"):
        TransportConfig.from_json(changed, trust=True)
    path.write_text("spin = Near = None\n")
    changed = text.replace(json.loads(text)["task"]["sha256"], own_code.read_hash(path))
    with pytest.raises(InvalidInput, match=r"task must be in .*mine_of_the_test.py"):
        TransportConfig.from_json(changed, trust=True)
    sys.modules.pop(path.stem, None)
    path.unlink()
    with pytest.raises(InvalidInput, match="there is no source file of 'mine_of_the_test'"):
        TransportConfig.from_json(text, trust=True)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("os:environ", "must be a function"),
        ("subprocess:Popen", "must be a function"),
        ("math:sin", "no source file"),
        (":x", "no source file"),
        ("no.such.module:x", "no source file"),
        ("json.decoder:", "must be in"),
        ("json.decoder:missing", "must be in"),
    ],
)
def test_a_name_of_what_is_no_function_of_a_file_is_refused(name, said):
    path = getattr(sys.modules.get(name.partition(":")[0]), "__file__", None)
    term = {
        "kind": "function",
        "name": name,
        "sha256": own_code.read_hash(path) if path and path.endswith(".py") else "",
    }
    text = json.dumps(
        {
            "kind": "coopenv.TransportConfig",
            "version": 1,
            "reward": {
                "kind": "coopenv.rewards.RewardSum",
                "terms": [{"name": "x", "term": term}],
            },
        }
    )
    with pytest.raises(InvalidInput, match=said):
        TransportConfig.from_json(text, trust=True)
    with pytest.raises(InvalidInput, match="unless you trust the text"):
        TransportConfig.from_json(text)


@dataclass
class Mutable:
    """A term that is not frozen."""

    def __call__(self, transition):
        return transition.per_agent(0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Itself:
    """A term that equals nothing but itself."""

    def __call__(self, transition):
        return transition.per_agent(0.0, 1.0)


@dataclass(frozen=True)
class Holds:
    """A term with a field of any kind."""

    value: Any

    def __call__(self, transition):
        return transition.per_agent(0.0, 1.0)

    def method(self, transition):
        return self(transition)


def term(transition):
    return transition.per_agent(0.0, 1.0)


def closure():
    def inner(transition):
        return term(transition)

    return inner


def local():
    @dataclass(frozen=True)
    class Local(TransportTask):
        pass

    return Local()


def of_the_script(name="__main__"):
    """A term as it is where its file is run."""

    def made(transition):
        return term(transition)

    made.__module__, made.__qualname__ = name, "made"
    return made


@pytest.mark.parametrize(
    ("part", "value", "said"),
    [
        ("reward", lambda transition: term(transition), "not as a lambda"),
        ("reward", closure(), "not in a function"),
        ("reward", of_the_script(), "not in the script that runs"),
        ("reward", of_the_script("__mp_main__"), "not in the script that runs"),
        ("reward", functools.partial(term), "reward.partial must be something that a file"),
        ("reward", Holds(1).method, "reward.method must be something"),
        ("reward", Mutable(), "reward.Mutable must be a frozen dataclass"),
        ("reward", Itself(), "reward must compare by value"),
        ("reward", Holds({"a": 1}), "reward.Holds.value must be made of numbers"),
        ("reward", Holds(np.zeros(2)), "reward.Holds.value must be made of numbers"),
        ("reward", Holds(float("nan")), "reward.Holds.value must be made of numbers"),
        ("reward", Holds((1, (2, object()))), r"reward.Holds.value\[1\]\[1\] must be made of"),
        ("task", local(), "task must be something that a file can name"),
    ],
)
def test_what_a_file_cannot_name_is_refused_by_its_part(part, value, said):
    with pytest.raises(InvalidInput, match=said):
        TransportConfig(**{part: value}).to_json()


def test_values_of_ones_own_fields_come_back_with_their_types():
    value = (1, 2.0, True, None, "text", [1, [2.5]], float("inf"), -float("inf"), term)
    config = TransportConfig(reward=rewards.RewardSum({"holds": Holds(value)}))
    again = TransportConfig.from_json(config.to_json(), trust=__name__).terms["holds"].value  # pyright: ignore
    assert again == value
    assert [type(item) for item in again] == [type(item) for item in value]
