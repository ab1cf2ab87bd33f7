"""Every parameter under numbers of any size and things that are none: it runs, or our error."""

import warnings
from dataclasses import fields
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from coopenv import Actuators, Body, Box, Ranges, Scene, Sensor, Transport, TransportConfig, rewards
from coopenv.agents import partners
from coopenv.errors import BodyLost, CoopenvError, InvalidInput
from coopenv.observation import ranges
from coopenv.render.renderer import Renderer
from coopenv.tasks import TASKS

NOTHING = MappingProxyType({})
VALUES = [np.nan, -np.inf, 1e300, 1e-300, -1e300, 10**400, 10**30, 10**9, "1.0", 1 + 0j]
VALUES += [np.timedelta64(1, "s"), {}, (1e300, 1e300), (np.nan, 1.0), object(), np.zeros(3)]


def ran(**keywords) -> None:
    """Three steps; whatever they show is finite."""
    core = Transport(num_worlds=2, **keywords)
    core.reset(seed=0)
    for _ in range(3):
        seen, reward, *_, info = core.step(np.ones((2, len(core.learners), core.action_size)))
        assert np.isfinite(seen).all()
        assert np.isfinite(reward).all()
        assert np.isfinite(info["internal_wrench"]).all()
        assert np.isfinite(info["contact_impulse"]).all()


def of_environment(
    kind, keyword, wrap=lambda made: made, beside: Any = MappingProxyType({}), **base
):
    """Every field of a dataclass, as a function of its value that runs an environment."""
    for entry in fields(kind):

        def run(value, name=entry.name):
            made = kind(**{**base, name: value})
            ran(**{keyword: wrap(made)}, **beside)

        yield f"{kind.__name__}.{entry.name}", run


def of_walkers(kind):
    for entry in fields(kind):

        def run(value, name=entry.name):
            ran(task=kind(**{name: value}), body=Body.walker(), scene=Scene(size=(9.0, 9.0)))

        yield f"{kind.__name__}.{entry.name}", run


def cases():
    yield from of_environment(Body, "body")
    yield from of_environment(Scene, "scene")
    box = {"center": (2.5, 2.5), "size": (0.2, 0.2)}
    yield from of_environment(Box, "scene", lambda made: Scene(obstacles=(made,)), **box)
    yield from of_environment(Ranges, "randomise")
    yield from of_environment(Actuators, "actuators")
    yield from of_environment(Sensor, "observe", lambda made: (made,), block="goal")
    for entry in fields(TransportConfig):
        yield f"config.{entry.name}", lambda value, name=entry.name: ran(**{name: value})
    for kind in TASKS:
        yield from of_walkers(kind) if "Walker" in kind.__name__ else of_environment(kind, "task")
    for name in ("num_rays", "reach", "field_of_view", "heading"):
        yield f"rays.{name}", lambda value, name=name: ran(observe=(ranges(**{name: value}),))
    for name in rewards.__all__:
        kind = getattr(rewards, name)
        if hasattr(kind, "__dataclass_fields__"):
            needed = {"discount": 1.0, "potential": lambda state: -state.distance}
            yield from of_environment(
                kind,
                "reward",
                beside={"action": "motion"} if getattr(kind, "needs_hands", False) else {},
                **needed if name == "PotentialShaping" else {},
            )
    for name in partners.__all__:
        kind = getattr(partners, name)
        if hasattr(kind, "__dataclass_fields__") and kind is not partners.Kind:
            needed = {"path": "no/policy.zip"} if name == "LearnedPartner" else {}
            yield from of_environment(kind, "partner", **needed)
    body, scene = [Body()], [Scene()]
    for name in ("width", "world", "fps"):
        yield (
            f"picture.{name}",
            lambda value, name=name: Renderer(body, scene, **{name: value}).close(),
        )
    for name in ("radius", "sides", "size", "num_agents"):
        yield f"plate.{name}", lambda value, name=name: Body.plate(**{name: value})
    for name in ("length", "width"):
        yield f"beam.{name}", lambda value, name=name: ran(body=Body.beam(**{name: value}))
    yield "num_worlds", lambda value: Transport(num_worlds=value)


