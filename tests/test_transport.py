"""The core: episodes, ends, determinism, what is internal, what pays, and what it refuses."""

import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

from coopenv import Body, Scene, Transport, TransportTask
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.rewards import PRESETS
from coopenv.transition import Transition
from coopenv.wrench import Settings
from tests.helpers import (
    BLIND_TO_HANDS,
    CLUTTERED,
    EASY,
    NEVER,
    OPEN_ROOM,
    OPTIONS,
    QUINTET,
    TRIO,
    actions,
    assert_same,
    corners,
    spoil,
)

FAR = (2.9, 2.9, 1.0)  # a goal nothing reaches by chance


def started(**keywords):
    """A core after ``reset(seed=0)``; reset arguments by the names ``pose`` and ``goal``."""
    start = {name: keywords.pop(name) for name in ("pose", "goal") if name in keywords}
    core = Transport(**keywords)
    core.reset(seed=0, **start)
    return core


def last(core):
    """The transition of the last step."""
    assert core.transition is not None
    return core.transition


def ride(core, plan):
    """Every step's result under ``plan`` ``(step, world, agent, a)``, with pose and twist."""
    return [(core.step(action), core.world.pose, core.world.twist) for action in plan]


def world_of(results, k):
    """What world ``k`` saw of a list of results."""

    def pick(value):
        if isinstance(value, dict):
            return {name: pick(entry) for name, entry in value.items()}
        if isinstance(value, tuple | list):
            return [pick(entry) for entry in value]
        return value[k]

    return pick(results)


def test_shapes_are_world_agent_feature():
    core = Transport(num_worlds=5, body=TRIO)
    obs, info = core.reset(seed=0)
    assert (obs.shape, obs.dtype) == ((5, 3, core.observation.size), np.float32)
    obs, reward, terminated, truncated, info = core.step(np.zeros((5, 3, 3)))
    assert (obs.shape, obs.dtype) == ((5, 3, core.observation.size), np.float32)
    assert (reward.shape, reward.dtype) == ((5, 3), np.float64)
    for end in (terminated, truncated, info["success"]):
        assert (end.shape, end.dtype) == ((5,), np.bool_)
    shapes = {name: np.shape(value) for name, value in info.items() if "/" not in name}
    assert shapes == {
        "internal_wrench": (5, 3, 3),
        "manipulation_wrench": (5, 3, 3),
        "force_load_share": (5, 3),
        "force_load_share_defined": (5,),
        "torque_load_share": (5, 3),
        "torque_load_share_defined": (5,),
        "relative_cost": (5,),
        "wasted_cost": (5,),
        "internal_force_level": (5,),
        "internal_torque_level": (5,),
        "success": (5,),
        "is_success": (5,),
        "contact_impulse": (5,),
        "contact_shift": (5,),
        "energy_share": (5, 3),
        "energy_share_defined": (5,),
        "internal_power": (5,),
        "surroundings_wrench": (5, 3),
    }
    assert all(term.shape == (5, 3) for term in info["reward_terms"].values())


def test_an_action_is_what_each_agent_does_along_its_own_axis():
    core = started(pose=(0, 0, 0.4), goal=FAR, force_limit=(20.0, 30.0), torque_limit=(10.0, 5.0))
    core.step([[[1.0, 0.5, 0.2], [0.5, -1.0, -1.0]]])
    # Agent 0 holds the left end and looks along +x of the object, agent 1 along −x.
    np.testing.assert_allclose(
        last(core).applied[0], [[20.0, 10.0, 2.0], [-15.0, 30.0, -5.0]], atol=1e-14
    )


def test_an_agent_at_the_centre_of_mass_looks_along_the_objects_axis():
    core = started(
        body=Body(grips=((0.0, 0.0), (0.0, 0.5))), pose=(0, 0, 0), goal=FAR, force_limit=20.0
    )
    core.step([[[1.0, 0.5, 0.0], [1.0, 0.0, 0.0]]])
    np.testing.assert_allclose(
        last(core).applied[0], [[20.0, 10.0, 0.0], [0.0, -20.0, 0.0]], atol=1e-14
    )


def test_actions_outside_the_box_are_clipped():
    plan = 3.0 * actions(1, 20, 2, 2, 3)
    wild, tame = started(num_worlds=2), started(num_worlds=2)
    assert_same(ride(wild, plan), ride(tame, np.clip(plan, -1, 1)))
    assert np.abs(last(wild).action).max() == 1.0


