"""The lift: its layouts, its way, what is done, what has failed, and what a load share is."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from coopenv import Body, Box, LiftTask, Ranges, Scene, Transport, TransportConfig
from coopenv.agents.controllers import ImpedanceController, find_controller
from coopenv.agents.evaluate import evaluate
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.physics.scene import Scene as Room
from coopenv.tasks import hurdle
from tests.helpers import UPRIGHT

G = 9.81  # [m/s²]
ID = "coopenv/BeamLift-v0"


def lift(num_worlds=1, **keywords):
    return Transport(num_worlds=num_worlds, config=find_config(ID, keywords))


def held(core, accelerate=(0.0, 0.0, 0.0)):
    """Actions that bear the weight by the pseudoinverse and accelerate the object."""
    return Accelerating(core.config, accelerate)(np.zeros(1), core.transition)


class Accelerating(ImpedanceController):
    """Accelerates the object, from whatever it does."""

    def __init__(self, config, accelerate):
        super().__init__(config)
        self.accelerate = np.array([accelerate], dtype=float)

    def wanted_motion(self, transition):
        return transition.next_state.twist, self.accelerate


def stepped(core, action, steps):
    """Reward, terminated, truncated and infos of the last of ``steps``, or of that which ended."""
    assert core.transition is not None
    for _ in range(steps - 1):
        *_, terminated, truncated, _ = step = core.step(action(core))
        if terminated[0] or truncated[0]:
            return step[1:]
    return core.step(action(core))[1:]


def let_go(core):
    return np.zeros((1, 2, core.action_size))


def test_every_layout_leaves_room_to_start_to_pass_and_to_lie():
    core = lift(400)
    core.reset(seed=0)
    assert core.transition is not None
    state, plan = core.transition.next_state, core.conditions.plan
    outline, floor = np.array(core.bodies[0].outline), -2.5
    for k, scene in enumerate(core.scenes):
        obstacle, shelf = scene.obstacles
        for box in (obstacle, shelf):
            assert box.vertices[:, 1].min() == pytest.approx(floor)
        assert 0.6 <= obstacle.size[1] <= 1.4
        assert 0.4 <= shelf.size[1] <= 1.2
        assert shelf.vertices[:, 0].max() == pytest.approx(4.0)
        start, goal = (outline + pose[:2] for pose in (state.pose[k], state.goal[k]))
        assert start[:, 1].min() == pytest.approx(floor)
        assert start[:, 0].max() < obstacle.vertices[:, 0].min() - 0.09
        assert goal[:, 1].min() == pytest.approx(shelf.vertices[:, 1].max())
        assert goal[:, 0].min() > shelf.vertices[:, 0].min() + 0.09
        assert goal[:, 0].max() < 3.91
        top = max(obstacle.vertices[:, 1].max(), shelf.vertices[:, 1].max())
        assert plan[k, hurdle.CLEAR_Y] - 0.05 - top == pytest.approx(0.1)
    assert len(np.unique(plan[:, hurdle.HURDLE_Y])) > 390
    assert len(np.unique(state.goal[:, 0])) > 390


def test_the_way_leads_up_along_and_down_without_a_step():
    core = lift()
    core.reset(seed=2)
    assert core.transition is not None
    task, plan, goal = core.config.task, core.conditions.plan, core.transition.next_state.goal
    start = core.transition.next_state.pose[0]
    rise, over, clear = plan[0, :3]
    corners = [start[:2], (rise, clear), (over, clear), goal[0, :2]]
    lengths = [np.hypot(*np.subtract(b, a)) for a, b in pairwise(corners)]
    assert task.way(plan, start[None], goal)[0] == pytest.approx(sum(lengths))
    assert task.way(plan, goal, goal)[0] == 0.0
    for a, b in pairwise(corners):
        path = np.linspace(a, b, 400)
        poses = np.column_stack([path, np.zeros(400)])
        ways = task.way(plan.repeat(400, 0), poses, goal.repeat(400, 0))
        assert (np.diff(ways) < 0).all()
    generator = np.random.default_rng(0)
    poses = generator.uniform((-3, -2.4, -0.4), (3, 2, 0.4), (5000, 3))
    near = poses + generator.normal(0, 1e-6, poses.shape)
    many = plan.repeat(5000, 0), goal.repeat(5000, 0)
    change = task.way(many[0], poses, many[1]) - task.way(many[0], near, many[1])
    assert np.abs(change).max() < 1e-3  # the steepest is the last margin before the shelf
    assert (task.way(many[0], poses, many[1]) >= task.distance(poses, many[1]) - 1e-12).all()


@pytest.mark.parametrize(("a", "b"), [(0.9, 0.9), (0.9, 0.3), (0.2, 0.7), (0.5, 0.9)])
def test_a_beam_held_level_is_shared_as_the_law_of_the_lever_says(a, b):
    # Forces only, at rest: moments about the centre are a F_a = b F_b, and F_a + F_b = m g.
    body = Body(grips=((-a, 0.0), (b, 0.0)))
    core = lift(body=body, action="force", force_limit=100.0)
    core.reset(seed=0, pose=(-2.5, 0.0, 0.0))
    up = np.array([[[0.0, b, 0.0], [0.0, a, 0.0]]]) / (a + b) * 7.7 * G
    action = frames.actions_from_wrenches(up, core.team.frame, core.team.limits, 2)
    *_, info = stepped(core, lambda _: action, 20)
    np.testing.assert_allclose(core.world.twist, 0, atol=1e-9)
    np.testing.assert_allclose(info["force_load_share"][0], [b / (a + b), a / (a + b)], atol=1e-9)
    assert info["relative_cost"].max() == pytest.approx(0, abs=1e-9)


def laid(core, dy=-0.0005, dx=0.0):
    """The pose on the shelf, a little in it or over it."""
    core.reset(seed=0)
    assert core.transition is not None
    goal = core.transition.next_state.goal[0]
    core.reset(seed=0, pose=np.add(goal, (dx, dy, 0.0)))


def test_who_lays_it_on_the_shelf_at_its_place_is_done():
    core = lift()
    laid(core)
    _, terminated, truncated, info = stepped(core, let_go, 5)
    assert (terminated[0], truncated[0], info["success"][0]) == (True, False, True)
    assert (info["reward/success"] == 10.0).all()


@pytest.mark.parametrize(("dx", "dy"), [(0.0, 0.003), (0.15, -0.0005)])
def test_who_holds_it_over_its_place_or_lays_it_beside_is_not_done(dx, dy):
    core = lift()
    laid(core, dy, dx)
    _, terminated, truncated, _ = stepped(core, held, 20)
    assert not terminated[0]
    assert not truncated[0]


def test_who_drops_it_onto_the_shelf_has_failed():
    core = lift()
    laid(core, dy=0.3)
    reward, terminated, truncated, info = stepped(core, let_go, 20)
    assert (terminated[0], truncated[0], info["success"][0]) == (True, False, False)
    assert core.world.twist[0, 1] < -1.5
    assert (info["reward/success"] == -10.0).all()
    assert reward[0].max() < -8.0  # what it came nearer meanwhile does not make up for it


@pytest.mark.parametrize("lean", [0.6, -0.6])
def test_who_lets_it_lean_has_failed(lean):
    core = lift()
    core.reset(seed=0, pose=(-2.5, 0.5, 0.9 * lean))
    *_, terminated, _, _ = core.step(held(core))
    assert terminated[0] == (abs(0.9 * lean) > 0.5)
    core.reset(seed=0, pose=(-2.5, 0.5, 0.45 * np.sign(lean)))
    _, terminated, _, info = stepped(core, lambda core: held(core, (0, 0, lean)), 100)
    assert terminated[0]
    assert not info["success"][0]


def test_from_a_state_in_the_air_the_same_actions_lead_to_the_same_bits_and_at_rest_it_stays():
    core = lift(action="force")
    core.reset(seed=0, pose=(-2.5, 0.5, 0.1))
    core.step(held(core))
    state, plan = core.get_state(), [held(core, (0.5, 0.2 * k, 0.1)) for k in range(10)]
    first = [core.step(action)[0] for action in plan]
    core.set_state(state)
    np.testing.assert_array_equal([core.step(action)[0] for action in plan], first)
    core.reset(seed=0)  # on the floor
    for _ in range(60):
        core.step(np.zeros((1, 2, 2)))
    pose = core.world.pose[0]
    for _ in range(50):  # as a search does, which goes on from its own states
        core.set_state(core.get_state())
        core.step(np.zeros((1, 2, 2)))
        np.testing.assert_allclose(core.world.pose[0], pose, atol=1e-6)
    for _ in range(20):
        core.step(np.zeros((1, 2, 2)))
    np.testing.assert_allclose(core.world.pose[0], pose, atol=1e-6)


def test_failing_pays_less_than_waiting_and_that_less_than_succeeding():
    core = lift(3, horizon=300)
    controller = find_controller(core.config)
    core.reset(seed=0)
    total, running = np.zeros(3), np.ones(3, dtype=bool)
    for _ in range(300):
        assert core.transition is not None
        action = controller(np.zeros(1), core.transition)
        action[1] = 0.0  # waits on the floor
        action[2] = ((0.0, 1.0, 0.0), (0.0, 0.0, 0.0))  # one lifts its end, the other does not
        over = core.transition.terminated | core.transition.truncated
        _, reward, terminated, truncated, _ = core.step(action, restart=over)
        total += np.where(running, reward.mean(axis=1), 0)
        running &= ~(terminated | truncated)
    assert not running.any()
    done, waited, failed = total
    assert done > waited + 10
    assert waited > failed + 1


def test_everybody_senses_where_down_is_and_where_the_obstacle_is():
    core = lift(observe=("hurdle", "down"), informed=())
    angle = 0.3
    obs, _ = core.reset(seed=1, pose=(-2.5, 0.0, angle))
    plan = core.conditions.plan[0]
    down = np.array([-np.sin(angle), -np.cos(angle)])  # agent 0 looks along the beam
    np.testing.assert_allclose(obs[0, 0, 4:], down, atol=1e-6)
    np.testing.assert_allclose(obs[0, 1, 4:], -down, atol=1e-6)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    top, edge = (plan[i : i + 2] - (-2.5, 0.0) for i in (hurdle.HURDLE_X, hurdle.SHELF_X))
    np.testing.assert_allclose(obs[0, 0, :4], [*(turn @ top), *(turn @ edge)], atol=1e-6)
    np.testing.assert_allclose(obs[0, 1, :4], -obs[0, 0, :4], atol=1e-6)


def test_without_gravity_there_is_no_down():
    pose, frame = np.zeros((2, 3)), np.array([[[1.0, 0.0]], [[1.0, 0.0]]])
    seen = hurdle.seen_down(pose, np.array([[0.0, 0.0], [0.0, -2.0]]), frame)
    np.testing.assert_array_equal(seen, [[[0, 0]], [[0, -1]]])


@pytest.mark.parametrize(
    "keywords",
    [
        {},
        {"action": "force"},
        {"body": Body(grips=((-0.9, 0.0), (0.3, 0.05), (0.9, -0.05)))},
        {"body": Body.beam(length=1.0, width=0.3, mass=5.0, linear_drag=0.0)},
        {"task": LiftTask(obstacle_height=(0.2, 0.4), shelf_height=(1.3, 1.5))},
        {"partner": "robot"},
    ],
    ids=["defaults", "forces", "trio", "short", "high shelf", "robot"],
)
def test_the_scripted_controller_lifts_it_gently(keywords):
    config = find_config(ID, {"horizon": 400, **keywords})
    result = evaluate(find_controller(config), config, episodes=40)
    assert result.success_rate >= 0.95
    if "partner" not in keywords:
        assert result.relative_cost < 1e-6


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tilt_limit": 0.0}, r"task\.tilt_limit must be positive"),
        ({"tilt_limit": 4.0}, r"task\.tilt_limit must be below π, got 4\.0"),
        ({"tilt_limit": np.pi}, r"task\.tilt_limit must be below π"),
        ({"obstacle_height": (-1.0, 1.0)}, r"task\.obstacle_height must"),
        ({"start": (1.0, -1.0)}, r"task\.start must"),
        ({"shelf": (-0.3, 0.9)}, r"task\.shelf must begin behind the obstacle"),
    ],
)
def test_a_value_that_breaks_its_rule_is_refused(values, message):
    with pytest.raises(InvalidInput, match=message):
        LiftTask(**values)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"scene": Scene(size=(8.0, 5.0))}, r"scene\.gravity must point straight down"),
        ({"scene": Scene(size=(8.0, 5.0), gravity=(1.0, -G))}, r"scene\.gravity must point"),
        ({"task": LiftTask(start=(-3.5, -3.0))}, r"task\.start must lie within \(-2\.90, -1\.85\)"),
        ({"task": LiftTask(shelf=(0.6, 2.0))}, r"task\.shelf must leave room"),
        (
            {"scene": replace(UPRIGHT, size=(8.0, 1.5))},
            r"scene\.size must be at least 1\.70 m high",
        ),
        (
            {"scene": replace(UPRIGHT, obstacles=(Box(center=(-2, -2.4), size=(2, 0.2)),))},
            r"scene\.obstacles must leave floor and shelf free",
        ),
    ],
)
def test_a_room_in_which_nothing_can_be_lifted_is_refused(keywords, message):
    with pytest.raises(InvalidInput, match=message):
        lift(**keywords).reset(seed=0)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"body": Body(mass=17.4)}, r"body\.mass must be below 17\.3 kg, .* got 17\.4"),
        ({"body": (Body(), Body(mass=50))}, r"body\.mass must be below 17\.3 kg"),
        ({"force_limit": (20.0, 30.0)}, r"body\.mass must be below 7\.208 kg, .* got 7\.7"),
        (
            {"randomise": Ranges(mass=(5, 100))},
            r"randomise must leave the task possible: body\.mass",
        ),
        (
            {"randomise": Ranges(force_limit=(20, 90))},
            r"possible: body\.mass must be below 5\.766 kg",
        ),
        ({"action": "motion", "body": Body(mass=20)}, r"body\.mass must be below 17\.3 kg"),
    ],
)
def test_what_nobody_can_lift_is_refused(keywords, message):
    with pytest.raises(InvalidInput, match=message):
        find_config(ID, keywords)


def test_what_somebody_can_lift_is_not_refused():
    """Leaning as it may, with both axes of each agent: 163 N, where it is 120 N level."""
    core = Transport(config=find_config(ID, {"body": Body(mass=16.0)}))
    up = np.array([[(1.0, 1.0, 0.0), (-1.0, -1.0, 0.0)]])  # the second looks the other way
    for lean, rises in ((0.49, True), (0.0, False)):
        core.reset(seed=0, pose=(-2.5, 0.0, lean))
        *_, terminated, _, _ = core.step(up)
        assert (core.world.twist[0, 1] > 0.0) == rises
        assert not terminated[0]
    assert find_config(ID, {"randomise": Ranges(mass=(5, 16), force_limit=(60, 90))})
    assert TransportConfig(body=Body(mass=1e3)).num_agents == 2  # a task that lifts nothing


def test_json_brings_the_task_and_the_room_back():
    config = find_config(ID, {"task": LiftTask(tilt_limit=0.3)})
    assert TransportConfig.from_json(config.to_json()) == config
    assert Room(gravity=(0, -G)).gravity == (0.0, -9.81)
