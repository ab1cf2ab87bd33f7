"""Costs apart from rewards: the same terms, told in the infos of every view."""

import gymnasium
import numpy as np
import pytest

from coopenv import Transport, TransportConfig, beam_transport_v0, rewards
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.agents.policy import RandomPolicy
from coopenv.errors import InvalidInput, UnknownName
from tests.helpers import IDS, TRIO, actions, constant, parallel_actions, vec_env

VIEW = "coopenv/BeamTransport-v0"
GENTLE = rewards.RewardSum(
    {"squeeze": rewards.InternalForce(weight=0.5), "effort": rewards.Effort()}
)


def bad(transition):
    return np.full(transition.applied.shape[:2], np.nan)


def test_a_term_costs_what_it_takes_from_a_reward():
    priced = Transport(num_worlds=3, cost=GENTLE)
    paid = Transport(num_worlds=3, reward=GENTLE)
    priced.reset(seed=0)
    paid.reset(seed=0)
    for action in actions(0, 5, 3, 2, 3):
        *_, info = priced.step(action)
        _, reward, *_, same = paid.step(action)
        np.testing.assert_array_equal(info["cost"], -reward)
        assert list(info["cost_terms"]) == ["squeeze", "effort"]
        for name, part in info["cost_terms"].items():
            np.testing.assert_array_equal(part, -same["reward_terms"][name])
            np.testing.assert_array_equal(part, info[f"cost/{name}"])
        assert (info["cost"] > 0).all()


@pytest.mark.parametrize("view", IDS)
def test_nothing_but_the_infos_knows_of_a_cost(view):
    with_cost, without = gymnasium.make(view, cost="squeeze"), gymnasium.make(view)
    _, first = with_cost.reset(seed=0)
    _, other = without.reset(seed=0)
    assert set(first) - set(other) == {"cost", "cost/internal_force"}
    assert first["cost"] == 0.0
    mine, theirs = (env.step(constant(env, 0.5)) for env in (with_cost, without))
    np.testing.assert_array_equal(mine[0], theirs[0])
    assert mine[1:4] == theirs[1:4]


def test_every_view_tells_the_cost_where_it_tells_the_reward():
    keywords = {"cost": GENTLE, "body": TRIO, "partner": "noisy", "partner_agents": (1,)}
    core = Transport(config=TransportConfig(**keywords))
    single = gymnasium.make(VIEW, **keywords)
    vector = gymnasium.make_vec(VIEW, num_envs=1, **keywords)
    team = beam_transport_v0.parallel_env(**keywords)
    shared = vec_env(VIEW, 1, control="shared", seed=4, **keywords)
    joint = vec_env(VIEW, 1, seed=4, **keywords)
    for env in (core, single, vector, team):
        env.reset(seed=4)
    shared.reset()
    joint.reset()
    for action in actions(1, 4, 2, 3).astype(np.float32):
        cost = core.step(action[None])[-1]["cost"]
        assert cost.shape == (1, 2)
        flat = action.reshape(-1)
        assert single.step(flat)[-1]["cost"] == pytest.approx(cost.mean())
        assert vector.step(flat[None])[-1]["cost"] == pytest.approx([cost.mean()])
        told = team.step(parallel_actions(team, action))[-1]
        assert [told[name]["cost"] for name in ("agent_0", "agent_2")] == cost[0].tolist()
        assert [info["cost"] for info in shared.step(action)[-1]] == cost[0].tolist()
        assert joint.step(flat[None])[-1][0]["cost"] == pytest.approx(cost.mean())


def test_stable_baselines_and_evaluations_report_the_cost_of_an_episode():
    config = TransportConfig(cost=GENTLE, horizon=3)
    venv = vec_env(config, 1, seed=0)
    venv.reset()
    paid = [venv.step(action[None])[-1][0] for action in actions(2, 3, 6)]
    ended = paid[-1]["episode"]
    assert ended["cost"] == pytest.approx(sum(info["cost"] for info in paid))
    assert ended["cost"] == pytest.approx(ended["cost/squeeze"] + ended["cost/effort"])
    seen = run_episodes(RandomPolicy(config), config, episodes=5, num_worlds=2)
    assert seen.costs["cost"].shape == (5, 2)
    result = evaluate(RandomPolicy(config), config, episodes=5)
    assert result.cost == pytest.approx(seen.costs["cost"].mean())
    assert np.isnan(evaluate(RandomPolicy(config), TransportConfig(horizon=3), episodes=2).cost)


def test_a_world_that_begins_anew_costs_nothing():
    core = Transport(num_worlds=2, cost="squeeze", horizon=1)
    core.reset(seed=0)
    push = np.tile([1.0, 0, 0], (2, 2, 1))
    *_, info = core.step(push)
    assert (info["cost"] == 10.0).all()
    *_, info = core.step(push, restart=np.array([True, True]))
    assert (info["cost"] == 0.0).all()
    assert not np.signbit(info["cost"]).any()


def test_costs_are_named_given_as_a_term_or_as_a_preset():
    assert TransportConfig(cost="contact").costs == rewards.COSTS["contact"]
    assert TransportConfig(cost="balanced").costs == rewards.PRESETS["balanced"]
    one = TransportConfig(cost=rewards.ActionRate()).costs  # pyright: ignore[reportArgumentType]
    assert one is not None
    assert list(one) == ["ActionRate"]
    assert TransportConfig().costs is None


@pytest.mark.parametrize(
    ("cost", "kind", "words"),
    [
        ("contct", UnknownName, "cost must be one of .*did you mean 'contact'"),
        (3, InvalidInput, "cost must be a preset name"),
        (rewards.LoadShare(wanted=(1.0, 0.0, 0.0)), InvalidInput, "one for each of 2 agents"),
    ],
)
def test_a_cost_that_is_none_is_refused(cost, kind, words):
    with pytest.raises(kind, match=words):
        TransportConfig(cost=cost)


def test_a_cost_that_is_not_finite_is_refused_by_the_name_of_its_term():
    core = Transport(cost={"heat": bad})
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match="cost 'heat' must be finite"):
        core.step(np.zeros((1, 2, 3)))