def test_force_actions_apply_no_torque():
    core = started(action="force", force_limit=20.0)
    core.step(np.ones((1, 2, 2)))
    assert last(core).action.shape == (1, 2, 2)
    np.testing.assert_array_equal(last(core).applied[..., 2], 0.0)
    np.testing.assert_allclose(np.abs(last(core).applied[..., :2]), 20.0)


@pytest.mark.parametrize("angle", np.linspace(-np.pi, np.pi, 13))
@pytest.mark.parametrize("pull", [-1.0, 1.0], ids=["tension", "compression"])
def test_pure_tension_is_internal_at_any_beam_angle_and_moves_nothing(angle, pull):
    core = started(pose=(0.4, -0.3, angle), goal=FAR, task=NEVER, force_limit=20.0)
    before = core.world.pose
    info = ride(core, np.tile([pull, 0.0, 0.0], (20, 1, 2, 1)))[-1][0][4]
    np.testing.assert_allclose(core.world.pose, before, rtol=0, atol=1e-12)
    np.testing.assert_allclose(core.world.twist, 0.0, rtol=0, atol=1e-12)
    assert info["relative_cost"][0] == pytest.approx(1.0, abs=1e-12)
    assert info["internal_force_level"][0] == pytest.approx(20.0, abs=1e-9)
    np.testing.assert_allclose(info["internal_wrench"], last(core).applied, atol=1e-9)
    assert not info["force_load_share_defined"].any()
    np.testing.assert_array_equal(info["force_load_share"], 0.5)


