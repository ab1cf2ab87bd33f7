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

WORLDS, TIMES = 250, 20  # in a round of resets, and rounds


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

    check_flat(growth(between_steps, warm_up=10, times=TIMES), fewer_than=50, c_bytes=40_000)
    check_flat(growth(core.reset, warm_up=10, times=TIMES), fewer_than=50, c_bytes=40_000)
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

    times = 100 // len(makers) + 1
    check_flat(growth(come_and_go, warm_up=5, times=times), fewer_than=50, c_bytes=40_000)


def test_pictures_leave_nothing_behind():
    env: Any = gymnasium.make("coopenv/BeamDoorway-v0", render_mode="rgb_array")
    env.reset(seed=0)

    def draw() -> None:
        env.step(env.action_space.sample())
        env.render()

    # Far less than one picture: the library of fonts keeps each letter that it has drawn.
    check_flat(growth(draw, warm_up=10, times=100), fewer_than=50, c_bytes=400_000)


class Gymnasiums:
    """A Gymnasium environment, its episodes one after the other."""

    per_call = 1

    def __init__(self, name: str):
        self.env: Any = gymnasium.make(name)
        self.env.reset(seed=0)

    def step(self) -> None:
        if any(self.env.step(self.env.action_space.sample())[2:4]):
            self.env.reset()


class Cores:
    """The batched core itself."""

    per_call = 200

    def __init__(self, name: str):
        self.env = Transport(num_worlds=self.per_call, config=find_config(name, {}))
        self.generator = np.random.default_rng(0)
        self.env.reset(seed=0)

    def step(self) -> None:
        action = self.generator.uniform(-1, 1, self.env.action_shape)
        *_, terminated, truncated, _ = self.env.step(action)
        if (ended := terminated | truncated).any():
            self.env.reset(mask=ended)


class Vectors:
    """A Gymnasium vector of many worlds."""

    per_call = 200

    def __init__(self, name: str):
        self.env: Any = gymnasium.make_vec(name, num_envs=self.per_call)
        self.env.reset(seed=0)

    def step(self) -> None:
        self.env.step(self.env.action_space.sample())


class Parallels:
    """PettingZoo's parallel view."""

    per_call = 1

    def __init__(self, name: str):
        module: Any = PARALLEL[name]
        self.env: Any = module.parallel_env()
        self.env.reset(seed=0)

    def step(self) -> None:
        if not self.env.agents:
            self.env.reset()
        self.env.step({one: self.env.action_space(one).sample() for one in self.env.agents})


class Turns(Parallels):
    """PettingZoo's view in which agents act in turn."""

    def __init__(self, name: str):
        module: Any = PARALLEL[name]
        self.env: Any = module.env()
        self.env.reset(seed=0)

    def step(self) -> None:
        for one in self.env.possible_agents:
            *_, terminated, truncated, _ = self.env.last()
            if terminated or truncated:
                self.env.reset()
                return
            self.env.step(self.env.action_space(one).sample())


class Stable(Vectors):
    """The vector of Stable-Baselines3."""

    def __init__(self, name: str):
        pytest.importorskip("stable_baselines3")
        from coopenv.agents import sb3

        self.env = sb3.make_vec_env(name, self.per_call)
        self.env.reset()

    def step(self) -> None:
        self.env.step(np.stack([self.env.action_space.sample()] * self.per_call))


class Tensors(Vectors):
    """TorchRL's view."""

    def __init__(self, name: str):
        pytest.importorskip("torchrl")
        from coopenv.agents import torchrl

        self.env = torchrl.make_env(name, num_worlds=self.per_call, seed=0)
        self.now = self.env.reset()

    def step(self) -> None:
        _, self.now = self.env.step_and_maybe_reset(self.env.rand_action(self.now))


@pytest.mark.parametrize("view", [Cores, Gymnasiums, Vectors, Parallels, Turns, Stable, Tensors])
@pytest.mark.parametrize("steps", [1000, pytest.param(10**6, marks=pytest.mark.slow)])
def test_steps_of_a_view_leave_nothing_behind(view, steps):
    name = "coopenv/BeamDoorway-v0"
    viewed = view(name)
    warm_up = max(1000 // viewed.per_call, 4 * find_config(name, {}).horizon)  # all end
    grown = growth(viewed.step, warm_up=warm_up, times=max(steps // viewed.per_call, 50))
    # Contacts of pymunk take memory for as many as there ever were at once; torch keeps a hundred
    # weak references, as many after 400 calls as after 5,000.
    check_flat(grown, fewer_than=200 if view is Tensors else 50, c_bytes=300_000)
