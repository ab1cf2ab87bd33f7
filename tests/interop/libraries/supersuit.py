"""SuperSuit: the lines of PettingZoo's tutorial that bring a parallel environment to SB3."""

import json
from tempfile import TemporaryDirectory

import numpy as np
import supersuit
import torch
from stable_baselines3 import PPO

import coopenv

MODULES = {
    "coopenv/BeamTransport-v0": coopenv.beam_transport_v0,
    "coopenv/WalkerTurn-v0": coopenv.walker_turn_v0,
}
IDS = list(MODULES)


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for module in MODULES.values():
        learn(module)
        alter(module)
    checked = (
        "pettingzoo_env_to_vec_env_v1, concat_vec_envs_v1 and PPO with one policy for all agents, "
        "alike from a file; clip_actions_v0, frame_stack_v2, dtype_v0"
    )
    version = supersuit.__version__
    told = {"library": "SuperSuit", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def learn(module) -> None:
    """As the tutorial has it: one policy, a row an agent."""
    env = module.parallel_env(horizon=20)
    env.reset(seed=0)
    count = len(env.possible_agents)
    env = supersuit.pettingzoo_env_to_vec_env_v1(env)
    env = supersuit.concat_vec_envs_v1(env, 3, num_cpus=1, base_class="stable_baselines3")
    assert env.num_envs == 3 * count
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=64, n_epochs=2, seed=None)
    start = [weight.detach().clone() for weight in model.policy.parameters()]
    model.learn(32 * env.num_envs * 2)
    moved = zip(start, model.policy.parameters(), strict=True)
    assert any(not torch.equal(before, after) for before, after in moved)
    obs = env.reset()
    assert obs.shape == (3 * count, *env.observation_space.shape)
    with TemporaryDirectory() as folder:
        model.save(f"{folder}/model")
        again = PPO.load(f"{folder}/model")
    mine, theirs = (one.predict(obs, deterministic=True)[0] for one in (model, again))
    np.testing.assert_array_equal(mine, theirs)
    env.close()


def alter(module) -> None:
    """Wrappers of other kinds around the parallel environment."""
    env = supersuit.clip_actions_v0(module.parallel_env(horizon=5))
    env = supersuit.frame_stack_v2(supersuit.dtype_v0(env, np.float64), 3)
    obs, _ = env.reset(seed=0)
    bare = module.parallel_env(horizon=5)
    plain, _ = bare.reset(seed=0)
    for agent in env.possible_agents:
        assert obs[agent].dtype == np.float64
        np.testing.assert_array_equal(obs[agent][-plain[agent].size :], plain[agent])
    for _ in range(5):
        plan = {agent: env.action_space(agent).sample() for agent in env.agents}
        got, wanted = env.step(plan), bare.step(plan)
        assert got[1] == wanted[1]
        assert got[3] == wanted[3]
    assert not env.agents


if __name__ == "__main__":
    main()
