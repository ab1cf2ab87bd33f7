"""Ids of one's own, and how an id is turned into a configuration."""

import json
import sys
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
import pytest
from gymnasium.envs.registration import EnvSpec

import coopenv
from coopenv import Body, Transport, TransportConfig, TransportTask
from coopenv.cli import main
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from coopenv.tasks import TASKS
from tests.helpers import IDS, PARALLEL

PETTINGZOO_LISTS = hasattr(pettingzoo, "make")  # from 1.27 on

MODULE = """
from dataclasses import dataclass
import coopenv

@dataclass(frozen=True, kw_only=True)
class Lift(coopenv.TransportTask):
    height: float = 1.0

lift = coopenv.register("{name}/Lift-v0", task=Lift(height=2.0), body=coopenv.Body.plate(3))
heavy = coopenv.register("{name}/Heavy-v0", task=Lift(), horizon=20)
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """The name of a module that registers two ids and was not imported yet."""
    name = "lifts"
    (tmp_path / f"{name}.py").write_text(MODULE.format(name=name))
    monkeypatch.syspath_prepend(tmp_path)
    yield name
    sys.modules.pop(name, None)
    forget(f"{name}/")


@pytest.fixture
def registered():
    """The views of an id that this file registers."""
    yield coopenv.register("here/Plate-v0", body=Body.plate(4), horizon=30)
    forget("here/")


def forget(prefix):
    registries = [gymnasium.registry]
    if PETTINGZOO_LISTS:
        registries += [pettingzoo.parallel_registry, pettingzoo.aec_registry]
    for registry in registries:
        for known in [known for known in registry if known.startswith(prefix)]:
            del registry[known]


@pytest.mark.skipif(not PETTINGZOO_LISTS, reason="this PettingZoo has no registry")
@pytest.mark.parametrize("view", IDS)
def test_pettingzoo_makes_every_id(view):
    parallel: Any = pettingzoo.make("parallel", view, horizon=7)
    turns: Any = pettingzoo.make("aec", view, max_cycles=9)
    assert parallel.transport.config == find_config(view, {"horizon": 7})
    assert turns.unwrapped.transport.config == find_config(view, {"horizon": 9})
    assert isinstance(parallel, pettingzoo.ParallelEnv)
    assert isinstance(turns, pettingzoo.AECEnv)


@pytest.mark.skipif(not PETTINGZOO_LISTS, reason="this PettingZoo has no registry")
def test_pettingzoo_makes_an_id_of_ones_own(registered):
    parallel: Any = pettingzoo.make("parallel", "here/Plate-v0")
    turns: Any = pettingzoo.make("aec", "here/Plate-v0", horizon=5)
    assert parallel.possible_agents == registered.parallel_env().possible_agents
    assert (parallel.transport.horizon, turns.unwrapped.transport.horizon) == (30, 5)


@pytest.mark.skipif(not PETTINGZOO_LISTS, reason="this PettingZoo has no registry")
def test_one_call_enters_an_id_in_both_registries_or_in_none():
    everywhere = gymnasium.registry, pettingzoo.parallel_registry, pettingzoo.aec_registry
    coopenv.register("here/Both-v0", horizon=4)
    try:
        assert all("here/Both-v0" in registry for registry in everywhere)
        with pytest.warns(UserWarning, match="Overriding"):
            coopenv.register("here/Both-v0", horizon=6)  # again, as where a module is read anew
        parallel: Any = pettingzoo.make("parallel", "here/Both-v0")
        single: Any = gymnasium.make("here/Both-v0")
        assert parallel.transport.horizon == single.unwrapped.transport.horizon == 6
        with pytest.raises(InvalidInput, match="horizon must be"):
            coopenv.register("here/None-v0", horizon=0)
        assert not any("here/None-v0" in registry for registry in everywhere)
    finally:
        forget("here/")


def test_an_id_with_its_module_imports_it_in_gymnasium_and_here(module):
    env = gymnasium.make(f"{module}:{module}/Lift-v0", horizon=7)
    core = env.unwrapped.transport  # pyright: ignore[reportAttributeAccessIssue]
    assert (core.num_agents, core.horizon, core.config.task.height) == (3, 7, 2.0)
    config = find_config(f"{module}:{module}/Heavy-v0", {"dt": 0.1})
    assert (config.horizon, config.dt, config.num_agents) == (20, 0.1, 2)


def test_every_view_starts_from_the_defaults_of_the_id_and_takes_keywords(registered):
    name = "here/Plate-v0"
    for env in (
        gymnasium.make(name, dt=0.1),
        gymnasium.make_vec(name, num_envs=2, dt=0.1),
        registered.parallel_env(dt=0.1),
        registered.env(dt=0.1),
        registered.single_env(dt=0.1),
        registered.vector_env(2, dt=0.1),
    ):
        core = env.unwrapped.transport  # pyright: ignore[reportAttributeAccessIssue]
        assert (core.num_agents, core.horizon, core.dt) == (4, 30, 0.1)
    assert gymnasium.make(name, render_mode="rgb_array").render_mode == "rgb_array"


def test_a_module_that_keeps_the_views_is_where_gymnasium_finds_them(tmp_path, monkeypatch):
    """As the modules of this package do, by the same function."""
    (tmp_path / "plates_v0.py").write_text(
        "import coopenv\n"
        "parallel_env, env, single_env, vector_env = coopenv.register(\n"
        '    "plates/Plates-v0", module=__name__, body=coopenv.Body.plate(3), horizon=9)\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    made = gymnasium.make("plates_v0:plates/Plates-v0").unwrapped
    plates = sys.modules["plates_v0"]
    try:
        spec = gymnasium.spec("plates/Plates-v0")
        assert spec.entry_point == "plates_v0:single_env"
        assert not spec.kwargs
        for env in (made, plates.parallel_env().unwrapped, plates.vector_env(2)):
            core = env.transport  # pyright: ignore[reportAttributeAccessIssue]
            assert (core.num_agents, core.horizon) == (3, 9)
        assert str(plates.parallel_env()) == "plates_v0"
        if PETTINGZOO_LISTS:
            parallel: Any = pettingzoo.make("parallel", "plates/Plates-v0")
            turns: Any = pettingzoo.make("aec", "plates/Plates-v0")
            for other in (parallel, turns.unwrapped):
                assert str(other) == "plates_v0"
                assert other.transport.config == plates.vector_env(2).transport.config
        beam = gymnasium.spec("coopenv/BeamTransport-v0")
        assert beam.entry_point == "coopenv.beam_transport_v0:single_env"
        assert not beam.kwargs
    finally:
        sys.modules.pop("plates_v0")
        forget("plates/")


def test_a_module_that_is_no_name_is_refused():
    with pytest.raises(InvalidInput, match="module must be the name of a module"):
        coopenv.register("here/Nothing-v0", module=3)  # pyright: ignore[reportArgumentType]
    assert "here/Nothing-v0" not in gymnasium.registry


def test_an_id_of_ones_own_comes_back_from_json(module):
    __import__(module)
    lift = sys.modules[module].Lift
    for keywords in ({}, {"task": lift(height=3.0)}, {"horizon": 4, "reward": "harmony"}):
        env = gymnasium.make(f"{module}/Lift-v0", **keywords)
        assert env.spec is not None
        text = env.spec.to_json()
        assert json.loads(text)["kwargs"]["registered"] == f"{module}:{module}/Lift-v0"
        again = gymnasium.make(EnvSpec.from_json(text))
        wanted = env.unwrapped.transport.config  # pyright: ignore[reportAttributeAccessIssue]
        assert again.unwrapped.transport.config == wanted  # pyright: ignore[reportAttributeAccessIssue]
    vector = gymnasium.make_vec(f"{module}/Lift-v0", num_envs=2)
    assert vector.spec is not None
    again = gymnasium.make_vec(EnvSpec.from_json(vector.spec.to_json()))
    np.testing.assert_array_equal(again.reset(seed=1)[0], vector.reset(seed=1)[0])


class Other(TransportTask):
    """As a `TransportTask`, but called otherwise."""


class Bare(coopenv.Task):
    """A task that is no dataclass."""

    def check(self, body, scene):
        pass

    def sample(self, generator, body, scene):
        return (0.0, 0.0, 0.0), (1.0, 1.0, 0.0)

    def distance(self, pose, goal):
        return np.hypot(*(pose - goal)[:, :2].T)

    def success(self, pose, twist, goal):
        return self.distance(pose, goal) < 0.1


@pytest.mark.parametrize(
    "keywords",
    [
        {"task": Other()},
        {"task": Other(clearance=0.3)},
        {"task": Bare()},
        {"reward": {"time": lambda transition: transition.per_agent(0.0, 1.0)}},
    ],
)
def test_what_would_come_back_different_is_not_written(keywords):
    env = gymnasium.make(IDS[0], **keywords)
    assert env.spec is not None
    with pytest.raises((TypeError, ValueError), match=r"JSON|reward must|observe must"):
        env.spec.to_json()


def test_an_id_that_is_unknown_or_not_ours_is_refused(registered):
    for name in ("coopenv/BeamTransprt-v0", "CartPole-v1", "here/Plat-v0"):
        with pytest.raises(UnknownName, match="env must be one of the known names"):
            find_config(name, {})
    with pytest.raises(UnknownName, match="did you mean 'here/Plate-v0'"):
        find_config("here/Plat-v0", {})
    with pytest.raises(InvalidInput, match="the module of an id must be importable, got 'nowhere'"):
        find_config("nowhere:mine/Lift-v0", {})


def test_the_command_line_says_so(capsys):
    pytest.importorskip("tyro")
    assert main(["evaluate", "random", "--env", "nowhere:mine/Lift-v0"]) == 1
    assert "must be importable, got 'nowhere'" in capsys.readouterr().err


def test_defaults_that_make_no_configuration_are_refused_when_they_are_registered():
    with pytest.raises(InvalidInput, match="horizon must be"):
        coopenv.register("here/Wrong-v0", horizon=0)
    with pytest.raises(UnknownName, match="did you mean 'task'"):
        coopenv.register("here/Wrong-v0", tsk=TransportTask())
    with pytest.raises(InvalidInput, match="id must be a name without a colon"):
        coopenv.register("here:Wrong-v0")
    assert "here/Wrong-v0" not in gymnasium.registry


def test_our_own_ids_are_found_with_their_keywords():
    for name in IDS:
        core = gymnasium.make(name, horizon=9).unwrapped.transport  # pyright: ignore[reportAttributeAccessIssue]
        assert find_config(name, {"horizon": 9}) == core.config
        assert isinstance(core, Transport)


def test_the_task_of_each_of_our_ids_can_be_named_in_json_and_imported():
    for name in IDS:
        kind = type(find_config(name, {}).task)
        assert kind in TASKS
        assert getattr(coopenv, kind.__name__) is kind


def test_the_module_of_each_of_our_ids_holds_its_entry_points():
    for name, module in PARALLEL.items():
        spec = gymnasium.spec(name)
        holder = module.__name__
        assert spec.entry_point == f"{holder}:single_env"
        assert spec.vector_entry_point == f"{holder}:vector_env"
        assert spec.kwargs == {}
        assert module.parallel_env().metadata["name"] == holder.removeprefix("coopenv.")
        assert find_config(name, {}) == TransportConfig.parse({}, module.DEFAULTS)
