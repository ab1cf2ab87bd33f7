"""Episodes that bring obstacles, moving goals and secrets of their own."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from coopenv import Box, Episode, Scene, Transport, TransportTask
from coopenv.errors import InvalidInput


@dataclass(frozen=True, kw_only=True)
class Cluttered(TransportTask):
    """A box somewhere on the left, the goal on the right."""

    max_obstacles: int = 2  # pyright: ignore[reportIncompatibleMethodOverride]
    boxes: int = 1

    def sample(self, generator, body, scene):
        x, y = generator.uniform(-2.5, -1.5), generator.uniform(-2.0, 2.0)
        box = Box(center=(x, y), size=(0.3, 0.5), angle=generator.uniform(-1, 1))
        return Episode(start=(1.5, 0.0, 1.5), goal=(2.0, y, 1.0), obstacles=(box,) * self.boxes)


@dataclass(frozen=True, kw_only=True)
class Chase(TransportTask):
    """A goal that runs along x at a drawn speed and counts only after a second."""

    def sample(self, generator, body, scene):
        speed = float(generator.uniform(0.1, 0.5))
        return Episode(start=(0.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0), plan=(speed,))

    def goal_at(self, plan, time):
        return np.stack([plan[:, 0] * time, 0 * time, 0 * time], axis=-1)

    def due(self, plan, time):
        return time >= 1.0


class Secret(TransportTask):
    """Only agent 0 is told the angle."""

    def told(self, num_agents):
        told = np.ones((num_agents, 2), dtype=bool)
        told[1:, 1] = False
        return told


class Unsteady(TransportTask):
    """Plans of changing length."""

    def sample(self, generator, body, scene):
        plan = (1.0,) * int(generator.integers(1, 4))
        return Episode(start=(0.0, 0.0, 0.0), goal=(1.0, 0.0, 0.0), plan=plan)


def test_plans_of_changing_length_are_refused():
    core = Transport(task=Unsteady())
    core.reset(seed=0)
    length = core.conditions.plan.shape[1]
    seeds = ((seed, np.random.default_rng(seed)) for seed in range(99))
    other = next(seed for seed, generator in seeds if generator.integers(1, 4) != length)
    with pytest.raises(InvalidInput, match="plan must have as many numbers in every episode"):
        core.reset(seed=other)
    with pytest.raises(InvalidInput, match="plan must have as many numbers in every episode"):
        Transport(num_worlds=20, task=Unsteady()).reset(seed=0)


@pytest.mark.parametrize("start", [(0.0, 0.0), (np.nan, 0.0, 0.0), 3.0])
@pytest.mark.parametrize("count", [1, 3])
def test_a_drawn_start_must_be_a_finite_pose(start, count):
    class Wrong(TransportTask):
        def sample(self, generator, body, scene):
            return start, (1.0, 0.0, 0.0)

    with pytest.raises(InvalidInput, match=r"start of an episode must be three finite numbers"):
        Transport(num_worlds=count, task=Wrong()).reset(seed=0)


@pytest.mark.parametrize("name", ["pose", "goal"])
def test_a_given_pose_must_be_off_the_obstacles_of_its_own_episode(name):
    core = Transport(task=Cluttered())
    core.reset(seed=0)
    last, place = core.scenes[0], (*core.scenes[0].obstacles[0].center, 0.0)
    given: dict[str, Any] = {name: place}
    core.reset(seed=1, **given)  # the obstacle is elsewhere now
    assert core.scenes[0].is_free(*place[:2])
    with pytest.raises(InvalidInput, match=rf"{name} must .* off its obstacles"):
        core.reset(seed=0, **given)
    assert core.scenes[0] != last  # the episode under way goes on in its own room


def test_every_episode_brings_its_own_obstacles_into_physics_and_conditions():
    core = Transport(num_worlds=3, task=Cluttered())
    core.reset(seed=0)
    seen = [scene.obstacles[0] for scene in core.scenes]
    assert len(set(seen)) == 3
    for k, box in enumerate(seen):
        wanted = [*box.center, *box.size, box.angle]
        np.testing.assert_array_equal(core.conditions.room.boxes[k, 0], wanted)
    assert core.conditions.room.count.tolist() == [1, 1, 1]
    core.reset(mask=np.array([False, True, False]))
    kept = [scene.obstacles[0] == box for scene, box in zip(core.scenes, seen, strict=True)]
    assert kept == [True, False, True]


def test_a_body_is_stopped_by_the_obstacle_of_this_episode_and_not_by_the_last_ones():
    scene = Scene(size=(12.0, 12.0))
    core = Transport(num_worlds=2, task=Cluttered(), scene=scene)
    core.reset(seed=0)
    core.reset(seed=5)
    (x, y), height = core.scenes[0].obstacles[0].center, 2.0
    core.reset(seed=5, pose=(x, y + height, 0.0))
    down = np.zeros((2, 2, 3))
    down[:, 0], down[:, 1] = (0.0, -0.5, 0.0), (0.0, 0.5, 0.0)  # agent 1 looks the other way
    for _ in range(60):
        core.step(down)
    assert core.world.pose[0, 1] > y + 0.2  # rests on its box
    gone = replace(core.config, task=Cluttered(boxes=0))
    free = Transport(num_worlds=2, config=gone)
    free.reset(seed=5, pose=(x, y + height, 0.0))
    for _ in range(60):
        free.step(down)
    assert free.world.pose[0, 1] < y - 0.2


def test_an_episode_in_a_refurnished_world_equals_one_in_a_fresh_core():
    action = np.random.default_rng(1).uniform(-1, 1, (40, 2, 2, 3))
    used, fresh = (Transport(num_worlds=2, task=Cluttered()) for _ in range(2))
    used.reset(seed=3)
    for step in action:
        used.step(step)
    used.reset(seed=8)
    fresh.reset(seed=8)
    for step in action:
        used.step(step)
        fresh.step(step)
    np.testing.assert_array_equal(used.world.pose, fresh.world.pose)


def test_a_task_with_more_obstacles_than_it_declares_is_refused():
    with pytest.raises(InvalidInput, match="max_obstacles of the task must be at least 3, got 2"):
        Transport(task=Cluttered(boxes=3)).reset(seed=0)


def test_a_moving_goal_is_where_its_plan_says_and_success_waits_until_it_is_due():
    core = Transport(num_worlds=2, task=Chase(position_tolerance=2.0))
    core.reset(seed=0)
    speed = core.conditions.plan[:, 0].copy()
    assert speed[0] != speed[1]
    for step in range(1, 21):
        *_, terminated, _, info = core.step(np.zeros((2, 2, 3)))
        assert core.transition is not None
        goal = core.transition.next_state.goal
        np.testing.assert_allclose(goal[:, 0], speed * step * core.dt)
        assert terminated.tolist() == [step == 20] * 2
        assert info["success"].tolist() == terminated.tolist()


def test_success_waits_until_it_is_due_where_the_goal_stays_as_well():
    class Later(TransportTask):
        def due(self, plan, time):
            return time >= 0.5

    core = Transport(num_worlds=2, task=Later(position_tolerance=0.5))
    core.reset(seed=0, pose=(0, 0, 0), goal=(0.1, 0, 0))
    for step in range(1, 11):
        *_, terminated, _, _ = core.step(np.zeros((2, 2, 3)))
        assert terminated.tolist() == [step == 10] * 2


def test_an_episode_may_be_judged_by_its_mean_distance():
    class Steady(TransportTask):
        def accepts(self, mean_distance):
            seen.append(mean_distance.copy())
            return mean_distance < 0.2

    seen: list[np.ndarray] = []
    core = Transport(num_worlds=2, task=Steady(position_tolerance=0.5))
    for _ in range(2):  # what was before a reset does not count
        seen.clear()
        core.reset(seed=0, pose=[(0, 0, 0)] * 2, goal=[(0.1, 0, 0), (0.3, 0, 0)])
        *_, terminated, _, _ = core.step(np.zeros((2, 2, 3)))
        np.testing.assert_allclose(seen[-1], [0.1, 0.3])
        assert terminated.tolist() == [True, False]


def test_the_goal_of_a_moving_task_cannot_be_given():
    with pytest.raises(InvalidInput, match="goal must be left to a task whose goal moves"):
        Transport(task=Chase()).reset(seed=0, goal=(1, 1, 0))


def test_a_task_tells_each_agent_what_it_may_know():
    core = Transport(task=Secret(), observe=("goal", "known"))
    obs, _ = core.reset(seed=0)
    assert obs[0, 0].all()
    assert obs[0, 1, :2].all()
    np.testing.assert_array_equal(obs[0, 1, 2:], [0, 0, 1, 0])