def test_pulling_together_is_not_internal():
    core = started(pose=(0, 0, 0.3), goal=FAR, force_limit=20.0)
    *_, info = core.step([[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])
    assert info["relative_cost"][0] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(info["force_load_share"], 0.5, atol=1e-12)
    assert info["force_load_share_defined"].all()
    assert not info["torque_load_share_defined"].any()
    assert core.world.twist[0, :2] @ [np.cos(0.3), np.sin(0.3)] > 0.2


@pytest.mark.parametrize("name", ["defaults", "forces", "cluttered", "three agents", "five agents"])
def test_the_same_seed_gives_the_same_bits(name):
    keywords = {**OPTIONS[name], "num_worlds": 3, "task": EASY, "horizon": 60}
    plan = actions(2, 15, 3, started(**keywords).num_agents, started(**keywords).action_size)
    first, second = started(**keywords), started(**keywords)
    alive = [ride_with_resets(core, plan) for core in (first, second)]
    assert_same(alive[0], alive[1])


def ride_with_resets(core, plan):
    """As `ride`, resetting what has ended after every step."""
    seen = []
    for action in plan:
        result = core.step(action)
        ended = result[2] | result[3]
        again = core.reset(mask=ended) if ended.any() else ()
        seen.append((result, again, core.world.pose, core.world.twist))
    return seen


def test_other_seeds_give_other_episodes():
    core = Transport(num_worlds=4)
    starts = [core.reset(seed=seed)[0] for seed in (0, 100, 200)]
    assert len(np.unique(np.concatenate(starts)[:, 0], axis=0)) == 12


def test_a_generator_goes_on_from_episode_to_episode_and_a_seed_starts_it_again():
    core = Transport(num_worlds=2)
    first, second = core.reset(seed=5)[0], core.reset()[0]
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(core.reset(seed=5)[0], first)
    np.testing.assert_array_equal(core.reset()[0], second)


def test_world_k_of_seed_s_starts_as_the_single_world_with_s_plus_k():
    together = Transport(num_worlds=4).reset(seed=30)[0]
    for k in range(4):
        np.testing.assert_array_equal(Transport().reset(seed=30 + k)[0][0], together[k])


def test_a_sequence_of_seeds_gives_each_world_its_own():
    core = Transport(num_worlds=3)
    obs, _ = core.reset(seed=[7, 3, 7])
    np.testing.assert_array_equal(obs[0], obs[2])
    again, _ = core.reset(seed=[None, 3, None])
    np.testing.assert_array_equal(again[1], obs[1])
    assert not np.array_equal(again[0], obs[0])


def test_large_seeds_are_taken_to_the_last_digit():
    large = 2**60
    first, second = Transport().reset(seed=large)[0], Transport().reset(seed=large + 1)[0]
    assert not np.array_equal(first, second)


def test_two_processes_with_the_same_seed_agree_to_the_bit():
    code = """
import hashlib
import numpy as np
from coopenv import Transport
core = Transport(num_worlds=6)
digest = hashlib.sha256(core.reset(seed=3)[0].tobytes())
for action in np.random.default_rng(4).uniform(-1, 1, (60, 6, 2, 3)):
    obs, reward, *_ = core.step(action)
    for array in (obs, reward, core.world.pose, core.world.twist):
        digest.update(array.tobytes())
assert core.world.num_worlds == 6
print(digest.hexdigest())
"""
    run = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert len(run[0].stdout.strip()) == 64
    assert run[0].stdout == run[1].stdout


@pytest.mark.parametrize("name", ["defaults", "cluttered", "three agents"])
def test_what_neighbours_do_changes_no_bit_of_a_world(name):
    keywords = {**OPTIONS[name], "num_worlds": 3, "task": NEVER}
    quiet, loud = started(**keywords), started(**keywords)
    own = actions(3, 60, 3, quiet.num_agents, quiet.action_size)
    others = own.copy()
    others[:, 1:] = -1.0
    assert_same(world_of(ride(quiet, own), 0), world_of(ride(loud, others), 0))


@pytest.mark.parametrize("count", [7, 300])
def test_a_world_is_the_same_in_any_company(count):
    keywords = {"scene": OPEN_ROOM, "task": NEVER, "observe": ("goal", "twist", "own_internal")}
    together = Transport(num_worlds=count, **keywords)
    plan = actions(4, 40, count, 2, 3)
    first, _ = together.reset(seed=0)
    many = ride(together, plan)
    for k in (0, 3, count - 1):
        alone = Transport(**keywords)
        np.testing.assert_array_equal(alone.reset(seed=k)[0][0], first[k])
        for (result, pose, twist), mine in zip(many, ride(alone, plan[:, k : k + 1]), strict=True):
            np.testing.assert_allclose(mine[1][0], pose[k], rtol=0, atol=1e-9)
            np.testing.assert_allclose(mine[2][0], twist[k], rtol=0, atol=1e-9)
            np.testing.assert_allclose(mine[0][1][0], result[1][k], rtol=0, atol=1e-9)
            # float32: rounding to other neighbours is one unit in the last place
            np.testing.assert_allclose(mine[0][0][0], result[0][k], rtol=3e-7, atol=1e-6)


@pytest.mark.parametrize("name", ["defaults", "cluttered", "five agents"])
def test_a_reset_episode_equals_a_fresh_one_to_the_bit_also_after_contact(name):
    count = 3 if name == "five agents" else 12
    keywords = {**OPTIONS[name], "num_worlds": count, "task": NEVER}
    used, fresh = started(**keywords), Transport(**keywords)
    plan = actions(5, 50, count, used.num_agents, used.action_size)
    shove = np.broadcast_to(np.sign(plan[:1]), plan.shape)
    crashed = ride(used, shove)
    assert any(result[4]["contact_impulse"].any() for result, *_ in crashed)
    assert_same(used.reset(seed=77), fresh.reset(seed=77))
    assert_same(ride(used, plan), ride(fresh, plan))


def test_a_partial_reset_leaves_the_others_untouched_to_the_bit():
    keywords = {"num_worlds": 10, "task": NEVER, "reward": "balanced"}
    left, disturbed = started(**keywords), started(**keywords)
    plan = np.sign(actions(6, 40, 10, 2, 3))
    end = ride(left, plan)[-1]
    ride(disturbed, plan)
    mask = np.arange(10) % 3 == 0
    rest = np.flatnonzero(~mask)
    before = last(disturbed)
    obs, info = disturbed.reset(mask=mask)
    for k in rest:
        assert_same(world_of((obs, info), k), world_of((end[0][0], end[0][4]), k))
    for name in ("applied", "action", "contact_impulse", "success"):
        np.testing.assert_array_equal(
            getattr(last(disturbed), name)[rest], getattr(before, name)[rest]
        )
    first, second = ride(left, plan), ride(disturbed, plan)
    assert any(result[4]["contact_impulse"][rest].any() for result, *_ in first)
    for k in rest:
        assert_same(world_of(first, k), world_of(second, k))


def test_an_empty_mask_resets_nothing():
    core = started(num_worlds=3, observe=BLIND_TO_HANDS)
    (obs, _, _, _, info), *_ = ride(core, actions(7, 1, 3, 2, 3))[0]
    seen, told = core.reset(mask=np.zeros(3, dtype=bool))
    np.testing.assert_array_equal(seen, obs)
    assert_same(told, info)


def test_a_given_start_and_goal_are_taken_and_the_angle_is_wrapped():
    core = Transport(num_worlds=2)
    core.reset(seed=0, pose=(0.5, -0.25, 4.0), goal=[(1, 1, 0), (0, 0, -np.pi)])
    state = last(core).next_state
    np.testing.assert_allclose(state.pose, [(0.5, -0.25, 4.0 - 2 * np.pi)] * 2, atol=1e-15)
    np.testing.assert_allclose(state.goal, [(1, 1, 0), (0, 0, np.pi)], atol=1e-15)


def test_a_partial_reset_takes_each_worlds_own_start_and_goal():
    core = started(num_worlds=3)
    poses = [(0.1 * k, 0.2 * k, 0.3 * k) for k in range(3)]
    goals = [(-0.1 * k, -0.2 * k, -0.3 * k) for k in range(3)]
    before = last(core).next_state
    core.reset(mask=np.array([False, True, True]), pose=poses, goal=goals)
    state = last(core).next_state
    np.testing.assert_allclose(state.pose, [before.pose[0], *poses[1:]], atol=1e-15)
    np.testing.assert_allclose(state.goal, [before.goal[0], *goals[1:]], atol=1e-15)
    np.testing.assert_allclose(core.world.pose[1:], poses[1:], atol=1e-15)


def test_a_given_start_does_not_change_what_is_drawn_next():
    drawn, given = Transport(), Transport()
    drawn.reset(seed=1)
    given.reset(seed=1, pose=(0, 0, 0), goal=(1, 1, 1))
    np.testing.assert_array_equal(drawn.reset()[0], given.reset()[0])


def test_what_is_returned_is_not_shared_with_the_core():
    keywords = {"num_worlds": 4, "task": EASY, "horizon": 6, "reward": "balanced"}
    plan = actions(8, 40, 4, 2, 3)
    clean, soiled = Transport(**keywords), Transport(**keywords)
    assert_same(clean.reset(seed=2), first := soiled.reset(seed=2))
    spoil(first)
    for action in plan:
        given = action.copy()
        mine, theirs = clean.step(action), soiled.step(given)
        assert_same(mine, theirs)
        mask = mine[2] | mine[3]
        spoil((given, theirs))
        assert_same(clean.reset(mask=mask), again := soiled.reset(mask=mask))
        spoil(again)
        none = np.zeros(4, dtype=bool)
        assert_same(clean.reset(mask=none), soiled.reset(mask=none))


def test_the_transition_is_what_the_step_was():
    core = started(num_worlds=3, horizon=9)
    first, second = actions(9, 2, 3, 2, 3)
    core.step(first)
    middle = last(core)
    core.step(second)
    latest = last(core)
    assert_same(vars_of(latest.state), vars_of(middle.next_state))
    np.testing.assert_array_equal(latest.previous_action, first)
    np.testing.assert_array_equal(latest.action, second)
    np.testing.assert_allclose(latest.next_state.time, 2 * core.dt, rtol=1e-15)
    np.testing.assert_allclose(latest.next_state.pose, core.world.pose, rtol=1e-15)
    np.testing.assert_allclose(
        latest.next_state.distance, core.config.task.distance(core.world.pose, latest.state.goal)
    )
    assert (latest.dt, latest.horizon) == (core.dt, 9)


def vars_of(state):
    return {name: getattr(state, name) for name in ("pose", "twist", "goal", "distance", "time")}


def test_a_transition_survives_pickling():
    core = started(num_worlds=2, reward="balanced")
    ride(core, actions(10, 3, 2, 2, 3))
    kept = pickle.loads(pickle.dumps(last(core)))
    assert_same(core.reward(kept), core.reward(last(core)))
    np.testing.assert_array_equal(core.observation(kept), core.observation(last(core)))


def test_the_transition_of_a_step_is_one_that_the_constructor_makes():
    core = started(num_worlds=2)
    ride(core, actions(12, 2, 2, 2, 3))
    latest = last(core)
    made = replace(latest)  # by the constructor, which refuses an entry too few or too many
    assert vars(made).keys() == vars(latest).keys()
    for entry in fields(Transition):
        if entry.init:
            assert getattr(made, entry.name) is getattr(latest, entry.name), entry.name
    with pytest.raises(FrozenInstanceError):
        latest.success = made.success  # pyright: ignore[reportAttributeAccessIssue]


def test_the_environments_own_decomposition_is_computed_once_whoever_asks():
    core = started(num_worlds=2)
    ride(core, actions(13, 1, 2, 2, 3))
    own = last(core).decomposition
    assert last(core).decomposition is own
    assert last(core).decompose(replace(core.config.decomposition)) is own
    other = last(core).decompose(Settings(torque_weight=0.25))
    assert other is not own
    assert last(core).decompose(Settings(torque_weight=0.25)) is other


def test_a_step_hashes_no_settings(monkeypatch):
    """It took a step of one world as long as the decomposition itself."""
    core = started(num_worlds=1, reward="balanced")
    hashed, original = [], Settings.__hash__
    monkeypatch.setattr(Settings, "__hash__", lambda own: hashed.append(own) or original(own))
    ride(core, actions(14, 3, 1, 2, 3))
    assert not hashed
    last(core).decompose(Settings(torque_weight=0.25))
    assert hashed


def test_a_horizon_truncates_and_a_success_terminates_never_both():
    core = started(num_worlds=32, task=EASY, horizon=12)
    ends = {"terminated": 0, "truncated": 0}
    steps = np.zeros(32, dtype=int)
    for action in actions(11, 150, 32, 2, 3):
        *_, terminated, truncated, info = core.step(action)
        steps += 1
        assert not (terminated & truncated).any()
        np.testing.assert_array_equal(terminated, info["success"])
        np.testing.assert_array_equal(truncated, (steps == 12) & ~terminated)
        ends["terminated"] += terminated.sum()
        ends["truncated"] += truncated.sum()
        steps[terminated | truncated] = 0
        core.reset(mask=terminated | truncated)
    assert min(ends.values()) > 10


def test_rewards_are_the_sum_of_the_parts_that_info_reports():
    core = started(num_worlds=3, reward="balanced", scene=CLUTTERED)
    for (_, reward, _, _, info), *_ in ride(core, actions(12, 40, 3, 2, 3)):
        assert set(info["reward_terms"]) == set(PRESETS["balanced"])
        np.testing.assert_allclose(sum(info["reward_terms"].values()), reward, atol=1e-14)


GOAL = np.array([0.5, -0.3, 0.4])
AWAY, NEAR = GOAL + np.array([1.2, 0.5, -0.6]), GOAL + np.array([0.2, 0.0, 0.0])
BESIDE = GOAL + np.array([0.13, 0.0, 0.0])  # outside the tolerance of 0.1 m


def towards(core, target):
    """Actions of a team that shares a critically damped spring to ``target`` ``(3,)``."""
    pose, twist = core.world.pose[0], core.world.twist[0]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    pull = 12.0 * (target[:2] - pose[:2]) - 12.0 * twist[:2]
    force = np.array([c * pull[0] + s * pull[1], c * pull[1] - s * pull[0]])
    torque = 10.0 * (target[2] - pose[2]) - 7.0 * twist[2]
    limit = 2 * core.config.limits()[0]
    mine = np.array([*force, torque]) / limit[[0, 0, 1]]
    return np.array([[mine, mine * (-1, -1, 1)]])  # agent 1 faces the other way


def played(core, start, target_of):
    """Rewards (team mean) until the episode ends, and whether it ended in success."""
    core.reset(pose=start, goal=GOAL)
    earned = []
    while True:
        action = towards(core, target_of(len(earned)))
        _, reward, terminated, truncated, _ = core.step(action)
        earned.append(reward.mean())
        if terminated[0] or truncated[0]:
            return np.array(earned), bool(terminated[0])


@pytest.mark.parametrize("discount", [1.0, 0.99, 0.95])
@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("start", [AWAY, NEAR], ids=["from afar", "from near"])
def test_finishing_pays_more_than_hovering_beside_the_goal(preset, discount, start):
    core = Transport(reward=preset)
    finish = played(core, start, lambda step: GOAL)
    hover = played(core, start, lambda step: BESIDE)
    circle = played(core, start, lambda step: BESIDE + 0.02 * np.sin([step / 3, step / 5, 0]))
    late = played(core, start, lambda step: BESIDE if step < 100 else GOAL)
    assert (finish[1], hover[1], circle[1], late[1]) == (True, False, False, True)

    def value(rewards):
        return rewards @ discount ** np.arange(len(rewards))

    assert value(finish[0]) > value(late[0])
    for loitering, _ in (hover, circle):
        assert len(loitering) == core.horizon
        assert value(finish[0]) > value(loitering) + 0.2
        assert loitering[100:].sum() < 0  # time beside the goal earns nothing


@pytest.mark.parametrize("preset", PRESETS)
def test_longer_loitering_never_pays_more(preset):
    totals = []
    for horizon in (100, 200, 400):
        core = Transport(reward=preset, horizon=horizon)
        totals.append(played(core, AWAY, lambda _: BESIDE)[0].sum())
    assert totals[0] > totals[1] > totals[2]


def test_a_step_before_the_first_reset_is_refused():
    with pytest.raises(ResetNeeded, match="reset must be called before the first step"):
        Transport().step(np.zeros((1, 2, 3)))


def test_a_step_after_the_end_is_refused_and_moves_nothing():
    core = started(num_worlds=3, horizon=2, task=NEVER)
    ride(core, actions(13, 2, 3, 2, 3))
    pose = core.world.pose.copy()
    with pytest.raises(ResetNeeded, match=r"3 ended \(the first: 0\).*reset\(mask="):
        core.step(np.zeros((3, 2, 3)))
    core.reset(mask=np.array([True, False, True]))
    with pytest.raises(ResetNeeded, match=r"1 ended \(the first: 1\)"):
        core.step(np.zeros((3, 2, 3)))
    np.testing.assert_array_equal(core.world.pose[1], pose[1])
    with pytest.raises(RuntimeError):  # the builtin kind
        core.step(np.zeros((3, 2, 3)))


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (np.zeros((2, 3)), r"action must have shape \(world, agent, 3\) = \(2, 2, 3\), got \(2, 3"),
        (np.zeros((2, 2, 2)), r"action must have shape"),
        (np.zeros((3, 2, 3)), r"action must have shape"),
        (0.0, r"action must have shape"),
        ("push", r"action must be an array of numbers"),
        (None, r"action must "),
        ([[[0, 0, 0], [0, 0]], [[0, 0, 0], [0, 0, 0]]], r"action must be an array of numbers"),
        (np.full((2, 2, 3), np.nan), r"action must be finite, got nan at index \(0, 0, 0\)"),
        (np.where(np.arange(12).reshape(2, 2, 3) == 10, np.inf, 0), r"got inf at index \(1, 1, 1"),
    ],
)
def test_a_wrong_action_is_refused_and_moves_nothing(action, said):
    core, twin = started(num_worlds=2), started(num_worlds=2)
    plan = actions(14, 10, 2, 2, 3)
    ride(core, plan)
    ride(twin, plan)
    before = last(core)
    with pytest.raises(InvalidInput, match=said):
        core.step(action)
    assert last(core) is before
    assert_same(ride(core, plan), ride(twin, plan))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"seed": -1}, r"seed must be a whole number of at least 0"),
        ({"seed": 1.5}, r"seed must be a whole number"),
        ({"seed": True}, r"seed must be a"),
        ({"seed": "lucky"}, r"seed must be"),
        ({"seed": [1, 2]}, r"seed must be one number or one for each of 3 worlds"),
        ({"seed": [1, -2, 3]}, r"seed must be a whole number of at least 0"),
        ({"seed": [1, "b", 3]}, r"seed must be a number"),
        ({"mask": np.array([True, False])}, r"mask must be 3 booleans"),
        ({"mask": np.array([0, 1, 2])}, r"mask must be 3 booleans"),
        ({"mask": True}, r"mask must be 3 booleans"),
        ({"pose": (0.0, 0.0)}, r"pose must have shape \(3,\) or \(3, 3\)"),
        ({"goal": np.zeros((2, 3))}, r"goal must have shape \(3,\) or \(3, 3\)"),
        ({"pose": (0.0, np.nan, 0.0)}, r"pose must be finite"),
        ({"goal": "home"}, r"goal must be an array of numbers"),
        ({"goal": (3.0, 0.0, 0.0)}, r"goal must put the centre of mass inside the room"),
        ({"pose": (9.0, 0.0, 0.0)}, r"pose must put the centre of mass inside the room"),
        ({"pose": [(0, 0, 0), (0, 3.5, 0), (0, 0, 0)]}, r"pose must .* 3\.5, 0\.0\] in world 1"),
    ],
)
def test_a_wrong_reset_is_refused_and_changes_nothing(given, said):
    core, twin = started(num_worlds=3), started(num_worlds=3)
    plan = actions(15, 10, 3, 2, 3)
    with pytest.raises(InvalidInput, match=said):
        core.reset(**given)
    assert_same(ride(core, plan), ride(twin, plan))
    assert_same(core.reset(), twin.reset())


