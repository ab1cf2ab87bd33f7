"""Training with RLlib, here or on a cluster; what comes of it is a policy as any other."""

import os
from collections.abc import Callable
from typing import Any

import numpy as np

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import locked, require_folder

from ..evaluate import Evaluation, evaluate, save
from ..experiments.nodes import joined
from ..provenance import Provenance
from ..trained import PlainPolicy
from .settings import RLlibConfig

POLICY, EVALUATION, CHECKPOINT = "policy.npz", "evaluation.json", "checkpoint"
SHARED = "shared"  # name of the policy that all agents run
VALUE_CLIP = 1e6  # RLlib's bound on the value's squared error, which returns of ours may exceed
GRADIENT_CLIP = 0.5

Tell = Callable[[dict[str, float]], None]
"""Called after every update with control steps and the mean return of an agent's team."""


def train(config: RLlibConfig, tell: Tell = lambda row: None) -> tuple[PlainPolicy, Evaluation]:
    """Train, write the policy and its evaluation; both.

    Raises
    ------
    InvalidInput
        If a setting breaks its rule, the folder holds a policy already, or no cluster answers.
    MissingExtra
        If RLlib is not installed.
    """
    require_rllib()
    environment = config.environment.config()
    record = Provenance.of_environment(environment, _control(config))
    require_folder(config.out)
    with locked(config.out):
        if (config.out / POLICY).exists():
            raise InvalidInput(
                f"out must hold no policy, got {config.out}, which has one; choose another out "
                "(--out), or move it away"
            )
        with joined(config.address):
            policy = _trained(config, environment, record, tell)
        seen = evaluate(policy, environment, episodes=config.episodes, name="rllib")
        save([seen], config.out / EVALUATION)
        policy.save(config.out / POLICY)
    return policy, seen


def require_rllib() -> Any:
    """RLlib's PPO; raises `MissingExtra` unless it is installed."""
    try:
        from ray.rllib.algorithms import ppo  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtra("training with RLlib", "rllib") from error
    return ppo


def settings_of(config: RLlibConfig, environment: TransportConfig, agents: list[str]) -> Any:
    """RLlib's own configuration, on its current API stack."""
    ppo = require_rllib()
    from ray.rllib.core.rl_module.default_model_config import (  # pyright: ignore[reportMissingImports]
        DefaultModelConfig,
    )

    from .environment import CarryingEnv

    given = {"environment": environment.to_json(), "seed": config.seed, "worlds": config.worlds}
    shared = config.policies == SHARED
    return (
        ppo.PPOConfig()
        .api_stack(enable_rl_module_and_learner=True, enable_env_runner_and_connector_v2=True)
        .environment(CarryingEnv, env_config=given)
        .env_runners(num_env_runners=config.runners, num_envs_per_env_runner=config.worlds)
        .fault_tolerance(restart_failed_env_runners=True)  # as those of a node that is lost
        .learners(num_learners=0)
        .training(
            train_batch_size_per_learner=config.batch_size,
            minibatch_size=config.minibatch_size,
            num_epochs=config.epochs,
            lr=[[0, config.learning_rate], [config.steps, 0.0]],
            gamma=config.discount,
            lambda_=config.gae_lambda,
            clip_param=config.clip_range,
            entropy_coeff=config.entropy_weight,
            use_kl_loss=False,
            vf_clip_param=VALUE_CLIP,
            grad_clip=GRADIENT_CLIP,
        )
        .rl_module(
            model_config=DefaultModelConfig(
                fcnet_hiddens=list(config.hidden),
                fcnet_activation="tanh",
                free_log_std=environment.table is None,
                vf_share_layers=False,
            )
        )
        .multi_agent(
            policies={SHARED} if shared else set(agents),
            policy_mapping_fn=all_share if shared else each_its_own,
        )
        .debugging(seed=config.seed, log_level="ERROR")
    )


def all_share(agent: str, episode: Any, **rest: Any) -> str:
    """The policy of an agent."""
    return SHARED


def each_its_own(agent: str, episode: Any, **rest: Any) -> str:
    """The policy of an agent."""
    return agent


def _trained(
    config: RLlibConfig, environment: TransportConfig, record: Provenance, tell: Tell
) -> PlainPolicy:
    """The policy after all steps; RLlib's checkpoint of it is in the folder."""
    from ..features import scale_of_features
    from .environment import view_of
    from .exchange import plain_policy

    view = view_of(environment)
    agents = view.possible_agents
    algorithm = settings_of(config, environment, agents).build_algo()
    try:
        done = 0
        while done < config.steps:
            seen = algorithm.train()["env_runners"]
            done = int(np.sum(seen["num_env_steps_sampled_lifetime"]))
            tell({"steps": done, "return": float(seen.get("episode_return_mean", np.nan))})
        algorithm.save_to_path(os.path.abspath(config.out / CHECKPOINT))
        names = [SHARED] if config.policies == SHARED else agents
        modules = [algorithm.get_module(name) for name in names]
        spaces = view.observation_space(agents[0]), view.action_space(agents[0])
        scale = scale_of_features(view.transport)
        return plain_policy(modules, scale, spaces, record.to_notes())
    finally:
        algorithm.stop()


def _control(config: RLlibConfig) -> str:
    """How our own records call it: several networks of a team are one that moves all."""
    return "shared" if config.policies == SHARED else "joint"
