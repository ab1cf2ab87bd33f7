"""The same world through each interface: Gymnasium, Gymnasium vector, PettingZoo, the core."""

import gymnasium as gym
import numpy as np

import coopenv

env = gym.make("coopenv/BeamTransport-v0")
obs, info = env.reset(seed=0)
total = 0.0
for _ in range(20):
    obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
    total += float(reward)
print(f"Gymnasium:  return {total:+.3f}, F_I {info['internal_force_level']:.2f} N")

envs = gym.make_vec("coopenv/BeamTransport-v0", num_envs=256)
obs, info = envs.reset(seed=0)
for _ in range(20):
    obs, reward, terminated, truncated, info = envs.step(envs.action_space.sample())
print(f"vector:     256 worlds, mean gamma {info['relative_cost'].mean():.2f}")

parallel = coopenv.beam_transport_v0.parallel_env(reward="harmony")
obs, info = parallel.reset(seed=0)
while parallel.agents:
    actions = {agent: parallel.action_space(agent).sample() for agent in parallel.agents}
    obs, reward, terminated, truncated, info = parallel.step(actions)
print(f"PettingZoo: {info['agent_0']['reward_terms']}")

core = coopenv.Transport(num_worlds=1024)
obs, info = core.reset(seed=0)
action = np.zeros((1024, 2, 3))  # (world, agent, [fx, fy, tz]), each towards the beam's middle
action[:, :, 0] = 1.0
obs, reward, terminated, truncated, info = core.step(action)
print(f"core:       squeezing gives gamma {info['relative_cost'].min():.2f} in every world")
