"""AgileRL: a population of PPO on our Gymnasium vectors, and IPPO on PettingZoo's view."""

# pyright: reportMissingImports=false

import json
from importlib.metadata import version
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import numpy as np
import torch
from agilerl.algorithms import IPPO, PPO
from agilerl.hpo.mutation import Mutations
from agilerl.hpo.tournament import TournamentSelection
from agilerl.training.train_multi_agent_on_policy import train_multi_agent_on_policy
from agilerl.training.train_on_policy import train_on_policy
from agilerl.vector import AsyncPettingZooVecEnv

import coopenv

MODULES = {
    "coopenv/BeamTransport-v0": coopenv.beam_transport_v0,
    "coopenv/WalkerAvoid-v0": coopenv.walker_avoid_v0,
}
IDS = list(MODULES)
WORLDS, PROCESSES, HORIZON = 8, 2, 20
STEPS = 320  # control steps of all worlds, before each of two evaluations
SMALL = {"encoder_config": {"hidden_size": [32]}, "head_config": {"hidden_size": [32]}}
LEARNING: dict[str, Any] = {"net_config": SMALL, "batch_size": 32, "lr": 1e-3, "learn_step": 160}


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view, module in MODULES.items():
        whole_team(view)
        every_agent(view, module)
    checked = (
        "train_on_policy with two PPO on make_vec, their tournament and mutations, and "
        "train_multi_agent_on_policy with IPPO over AsyncPettingZooVecEnv: changed, finite "
        "weights, finite fitness twice, and the same actions from a checkpoint"
    )
    told = {"library": "AgileRL", "version": version("agilerl"), "ids": IDS, "checked": checked}
    print(json.dumps(told))


def whole_team(view: str) -> None:
    """Two PPO of the team, of which the better is kept, and its learning rate mutated."""
    env, twin = (gymnasium.make_vec(view, num_envs=WORLDS, horizon=HORIZON) for _ in range(2))
    spaces = env.single_observation_space, env.single_action_space
    population = [PPO(*spaces, index=i, num_envs=WORLDS, **LEARNING) for i in range(2)]
    before = [copies(agent.actor) for agent in population]
    chances = {"no_mutation": 0.5, "architecture": 0, "parameters": 0, "activation": 0}
    mutation = Mutations(**chances, new_layer_prob=0, rl_hp=0.5, rand_seed=0)
    population, fitness = train_on_policy(
        env,
        view,
        "PPO",
        population,
        tournament=TournamentSelection(2, True, 2),
        mutation=mutation,
        **plan(),
    )
    assert len(population) == len(fitness) == 2
    obs, _ = twin.reset(seed=0)  # training has closed the other one
    for agent in population:
        assert all(differ(start, copies(agent.actor)) for start in before)
        assert_fit(agent)
        action, again = (drawn(one, obs) for one in (agent, reloaded(agent)))
        assert action.shape == twin.action_space.shape
        np.testing.assert_array_equal(action, again)


def every_agent(view: str, module: Any) -> None:
    """Each agent acts on what it sees itself; both have the same policy."""
    env = made(module)
    names = env.possible_agents
    agent = IPPO(
        [env.single_observation_space(name) for name in names],
        [env.single_action_space(name) for name in names],
        agent_ids=names,
        **LEARNING,
    )
    assert list(agent.actors) == ["agent"]
    before = copies(agent.actors)
    (agent,), _ = train_multi_agent_on_policy(env, view, "IPPO", [agent], **plan())
    assert differ(before, copies(agent.actors))
    assert_fit(agent)
    env = made(module)
    obs, _ = env.reset(seed=0)
    action, again = (drawn(one, obs) for one in (agent, reloaded(agent)))
    for name in names:
        assert action[name].shape == (PROCESSES, *env.single_action_space(name).shape)
        np.testing.assert_array_equal(action[name], again[name])
    env.close()


def made(module: Any) -> AsyncPettingZooVecEnv:
    """Worlds of PettingZoo's view, each in a process."""
    return AsyncPettingZooVecEnv([lambda: module.parallel_env(horizon=HORIZON)] * PROCESSES)


def plan() -> dict[str, Any]:
    """How long training takes, and that it says nothing."""
    return {
        "max_steps": 2 * STEPS,
        "evo_steps": STEPS,
        "eval_steps": HORIZON,
        "verbose": False,
    }


def copies(module: torch.nn.Module) -> list[torch.Tensor]:
    """A module's weights as they are now."""
    return [weight.detach().clone() for weight in module.parameters()]


def differ(before: list[torch.Tensor], after: list[torch.Tensor]) -> bool:
    """Whether a weight has changed; all must be finite."""
    assert all(torch.isfinite(weight).all() for weight in after)
    return any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))


def assert_fit(agent: Any) -> None:
    """That it was evaluated twice, and what came of it is a number."""
    assert len(agent.fitness) == 2
    assert np.isfinite(agent.fitness).all()


def drawn(agent: Any, obs: Any) -> Any:
    """What it draws to do, the same whenever it is asked."""
    agent.set_training_mode(False)
    torch.manual_seed(0)
    return agent.get_action(obs)[0]


def reloaded(agent: Any) -> Any:
    """The agent from its own checkpoint."""
    with TemporaryDirectory() as folder:
        agent.save_checkpoint(f"{folder}/agent.pt")
        return type(agent).load(f"{folder}/agent.pt")


if __name__ == "__main__":
    main()
