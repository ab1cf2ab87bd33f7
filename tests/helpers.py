"""What several test modules share."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import coopenv
from coopenv import (
    BLOCKS,
    Actuators,
    Body,
    Box,
    DoorwayTask,
    Hands,
    LiftTask,
    Ranges,
    Reference,
    Scene,
    Sensor,
    TrackingTask,
    Transport,
    TransportTask,
    WalkerAvoidTask,
    WalkerTurnTask,
)
from coopenv.observation import ranges
from coopenv.rewards import PRESETS
from coopenv.wrench import METHODS, Settings

PARALLEL: dict[str, ModuleType] = {  # every registered id and its PettingZoo module
    "coopenv/BeamTransport-v0": coopenv.beam_transport_v0,
    "coopenv/BeamDoorway-v0": coopenv.beam_doorway_v0,
    "coopenv/BeamTracking-v0": coopenv.beam_tracking_v0,
    "coopenv/WalkerAvoid-v0": coopenv.walker_avoid_v0,
    "coopenv/WalkerTurn-v0": coopenv.walker_turn_v0,
    "coopenv/BeamLift-v0": coopenv.beam_lift_v0,
}
IDS = list(PARALLEL)
LEVEL = [view for view in IDS if "Lift" not in view]  # else what lies on the floor touches it

BLIND_TO_HANDS = tuple(  # the blocks that there are under every action
    name for name, block in BLOCKS.items() if not block.needs_hands
)
OPEN_ROOM = Scene(size=(80.0, 80.0))  # [m]; nothing to touch within a test
NEVER = TransportTask(position_tolerance=1e-9)  # cannot succeed
EASY = TransportTask(  # random motion succeeds now and then
    position_tolerance=1.5, angle_tolerance=1.0, speed_tolerance=5.0, spin_tolerance=5.0
)
_EASY_WALK: dict[str, Any] = {
    "position_tolerance": 2.5, "angle_tolerance": 2.0, "speed_tolerance": 5.0, "spin_tolerance": 5.0
}  # fmt: skip
EASY_TASKS = {  # the same on each id's own task
    "coopenv/BeamTransport-v0": EASY,
    "coopenv/BeamDoorway-v0": DoorwayTask(
        position_tolerance=5.1, angle_tolerance=2.4, speed_tolerance=5.0, spin_tolerance=5.0
    ),
    "coopenv/BeamTracking-v0": TrackingTask(
        position_tolerance=1.5,
        angle_tolerance=1.0,
        speed_tolerance=0.1,
        spin_tolerance=0.2,
        mean_tolerance=5.0,
        duration=0.1,
    ),
    "coopenv/WalkerAvoid-v0": WalkerAvoidTask(**{**_EASY_WALK, "position_tolerance": 4.2}),
    "coopenv/WalkerTurn-v0": WalkerTurnTask(**_EASY_WALK),
    "coopenv/BeamLift-v0": LiftTask(
        position_tolerance=4.8,
        height_tolerance=5.0,
        angle_tolerance=0.4,
        speed_tolerance=1.0,
        spin_tolerance=5.0,
    ),
}
CLUTTERED = Scene(
    size=(7.0, 6.5),
    obstacles=(
        Box(center=(1.5, 1.5), size=(0.6, 0.4), angle=0.5),
        Box(center=(-2.0, -1.0), size=(0.5, 0.5)),
    ),
)
TRIO = Body(grips=((-0.9, 0.0), (0.3, 0.05), (0.9, -0.05)))
QUINTET = Body.beam(
    length=1.6,
    width=0.4,
    mass=12.0,
    grips=((-0.8, 0.2), (-0.8, -0.2), (0.0, 0.0), (0.8, 0.2), (0.8, -0.2)),
)

WIDE = Ranges(  # everything there is, for any of the bodies of the tests
    mass=(5.0, 12.0),
    inertia=(1.0, 3.0),
    linear_drag=(4.0, 12.0),
    angular_drag=(4.0, 12.0),
    friction=(0.0, 0.5),
    length=(1.4, 2.2),
    grips=((-0.04, 0.04), (-0.02, 0.02)),
    force_limit=(8.0, 12.0),
    torque_limit=(3.0, 6.0),
    logarithmic=("mass",),
)
ALONG = replace(WIDE, grips=((-0.04, 0.04), (0.0, 0.0)))  # grips stay on the beam's axis

FORCES_ONLY = ("max_internal", "net_force", "one_dimensional")  # raise where torque is applied

# Every documented option at least once, by a name that reads in the test's id.
OPTIONS: dict[str, dict[str, Any]] = {
    "defaults": {},
    "forces": {"action": "force"},
    "discrete": {"action": "discrete", "bounded": True, "cost": "squeeze"},
    "motion": {"action": "motion", "bounded": True},
    "impedance": {"action": "impedance", "hands": Hands(stiffness=(100.0, 200.0), speed=0.6)},
    "drawn hands": {
        "action": "motion",
        "randomise": replace(WIDE, stiffness=(50.0, 200.0), damping=(10.0, 40.0)),
        "substeps": 4,
    },
    "actuators": {
        "actuators": Actuators(delay=(1, 2), time_constant=0.1, rate_limit=(None, 6.0)),
        "partner": "leader",
    },
    "drawn actuators": {
        "randomise": replace(WIDE, delay=(0, 3), time_constant=(0.0, 0.2), rate_limit=(2.0, 9.0))
    },
    "own pushes": {"action": "discrete", "pushes": ((0, 0, 0), (0.5, 0, 0.2), (0, -1, 0))},
    "bounded": {"bounded": True, "observe": BLIND_TO_HANDS},
    "cost": {"cost": {"jerk": coopenv.rewards.ActionRate(), "load": coopenv.rewards.LoadShare()}},
    "every block": {"observe": BLIND_TO_HANDS},
    **{f"observe {name}": {"observe": (name,)} for name in BLIND_TO_HANDS},
    "every block of hands": {"action": "motion", "observe": tuple(BLOCKS), "bounded": True},
    "own senses of hands": {"action": "impedance", "sensing": "own", "cost": "stored_energy"},
    "own senses": {"sensing": "own"},
    "shared senses": {"sensing": "shared", "scene": CLUTTERED},
    "imperfect senses": {
        "observe": (
            Sensor("goal", noise=0.01, delay=3),
            Sensor("twist", noise=(0.02, 0.02, 0.05), bias=0.01, delay=1),
            Sensor("obstacles", noise=0.05, bias=0.02),
            "known",
        ),
        "informed": (0,),
    },
    "other rays": {
        "observe": (
            ranges(num_rays=5, reach=2.0, field_of_view=1.5, heading=np.pi),
            Sensor(ranges(num_rays=4, where="centre", whose="partners"), delay=2),
        ),
        "scene": CLUTTERED,
    },
    **{f"reward {name}": {"reward": name} for name in PRESETS},
    "one term": {"reward": coopenv.rewards.Success()},
    "own sum": {
        "reward": {"near": coopenv.rewards.Progress(), "load": coopenv.rewards.LoadShare()}
    },
    **{
        f"decompose {method}": {"decomposition": Settings(method=method)}
        for method in METHODS
        if method not in ("optimal", *FORCES_ONLY)
    },
    "induced torque": {"decomposition": Settings(include_induced=True, torque_weight=0.3)},
    "conic": {"decomposition": Settings(solver="conic"), "horizon": 20},
    "coarse steps": {"dt": 0.1, "substeps": 1},
    "fine steps": {"dt": 0.02, "substeps": 7},
    "short horizon": {"horizon": 5},
    "cluttered": {"scene": CLUTTERED},
    "small heavy body": {"body": Body.beam(length=1.0, mass=30.0, friction=0.0, linear_drag=0.0)},
    "uneven limits": {"force_limit": (10.0, 40.0), "torque_limit": (1.0, 5.0)},
    "other task": {"task": TransportTask(position_tolerance=0.5, clearance=0.3, min_distance=2.0)},
    "one agent": {"body": Body(grips=((0.4, 0.0),))},
    "three agents": {"body": TRIO},
    "plate of four": {"body": Body.plate(4)},
    "randomised": {"randomise": ALONG},
    "rough ground": {"randomise": Ranges(ground_friction=(0.0, 0.2))},
    "randomised plate": {"body": Body.plate(3), "randomise": WIDE, "observe": ("goal", "body")},
    "partner": {"partner": "population", "horizon": 10},
    "two of three driven": {"body": TRIO, "partner": "noisy", "partner_agents": (0, 2)},
    "five agents": {"body": QUINTET, "scene": CLUTTERED, "observe": BLIND_TO_HANDS},
}

LOOP = Reference(  # [s], [m, m, rad]
    times=(0.0, 2.0, 4.0, 6.0), poses=((0, 0, 0), (1, 0, 1), (1, 1, 3), (0, 0, 3.5))
)

UPRIGHT = Scene(size=(8.0, 5.0), gravity=(0.0, -9.81))


def room(view: str, scene: Scene) -> Scene:
    """A scene for an id: upright and long enough where something is to be lifted."""
    if "Lift" not in view:
        return scene
    return replace(scene, gravity=UPRIGHT.gravity, size=(max(scene.size[0], 8.0), scene.size[1]))


# What an id documents beside them.
OWN_OPTIONS: dict[str, dict[str, dict[str, Any]]] = {
    "coopenv/BeamDoorway-v0": {
        "guide one": {"task": DoorwayTask(guide="one")},
        "guide none": {"task": DoorwayTask(guide="none"), "observe": ("goal", "known", "gap")},
        "guide agent 1": {"task": DoorwayTask(guide=1)},
        "guide several": {"task": DoorwayTask(guide=(1, 0))},
        "wide gap": {"task": DoorwayTask(gap=(2.2, 2.4), gap_position=(-0.5, 0.5))},
        "own platforms": {
            "scene": Scene(size=(9.0, 5.0)),
            "task": DoorwayTask(
                start_platform=((-4.4, -2.4), (-2.0, 0.0)),
                goal_platform=((2.0, 0.0), (4.4, 2.4)),
                wall=(-0.5, 0.5),
                wall_thickness=0.4,
            ),
        },
        "observe gap": {"observe": ("gap",)},
    },
    "coopenv/BeamTracking-v0": {
        **{
            f"reference {kind}": {"task": TrackingTask(reference=kind)}
            for kind in ("rotate", "rotate_translate", "translate")
        },
        "reference in turn": {"task": TrackingTask(reference=("rotate", "translate"))},
        "reference table": {"task": TrackingTask(reference=LOOP)},
        "one preview": {"task": TrackingTask(preview=(0.4,), segments=1, duration=4.0)},
        "observe preview": {"observe": ("preview", "reference_twist")},
        "told to one": {"informed": (1,)},
    },
    "coopenv/WalkerAvoid-v0": {
        "three obstacles": {"task": WalkerAvoidTask(obstacles=3, obstacle_size=(0.3, 0.5))},
        "both are told": {"informed": None},
    },
    "coopenv/WalkerTurn-v0": {
        "gentle turns": {"task": WalkerTurnTask(path_length=(1.0, 2.0), turn=(0.0, 0.5))},
        "without wheels": {"body": Body.walker(nonholonomic=False)},
    },
    "coopenv/BeamLift-v0": {
        "cluttered": {"scene": room("coopenv/BeamLift-v0", CLUTTERED)},
        "low and wide": {
            "task": LiftTask(obstacle_height=(0.2, 0.3), obstacle_width=0.8, shelf=(0.9, 1.0)),
        },
        "may lean": {"task": LiftTask(tilt_limit=3.1, fall_limit=20.0)},
        "observe hurdle": {"observe": ("hurdle", "down")},
        "drawn gravity": {"randomise": Ranges(gravity=(7.0, 11.0))},
        "told to one": {"informed": (0,)},
    },
}
COMMON = (
    "defaults",
    "every block",
    "forces",
    "discrete",
    "motion",
    "impedance",
    "reward balanced",
    "cluttered",
    "three agents",
)
CASES: list[tuple[str, str, dict[str, Any]]] = [  # every id with its options: id, name, keywords
    *((IDS[0], name, keywords) for name, keywords in OPTIONS.items()),
    *(
        (view, name, OPTIONS[name])
        for view in IDS[1:]
        for name in COMMON
        if name not in OWN_OPTIONS.get(view, {})
    ),
    *((view, name, own) for view in IDS for name, own in OWN_OPTIONS.get(view, {}).items()),
]


def option(view: str, name: str) -> dict[str, Any]:
    """Keywords of an option as the id can take it."""
    return OWN_OPTIONS.get(view, {}).get(name) or OPTIONS[name]


CASE_NAMES = [f"{view}-{name}" for view, name, _ in CASES]


def actions(seed: int, steps: int, *shape: int) -> npt.NDArray[np.float64]:
    """Random actions ``(steps, *shape)`` in [−1, 1]."""
    return np.random.default_rng(seed).uniform(-1, 1, (steps, *shape))


def constant(env: Any, value: float = 0.0) -> npt.NDArray[np.float32]:
    """The action of a Gymnasium view of which every number is ``value``."""
    return np.full(env.action_space.shape, value, dtype=np.float32)


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every leaf of nested dicts, tuples and arrays of objects, with its path."""
    if isinstance(value, dict):
        for name, entry in value.items():
            yield from leaves(entry, f"{path}.{name}")
    elif isinstance(value, tuple | list) or _holds_objects(value):
        for i, entry in enumerate(value):
            yield from leaves(entry, f"{path}[{i}]")
    else:
        yield path, value