CASES = dict(cases())


@pytest.mark.parametrize("run", CASES.values(), ids=CASES)
def test_a_parameter_of_any_value_runs_or_is_refused_by_our_error(run):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for value in VALUES:
            said = refusal(run, value)
            assert said is None or (" must " in said and ", got " in said)


def refusal(run, value) -> str | None:
    """What our error says; any other one is raised."""
    try:
        run(value)
    except CoopenvError as error:
        return str(error)
    return None


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"scene": {"obstacles": 3}}, "scene.obstacles must be a sequence of Box objects, got 3"),
        ({"dt": 1e300}, r"dt must be at most 10000, got 1e\+300"),
        ({"dt": 1e-300}, r"dt must be at least 1e-09, got 1e-300"),
        ({"horizon": 10**30}, "horizon must be at most 1000000000, got 1000000000000000000000000"),
        ({"substeps": 10**9}, "substeps must be at most 10000, got 1000000000"),
        ({"num_worlds": 10**9}, "num_worlds must be at most 1000000, got 1000000000"),
        ({"force_limit": 1e300}, r"force_limit must be positive, .* at most 1e\+12"),
        ({"randomise": {"mass": (1e-300, 1.0)}}, "randomise.mass must not begin below 1e-15"),
        ({"body": {"mass": 1e-300}}, "body.mass must be at least 1e-15, got 1e-300"),
        ({"body": {"mass": "7.7"}}, "body.mass must be a number, got '7.7'"),
        ({"reward": rewards.Effort(weight=10**30)}, r"weight of reward '\w+' must be at most"),
    ],
)
def test_numbers_without_measure_are_refused_by_name(keywords, said):
    with pytest.raises(InvalidInput, match=said):
        Transport(**keywords)


@pytest.mark.parametrize(
    "keywords",
    [
        {"hands": {"stiffness": True}, "action": "motion"},
        {"hands": {"stiffness_factors": (True, 2.0)}, "action": "impedance"},
        {"body": {"grips": ((-0.9, False), (0.9, 0.0))}},
        {"body": {"outline": ((-1, True), (-1, -1), (1, -1), (1, 1))}},
        {"body": {"mass": True}},
        {"scene": {"size": (True, 6.0)}},
        {"scene": {"gravity": (0.0, True)}},
        {"force_limit": True},
        {"torque_limit": (5.0, True)},
        {"randomise": {"mass": (True, 9.0)}},
        {"pushes": ((0, 0, False), (1, 0, 0)), "action": "discrete"},
        {"actuators": {"time_constant": True}},
    ],
    ids=str,
)
def test_true_and_false_are_refused_as_numbers_of_an_environment(keywords):
    with pytest.raises(
        InvalidInput, match=r" must be (made of numbers|a number), got .*(Tru|Fals)e"
    ):
        Transport(**keywords)


def test_delays_and_pictures_without_measure_are_refused():
    with pytest.raises(InvalidInput, match=r"sensor.delay must be at most 10000, got 1000000000"):
        Sensor("goal", delay=10**9)
    with pytest.raises(InvalidInput, match="width must be at most 16384, got 1000000000"):
        Renderer([Body()], [Scene()], width=10**9)


def test_a_body_that_got_lost_can_be_reset():
    core = Transport(num_worlds=2, force_limit=1e12)
    first, _ = core.reset(seed=0)
    with pytest.raises(BodyLost):
        core.step(np.random.default_rng(0).uniform(-1, 1, (2, 2, 3)))
    again, _ = core.reset(seed=0)
    np.testing.assert_array_equal(again, first)
    core.step(np.zeros((2, 2, 3)))
