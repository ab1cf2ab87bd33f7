"""Compiling ahead of time: after it, nothing is compiled by what was warmed."""

import os
import subprocess
import sys
from itertools import chain
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core import event

import coopenv
from coopenv import wrench
from coopenv.warming import decompositions, environments

LISTEN = """
from numba.core import event
class Listener(event.Listener):
    def on_start(self, event):
        print("compiles", event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
"""
IMPORT = "import coopenv; print(len(coopenv.__all__) > 20)"
WORKS = """
import sys
from coopenv.errors import CoopenvError
from coopenv.warming import decompositions, environments
names = sys.argv[1:]
for name, work in [*decompositions.works(), *environments.works()]:
    if name in names:
        work()
        print("did", name)
"""
SAMPLE = (
    "optimal of a pair on an axis",
    "optimal of a team in space",
    "prioritized_torque of a pair on an axis",
    "point_mass of a team in the plane",
    "BeamTransport-v0, action wrench, as it is",
    "BeamTransport-v0, action motion, shared senses",
    "BeamLift-v0, action wrench, all rewards",
    "WalkerTurn-v0, action impedance, as it is",
    "WalkerAvoid-v0, action wrench, partner follower",
    "BeamTransport-v0, Gymnasium",
)


class Counter(event.Listener):
    """Counts what is compiled."""

    def __init__(self):
        self.count = 0

    def on_start(self, event):
        self.count += 1

    def on_end(self, event):
        pass


def output(code: str, *arguments: str, **variables: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", LISTEN + code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | variables,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_an_import_compiles_nothing(tmp_path):
    assert output(IMPORT, NUMBA_CACHE_DIR=str(tmp_path)) == ["True"]
    assert not list(tmp_path.rglob("*.nb[ic]"))


def test_after_warming_up_a_new_process_compiles_nothing():
    output(WORKS, *SAMPLE)
    assert sorted(output(WORKS, *SAMPLE)) == sorted(f"did {name}" for name in SAMPLE)


@pytest.mark.parametrize("grips", [decompositions.ON_AN_AXIS, np.eye(3)], ids=["pair", "trio"])
def test_a_compiled_decomposer_compiles_nothing_more(grips):
    decomposer = wrench.Decomposer(grips).compile()
    size = (len(grips), 3 * grips.shape[1] - 3)
    applied = np.random.default_rng(1).normal(size=size)
    counter = Counter()
    with event.install_listener("numba:compile", counter):
        split = decomposer(applied)
        _ = split.gap, split.internal, split.relative_cost, split.load_share, split.residuals()
        assert wrench.decompose(applied, grips).manipulation.shape == applied.shape
    assert counter.count == 0


@pytest.mark.parametrize("grips", [decompositions.ON_AN_AXIS, np.eye(3)], ids=["pair", "trio"])
def test_a_control_loop_keeps_no_memory(grips):
    decomposer = wrench.Decomposer(grips).compile()
    applied = np.ones((len(grips), 3 * grips.shape[1] - 3))

    def grown() -> int:
        before = sys.getallocatedblocks()
        for _ in range(1000):
            _ = decomposer(applied).relative_cost
        return sys.getallocatedblocks() - before

    grown()
    assert grown() < 100


def test_what_is_warmed_has_a_name_of_its_own_and_is_done_or_refused():
    names = [name for name, _ in chain(decompositions.works(), environments.works())]
    assert len(names) == len(set(names))
    assert {*SAMPLE, "BeamTransport-v0, action wrench, a sensor"} <= set(names)


def test_a_report_is_told_what_is_compiled(monkeypatch):
    done, told = [], []
    monkeypatch.setattr(decompositions, "works", lambda: [("a", lambda: done.append("a"))])
    monkeypatch.setattr(environments, "works", lambda: [("b", refused)])
    found = coopenv.warmup(lambda *what: told.append(what))
    assert told == [(0, 2, "a"), (1, 2, "b")]
    assert done == ["a"]
    assert found[0] == 0
    assert found[2]


def test_where_no_kernel_can_be_kept_no_folder_is_told(monkeypatch):
    monkeypatch.setattr(decompositions, "works", list)
    monkeypatch.setattr(environments, "works", list)
    nowhere = SimpleNamespace(stats=SimpleNamespace(cache_path=None))
    monkeypatch.setattr("coopenv.warming.warming.is_finite", nowhere)
    assert coopenv.warmup()[2] is None


def refused() -> None:
    wrench.Settings(torque_weight=2.0)


def test_every_place_holds_the_team_it_is_called_after():
    shapes = {name: grips.shape for name, grips in decompositions.places().items()}
    assert {shape[-2:] for name, shape in shapes.items() if "pair" in name} == {(2, 2), (2, 3)}
    assert shapes["a pair in space"] == (2, 3)
    assert shapes["a team in the plane"] == (3, 2)
    assert shapes["a team in space"] == (3, 3)