def _holds_objects(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.hasobject


def side_by_side(
    many: Transport, again: Transport, alone: Transport, plan: Iterable[npt.NDArray[np.float64]]
) -> Iterator[tuple[Any, Any]]:
    """What each step returns of two equal cores, which is the same, and of one with their world 2.

    ``plan`` has actions of all worlds; those that end begin anew.
    """
    ended: dict[Transport, Any] = dict.fromkeys((many, again, alone))
    for action in plan:
        got = {
            core: core.step(action[2:3] if core is alone else action, restart=ended[core])
            for core in ended
        }
        ended = {core: step[2] | step[3] for core, step in got.items()}
        assert_same(got[many], got[again])
        np.testing.assert_allclose(got[many][0][2], got[alone][0][0], atol=1e-5)
        yield got[many], got[alone]


def assert_same(first: Any, second: Any, *, within: float = 0.0) -> None:
    """Raise unless two nested results are equal, to the bit by default; NaN equals NaN."""
    mine, theirs = dict(leaves(first)), dict(leaves(second))
    assert mine.keys() == theirs.keys()
    for path, value in mine.items():
        if value is None or isinstance(value, str):
            assert value == theirs[path], path
        elif within:
            np.testing.assert_allclose(value, theirs[path], rtol=0, atol=within, err_msg=path)
        else:
            np.testing.assert_array_equal(value, theirs[path], err_msg=path, strict=True)


def spoil(value: Any) -> None:
    """Overwrite every array and empty every dict in a nested result."""
    for _, leaf in list(leaves(value)):
        if isinstance(leaf, np.ndarray) and leaf.flags.writeable:
            leaf[...] = 1 if leaf.dtype == np.bool_ else 77
    _empty(value)


def _empty(value: Any) -> None:
    if isinstance(value, tuple | list):
        for entry in value:
            _empty(entry)
    elif isinstance(value, dict):
        for entry in value.values():
            _empty(entry)
        value.clear()


def parallel_actions(env: Any, joint: npt.NDArray[Any]) -> dict[str, Any]:
    """One world's actions ``(agent, a)`` as a ParallelEnv takes them."""
    return {name: joint[i].astype(np.float32) for i, name in enumerate(env.possible_agents)}


def corners(pose: npt.NDArray[np.float64], body: Body) -> npt.NDArray[np.float64]:
    """The outline's vertices ``(..., vertex, 2)`` in the world frame [m]."""
    c, s = np.cos(pose[..., 2, None]), np.sin(pose[..., 2, None])
    x, y = np.array(body.outline).T
    turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    return turned + pose[..., None, :2]


def vec_env(*given: Any, **keywords: Any) -> Any:
    """The Stable-Baselines3 view, as `coopenv.agents.sb3.make_vec_env`; skipped without it."""
    pytest.importorskip("stable_baselines3")
    from coopenv.agents import sb3

    return sb3.make_vec_env(*given, **keywords)
