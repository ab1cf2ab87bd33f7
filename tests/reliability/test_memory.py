"""Memory is flat: nothing grows with resets, steps, pictures and environments that come and go."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from coopenv import Transport
from coopenv.arrays import FloatArray
from coopenv.envs.registry import find_config
from tests.helpers import IDS, PARALLEL
from tests.reliability.growth import check_flat, growth, shapes

WORLDS, TIMES = 100, 50  # in a round of resets, and rounds


def idle(core: Transport) -> FloatArray:
    return np.zeros((core.num_worlds, len(core.learners), core.action_size))


@pytest.mark.parametrize("name", IDS)
def test_ten_thousand_resets_leave_nothing_behind(name):
    core = Transport(num_worlds=WORLDS, config=find_config(name, {}))
    action = idle(core)
    core.reset(seed=0)
    solids = sum(len(scene.walls()) + len(scene.obstacles) for scene in core.scenes)
    bodies, fixed = shapes(core)[0] - solids, solids
    assert (bodies, fixed) == (WORLDS, shapes(core)[1])

    def between_steps() -> None:
        core.reset()
        core.step(action)

    check_flat(growth(between_steps, warm_up=10, times=TIMES), fewer_than=100, c_bytes=40_000)
    check_flat(growth(core.reset, warm_up=10, times=TIMES), fewer_than=100, c_bytes=40_000)
    solids = sum(len(scene.walls()) + len(scene.obstacles) for scene in core.scenes)
    assert shapes(core) == (WORLDS + solids, solids)


@pytest.mark.parametrize("name", IDS)
def test_environments_that_come_and_go_leave_nothing_behind(name):
    module: Any = PARALLEL[name]
    partnered: dict[str, Any] = {"partner": "noisy", "observe": ("goal", "obstacles", "time")}
    makers = [
        lambda: gymnasium.make(name),
        lambda: gymnasium.make(name, render_mode="rgb_array"),
        lambda: gymnasium.make(name, **partnered),
        lambda: gymnasium.make_vec(name, num_envs=2),
        lambda: gymnasium.make_vec(name, num_envs=2, **partnered),
        module.parallel_env,
        module.env,
    ]

    def come_and_go() -> None:
        for make in makers:
            env: Any = make()
            env.reset(seed=1)
            if env.render_mode is not None:
                env.render()
            env.close()

    times = 200 // len(makers) + 1
    check_flat(growth(come_and_go, warm_up=5, times=times), fewer_than=50, c_bytes=40_000)
