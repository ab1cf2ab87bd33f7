"""The TorchRL view: specs that hold, the core's own numbers, episodes that end apart."""

import copy
import pickle
import sys
from importlib import import_module
from types import ModuleType

import numpy as np
import pytest

from coopenv import Transport
from coopenv.errors import InvalidInput, MissingExtra, ResetNeeded, UnknownName
from coopenv.rewards import Success
from tests.helpers import ALONG, CASE_NAMES, CASES, EASY, IDS, NEVER, OPTIONS, actions, spoil

torch = pytest.importorskip("torch")
pytest.importorskip("torchrl")

from tensordict import TensorDict  # noqa: E402
from torchrl.data import Bounded, Categorical  # noqa: E402
from torchrl.envs import EnvBase  # noqa: E402
from torchrl.envs.utils import check_env_specs  # noqa: E402

from coopenv.agents import torchrl  # noqa: E402

ACTION, OBSERVATION, REWARD = (("agents", name) for name in ("action", "observation", "reward"))
SPACES = (  # what observations, actions, agents and infos may be like
    "forces", "every block", "imperfect senses", "three agents", "one agent", "randomised plate",
    "partner", "two of three driven", "discrete", "bounded", "cost",
)  # fmt: skip


@pytest.fixture(autouse=True)
def _same_random_actions():
    torch.manual_seed(1)


def small(**keywords):
    """Three worlds whose episodes end soon, some of them early."""
    options = {"num_worlds": 3, "seed": 5, "task": EASY, "horizon": 8, **keywords}
    return torchrl.make_env(**options)


def check_both_ways(env):
    """TorchRL's own check, of a rollout that stops at an end and of one that goes on."""
    check_env_specs(env, break_when_any_done=True)
    check_env_specs(env, break_when_any_done=False)


@pytest.mark.parametrize("view", IDS)
def test_torchrl_finds_the_specs_of_an_id_right(view: str):
    check_both_ways(torchrl.make_env(view, 2, horizon=2))


@pytest.mark.parametrize("name", SPACES)
def test_torchrl_finds_all_specs_right_whatever_the_spaces(name: str):
    options = {"horizon": 2, **OPTIONS[name]}
    check_both_ways(torchrl.make_env(num_worlds=2, info=True, return_state=True, **options))


def test_specs_tell_bounds_numbers_of_pushes_and_costs():
    env = small(info=("cost", "cost/internal_force"), **OPTIONS["discrete"])
    seen, action = env.observation_spec[OBSERVATION], env.full_action_spec[ACTION]
    assert isinstance(seen, Bounded)
    assert torch.isfinite(seen.low).all()
    assert isinstance(action, Categorical)
    assert env.transport.table is not None
    assert action.n == len(env.transport.table)
    assert action.shape == (3, 2)
    cost = env.rollout(3)["next", "agents", "info", "cost"]
    assert cost.shape[-2:] == (2, 1)
    assert cost.dtype == torch.float32


@pytest.mark.slow
@pytest.mark.parametrize(("view", "name", "keywords"), CASES, ids=CASE_NAMES)
def test_torchrl_finds_the_specs_of_every_documented_option_right(view, name, keywords):
    check_both_ways(torchrl.make_env(view, 3, info=True, return_state=True, **keywords))