@pytest.mark.parametrize("pose", [(1.5, 2.0, 0.3), (2.9, 0.0, 0.0)], ids=["obstacle", "wall"])
def test_a_start_that_reaches_into_something_solid_is_pushed_out(pose):
    core = started(scene=CLUTTERED, pose=pose, goal=FAR, task=NEVER)
    ride(core, np.zeros((150, 1, 2, 3)))
    outline = corners(core.world.pose[0], Body())
    assert (np.abs(outline) < np.array(CLUTTERED.size) / 2 + 0.01).all()
    shrunk = core.world.pose[0, :2] + 0.95 * (outline - core.world.pose[0, :2])
    assert CLUTTERED.is_clear(shrunk)


def test_a_start_in_an_obstacle_is_refused():
    with pytest.raises(InvalidInput, match=r"pose must .* off its obstacles"):
        Transport(scene=CLUTTERED).reset(pose=(1.5, 1.5, 0.0))


def test_a_start_touching_the_wall_is_taken():
    core = Transport(scene=Scene(size=(6.0, 6.0)))
    core.reset(pose=(2.0, -2.95, 0.0), goal=FAR)
    core.step(np.zeros((1, 2, 3)))
    np.testing.assert_allclose(core.world.pose[0], (2.0, -2.95, 0.0), atol=1e-3)