def test_a_rollout_is_the_core_s_with_its_resets():
    steps = small(num_worlds=12).rollout(20, break_when_any_done=False)
    core = Transport(num_worlds=12, task=EASY, horizon=8)
    seen, _ = core.reset(seed=5)
    ends = np.zeros(12, dtype=int)
    for t in range(20):
        step = steps[:, t]
        np.testing.assert_array_equal(step[OBSERVATION], seen)
        seen, reward, terminated, truncated, _ = core.step(step[ACTION].numpy())
        after = step["next"]
        np.testing.assert_array_equal(after[OBSERVATION], seen)  # an episode's last one too
        np.testing.assert_array_equal(after[REWARD].squeeze(-1), reward.astype(np.float32))
        done = terminated | truncated
        for name, flags in (("terminated", terminated), ("truncated", truncated), ("done", done)):
            np.testing.assert_array_equal(after[name].squeeze(-1), flags)
        ends += terminated.astype(int) + 100 * truncated
        if done.any():
            seen, _ = core.reset(mask=done)
    assert (ends % 100).any()
    assert (ends // 100).any()


def test_worlds_begin_as_in_other_views_with_the_same_seed():
    env = torchrl.make_env("coopenv/BeamDoorway-v0", 3, seed=7)
    expected, _ = Transport(num_worlds=3, config=env.transport.config).reset(seed=7)
    np.testing.assert_array_equal(env.reset()[OBSERVATION], expected)
    second = env.reset()[OBSERVATION]
    assert not np.array_equal(second, expected)
    env.set_seed(7)
    np.testing.assert_array_equal(env.reset()[OBSERVATION], expected)
    np.testing.assert_array_equal(env.reset()[OBSERVATION], second)


def test_a_marked_world_begins_anew_and_others_go_on():
    env, mask = small(task=NEVER, horizon=50), torch.tensor([[False], [True], [False]])
    moved = env.step(env.rand_action(env.reset()))["next"]
    again = env.reset(moved.clone().set("_reset", mask))
    assert torch.equal(again[OBSERVATION][::2], moved[OBSERVATION][::2])
    assert not torch.equal(again[OBSERVATION][1], moved[OBSERVATION][1])
    env.step(env.rand_action(again))


def test_a_reset_takes_a_start_and_a_goal():
    env = small()
    seen = env.reset(pose=(1.0, 0.5, 0.0), goal=(1.0, 0.5, 1.0))[OBSERVATION]
    assert torch.allclose(seen, seen[:1].expand_as(seen))
    assert env.transport.transition is not None
    np.testing.assert_allclose(env.transport.transition.next_state.pose[2], (1.0, 0.5, 0.0))


def test_worlds_that_ended_first_wait_until_all_have():
    steps = small(num_worlds=12).rollout(40, break_when_any_done=False, break_when_all_done=True)
    done = steps["next", "done"].squeeze(-1)
    first = done.int().argmax(dim=1)
    assert done[:, -1].all()
    assert len(set(first.tolist())) > 1
    core = Transport(num_worlds=12, task=EASY, horizon=8)
    seen, _ = core.reset(seed=5)
    for t in range(int(first.min()) + 1):  # up to there no world rests
        np.testing.assert_array_equal(steps[:, t][OBSERVATION], seen)
        seen = core.step(steps[:, t][ACTION].numpy())[0]
    for k, end in enumerate(first.tolist()):
        last = steps[k, end]["next"]
        for later in steps[k, end:]["next"].unbind(0):
            assert (later == last).all()


def ended_apart(steps=1):
    """An environment, its step in which one world ended before the others, and which go on."""
    env = small(task=NEVER)
    data = env.reset()
    for _ in range(steps):
        data = env.step(env.rand_action(data))["next"]
    data = env.reset(data.set("_reset", torch.tensor([[True], [False], [True]])))
    while not data["done"].any():
        data = env.step(env.rand_action(data))["next"]
    return env, data, ~data["done"].squeeze(-1)


def test_a_world_that_is_not_stepped_keeps_what_it_saw_and_earns_nothing():
    env, data, running = ended_apart()
    assert running.tolist() == [True, False, True]
    after = env.step(env.rand_action(data.clone()).set("_step", running))["next"]
    assert torch.equal(after[OBSERVATION][1], data[OBSERVATION][1])
    assert not torch.equal(after[OBSERVATION][0], data[OBSERVATION][0])
    assert after["done"].squeeze(-1).tolist() == [True, True, True]
    assert not after[REWARD][1].any()
    assert after[REWARD][0].all()
    with pytest.raises(ResetNeeded, match=r"must be reset .* got a step of world 1; call reset"):
        env.step(env.rand_action(data))
    env.step(env.rand_action(env.reset(after.set("_reset", after["done"].clone()))))


def test_a_world_that_runs_has_to_be_stepped():
    env = small()
    data = env.rand_action(env.reset()).set("_step", torch.tensor([True, False, True]))
    with pytest.raises(InvalidInput, match=r"_step must mark every world .* False for world 1"):
        env.step(data)


def test_infos_are_rows_of_the_agents_that_learn():
    options = {**OPTIONS["two of three driven"], "randomise": None, "observe": ("goal", "twist")}
    env = torchrl.make_env(num_worlds=2, info=True, seed=3, **options)
    core = Transport(num_worlds=2, **options)
    core.reset(seed=3)
    told = env.step(env.rand_action(env.reset()))
    info = core.step(told[ACTION].numpy())[4]
    told = told["next", "agents", "info"]
    assert set(told.keys()) == set(info)
    np.testing.assert_array_equal(
        told["internal_wrench"], info["internal_wrench"][:, [1]].astype(np.float32)
    )
    np.testing.assert_array_equal(
        told["reward/progress"][..., 0], info["reward/progress"].astype("f4")
    )
    np.testing.assert_array_equal(
        told["relative_cost"][:, 0, 0], info["relative_cost"].astype("f4")
    )
    np.testing.assert_array_equal(told["partner_plan"][:, 0], info["partner_plan"].astype("f4"))
    assert told["success"].dtype == torch.bool


def test_only_infos_that_are_asked_for_are_handed_out():
    env = small(info=("success", "body/mass"), randomise=ALONG)
    told = env.reset()["agents", "info"]
    assert set(told.keys()) == {"success", "body/mass"}
    assert torch.equal(told["body/mass"][:, 0], told["body/mass"][:, 1])
    assert set(small().reset()["agents"].keys()) == {"observation"}
    with pytest.raises(UnknownName, match="did you mean 'relative_cost'"):
        small(info=["relative_costs"])


def test_the_state_is_what_all_agents_see_one_after_the_other():
    env = small(return_state=True)
    steps = env.rollout(12, break_when_any_done=False)
    for each in (steps, steps["next"]):
        assert torch.equal(each["state"], each[OBSERVATION].flatten(-2))
    assert env.observation_spec["state"].shape == (3, 44)
    assert "state" not in set(small().reset().keys())


def test_what_is_done_to_tensors_changes_no_later_step():
    joint = torch.from_numpy(actions(0, 20, 3, 2, 3)).float()
    kept, spoilt = small(info=True), small(info=True)
    first, second = kept.reset(), spoilt.reset()
    for action in joint:
        first, after = kept.step_and_maybe_reset(first.set(ACTION, action))[::-1]
        step, second = spoilt.step_and_maybe_reset(second.set(ACTION, action.clone()))
        assert (step["next"] == after["next"]).all()
        assert torch.equal(first[OBSERVATION], second[OBSERVATION])
        second = second.clone()
        spoil({str(k): v.numpy() for k, v in step.items(True, True)})


def test_tensors_are_on_the_device_of_the_environment():
    env = small(info=("success",))
    vars(env)["_device"] = torch.device("meta")  # where env.to() and reset() fail: nothing is there
    handed = env._reset(None)
    assert handed.device == torch.device("meta")
    assert {handed.get(name).device.type for name in handed.keys(True, True)} == {"meta"}


def test_agents_that_a_partner_drives_are_not_in_the_group():
    env = torchrl.make_env(num_worlds=2, partner="stubborn")
    assert env.group_map == {"agents": ["agent_0"]}
    assert env.reset()[OBSERVATION].shape == (2, 1, 22)
    assert small().group_map == {"agents": ["agent_0", "agent_1"]}


def test_features_are_scaled_as_for_stable_baselines():
    pytest.importorskip("stable_baselines3")
    from coopenv.agents import sb3

    venv = sb3.make_vec_env(num_worlds=2, control="joint", **OPTIONS["three agents"])
    scale = torchrl.feature_scale(torchrl.make_env(num_worlds=2, **OPTIONS["three agents"]))
    assert len(scale) == venv.transport.observation.size
    assert scale * 3 == sb3.feature_scale(venv)


def test_random_actions_fill_the_whole_box():
    env = torchrl.make_env(num_worlds=200)
    drawn = env.rand_action(env.reset()).select(ACTION)
    action = drawn[ACTION]
    assert action.shape == (200, 2, 3)
    assert action.min() < -0.9
    assert action.max() > 0.9
    assert env.full_action_spec.is_in(drawn)


def test_wrong_calls_say_what_to_do():
    env = small()
    with pytest.raises(ResetNeeded, match=r"call reset\(\)"):
        env.step(env.rand_action(TensorDict({}, [3])))
    data = env.reset()
    with pytest.raises(InvalidInput, match=r"must hold \('agents', 'action'\)"):
        env.step(data)
    with pytest.raises(InvalidInput, match="action must have shape"):
        env.step(data.set(ACTION, torch.zeros(3, 2, 2)))
    with pytest.raises(InvalidInput, match="env must be an id to take keywords"):
        torchrl.make_env(env.transport.config, horizon=3)
    with pytest.raises(InvalidInput, match="seed must be"):
        env.set_seed(-1)
    with pytest.raises(InvalidInput, match="mask must mark every world before the first step"):
        small().reset(TensorDict({"_reset": torch.tensor([True, False, True])}, [3]))


def test_a_reward_that_no_learner_can_square_is_refused():
    env = small(reward=lambda transition: 1e13 * Success()(transition) + 1e13)
    data = env.rand_action(env.reset())
    with pytest.raises(InvalidInput, match="must be finite and at most 1e"):
        env.step(data)


def test_a_copy_through_pickle_steps_alike():
    env = small(seed=None)
    copy = pickle.loads(pickle.dumps(env))
    joint = torch.from_numpy(actions(1, 1, 3, 2, 3)[0]).float()
    for each in (env, copy):
        each.set_seed(4)
    first, second = (each.step(each.reset().set(ACTION, joint))["next"] for each in (env, copy))
    assert (first == second).all()


def ride(env, data, joint):
    """What comes of some joint actions from ``data`` on, with resets where episodes end."""
    seen = []
    for action in joint:
        step, data = env.step_and_maybe_reset(data.set(ACTION, action.clone()))
        seen.append(step["next"])
    return torch.stack(seen)


def plan_of(steps):
    return torch.from_numpy(actions(2, steps, 3, 2, 3)).float()


def test_from_a_state_the_same_actions_lead_to_the_same_tensors():
    env = small(info=True, return_state=True)
    ride(env, env.reset(), plan_of(3))
    state, joint = env.get_state(), plan_of(20)
    first = ride(env, env.set_state(state), joint)
    assert first["done"].any()
    assert (ride(env, env.set_state(state), joint) == first).all()
    other = small(info=True, return_state=True, seed=9)
    assert (ride(other, other.set_state(state), joint) == first).all()


@pytest.mark.parametrize("again", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_within_an_episode_goes_on_alike(again):
    env, joint = small(info=True), plan_of(20)
    data = ride(env, env.reset(), plan_of(3))[-1].exclude(REWARD)
    other, theirs = again(env), data.clone()
    assert (ride(env, data, joint) == ride(other, theirs, joint)).all()


def test_a_state_knows_which_worlds_wait_for_a_reset():
    env, data, running = ended_apart(3)
    env.step(env.rand_action(data.clone()).set("_step", running))
    state = env.get_state()
    assert env.reset()["done"].sum() == 0
    env.step(env.rand_action(env.reset()))  # none waits
    told = env.set_state(state)
    assert told["done"].squeeze(-1).tolist() == [False, True, False]
    assert told["truncated"].squeeze(-1).tolist() == [False, True, False]
    with pytest.raises(ResetNeeded, match="got a step of world 1"):
        env.step(env.rand_action(told))
    awake = env.set_state(state.take([0]), [1])  # of a world that runs
    assert not awake["done"].any()
    env.step(env.rand_action(awake))
    env.set_state(state)
    core = Transport(num_worlds=3, config=env.transport.config)
    core.reset(seed=0)
    env.step(env.rand_action(env.set_state(core.get_state())))  # of another view: none waits


def test_a_step_of_our_own_is_that_of_torchrl():
    ours, theirs = small(info=True, return_state=True), small(info=True, return_state=True)
    action = plan_of(1)[0]
    first, second = (env.reset().set(ACTION, action.clone()) for env in (ours, theirs))
    assert ours.step(first) is first
    EnvBase.step(theirs, second)
    assert (first == second).all()
    assert set(first.keys(True, True)) == set(second.keys(True, True))
    with pytest.raises(RuntimeError, match="Expected a tensordict with shape"):
        ours.step(first["next"][:2])
    kept = first["next"].set(ACTION, action).set("next", TensorDict({"mark": torch.ones(3)}, [3]))
    assert ours.step(kept)["next", "mark"].all()  # what is there already stays, as in TorchRL


def test_a_world_can_be_drawn():
    pytest.importorskip("pygame")
    env = small()
    assert env.render() is None
    env.reset()
    picture = env.render(world=2)
    assert picture is not None
    assert picture.shape[-1] == 3
    assert picture.dtype == np.uint8
    env.close()


def test_without_torchrl_the_extra_is_named(monkeypatch):
    for name in ("env", "specs", "told", "resting"):
        monkeypatch.delitem(sys.modules, f"coopenv.agents.torchrl.{name}")
    monkeypatch.delitem(sys.modules, "coopenv.agents.torchrl")
    monkeypatch.setitem(sys.modules, "torchrl.envs", None)
    with pytest.raises(MissingExtra, match=r"pip install 'coopenv\[torchrl\]'"):
        import_module("coopenv.agents.torchrl")


def test_without_benchmarl_its_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "benchmarl.environments", None)
    with pytest.raises(MissingExtra, match=r"pip install 'coopenv\[benchmarl\]'"):
        import_module("coopenv.agents.torchrl.benchmarl")


@pytest.mark.parametrize("continuous", [True, False])
def test_a_task_of_benchmarl_gives_the_actions_that_are_asked_for(continuous, monkeypatch):
    class Task:  # BenchMARL's own, as far as it matters
        def __init__(self, name, config):
            self.name, self.config = name, config

    environments = ModuleType("benchmarl.environments")
    vars(environments)["TaskClass"] = Task
    monkeypatch.setitem(sys.modules, "benchmarl", ModuleType("benchmarl"))
    monkeypatch.setitem(sys.modules, "benchmarl.environments", environments)
    monkeypatch.delitem(sys.modules, "coopenv.agents.torchrl.benchmarl", raising=False)
    module = import_module("coopenv.agents.torchrl.benchmarl")
    monkeypatch.delitem(sys.modules, "coopenv.agents.torchrl.benchmarl")
    task = module.make_task(horizon=7)
    assert task.supports_continuous_actions()
    assert task.supports_discrete_actions()
    env = task.get_env_fun(3, continuous, 0, "cpu")()
    assert env.batch_size == (3,)
    assert task.max_steps(env) == 7
    spec = task.action_spec(env)["agents", "action"]
    assert spec.dtype.is_floating_point == continuous
    env.close()