def test_some_worlds_cannot_be_reset_before_all_have_started():
    with pytest.raises(InvalidInput, match="mask must mark every world before the first step"):
        Transport(num_worlds=2).reset(mask=np.array([True, False]))


def test_a_room_without_a_free_pose_is_refused():
    with pytest.raises(InvalidInput, match=r"task\.min_distance must leave room for a goal"):
        Transport(task=TransportTask(min_distance=50.0)).reset(seed=0)


def test_worlds_may_differ_in_body_and_scene_in_one_batch():
    bodies = [QUINTET, QUINTET, Body(grips=QUINTET.grips, mass=3.0)]
    scenes = [Scene(), CLUTTERED, OPEN_ROOM]
    together = Transport(num_worlds=3, body=bodies, scene=scenes)
    obs, _ = together.reset(seed=0)
    plan = actions(16, 10, 3, 5, 3)
    many = ride(together, plan)
    for k in range(3):
        alone = Transport(body=bodies[k], scene=scenes[k])
        np.testing.assert_array_equal(alone.reset(seed=k)[0][0], obs[k])
        for (result, pose, _), mine in zip(many, ride(alone, plan[:, k : k + 1]), strict=True):
            np.testing.assert_allclose(mine[1][0], pose[k], rtol=0, atol=1e-9)
            np.testing.assert_allclose(mine[0][1][0], result[1][k], rtol=0, atol=1e-6)


def test_a_team_with_other_settings_decomposes_by_these():
    core = Transport(num_worlds=2)
    core.reset(seed=0)
    core.step(actions(0, 1, 2, 2, 3)[0])
    transition = core.transition
    assert transition is not None
    settings = Settings(method="moore_penrose")
    team = replace(transition.team, settings=settings)
    conditions = replace(transition.conditions, team=team)
    other = replace(transition, conditions=conditions)
    np.testing.assert_array_equal(
        other.decomposition.internal, transition.decompose(settings).internal
    )
    assert (other.decomposition.internal != transition.decomposition.internal).any()
    assert team.decomposer() is team.decomposer()
