"""Models of Stable-Baselines3 in plain numbers and back: what acts of them, layer by layer."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.distributions import CategoricalDistribution as Categorical
from stable_baselines3.common.distributions import DiagGaussianDistribution as Gaussian
from stable_baselines3.common.distributions import MultiCategoricalDistribution as Categoricals
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor, MlpExtractor
from stable_baselines3.dqn.policies import DQNPolicy
from stable_baselines3.td3.policies import Actor as TD3Actor

from coopenv.errors import InvalidInput

from ..trained.form import Form
from ..trained.normalization import Normalization
from ..trained.spaces import NotPlain
from .algorithms import find_algorithm, name_of
from .blueprint import blueprint_of, build, check_format
from .scaling import Scaled
from .weights import put_policy

_ACTIVATIONS = {
    torch.nn.Tanh: "tanh",
    torch.nn.ReLU: "relu",
    torch.nn.ELU: "elu",
    torch.nn.LeakyReLU: "leaky_relu",
    torch.nn.Sigmoid: "sigmoid",
    torch.nn.SiLU: "silu",
}
_NOTHING = (torch.nn.Identity, torch.nn.Flatten, torch.nn.Dropout)  # when it acts


def plain_form(
    model: BaseAlgorithm, notes: Mapping[str, Any], normalization: Normalization | None
) -> Form:
    """What acts of a model, and how it is built, in plain numbers.

    Raises
    ------
    InvalidInput
        If it acts by something else than layers one after the other.
    """
    policy: Any = model.policy
    names = {id(value): name for name, value in _tensors(policy)}
    state = policy.state_dict()
    arrays = {name: np.array(value.detach().cpu().numpy()) for name, value in state.items()}
    try:
        return Form.of(
            _said(policy, names),
            (model.observation_space, model.action_space),
            arrays,
            algorithm=name_of(type(model)),
            normalization=normalization,
            blueprint=blueprint_of(model),
            notes=notes,
        )
    except InvalidInput:
        raise
    except (KeyError, ValueError) as error:
        raise InvalidInput(
            "policy must act by dense layers one after the other to be written in plain numbers, "
            f"got {error} of {type(model).__name__}; keep its .zip, which SB3Policy.save wrote"
        ) from error


def model_of(form: Form, algorithm: type[BaseAlgorithm] | None, source: str) -> BaseAlgorithm:
    """A model that acts as the form's to the bit, and learns on with an optimiser that is new.

    Parameters
    ----------
    algorithm
        That trained it; ``None``: the one that the form says.
    source
        What the form was read from, for errors.
    """
    kind = algorithm or find_algorithm(form.algorithm)
    blueprint = check_format(form.blueprint, source)
    if "needs_trust" in blueprint:
        raise InvalidInput(
            "policy must say in plain values how its model is built to become one again, got "
            f"{source!r}, which is made with {blueprint['needs_trust']!s:.160}; "
            "coopenv.agents.load lets it act as it is"
        )
    model = build(blueprint, kind, sum(array.size for array in form.arrays.values()))
    put_policy(model, {name: torch.tensor(array) for name, array in form.arrays.items()})
    return model


def _tensors(policy: torch.nn.Module) -> Iterator[tuple[str, torch.Tensor]]:
    yield from policy.named_parameters()
    yield from policy.named_buffers()


def _said(policy: Any, names: Mapping[int, str]) -> dict[str, Any]:
    """The network as `coopenv.agents.trained.network.Network.of` takes it."""
    extractor, modules, output, spread = _parts(policy)
    if type(extractor) not in (FlattenExtractor, Scaled):
        raise NotPlain(f"the features extractor {type(extractor).__name__}")
    layers: list[list[Any]] = []
    for module in _flat(modules):
        name = _ACTIVATIONS.get(type(module))
        if type(module) is torch.nn.Linear:
            bias = None if module.bias is None else names[id(module.bias)]
            layers.append([names[id(module.weight)], bias, "identity"])
        elif name and layers and layers[-1][-1] == "identity" and _is_default(module):
            layers[-1][-1] = name
        elif not isinstance(module, _NOTHING):
            raise NotPlain(f"{module!s:.60}")
    scale = names[id(extractor.scale)] if isinstance(extractor, Scaled) else None
    return {"scale": scale, "layers": layers, "output": output, "spread": _named(spread, names)}


def _parts(policy: Any) -> tuple[Any, list[Any], str, Any]:
    """Extractor, what comes after it, the kind of output, and its spread."""
    actor: Any = getattr(policy, "actor", None)
    if isinstance(policy, ActorCriticPolicy) and type(policy.mlp_extractor) is MlpExtractor:
        if hasattr(policy, "lstm_actor"):
            raise NotPlain("a memory (LSTM)")
        modules = [policy.mlp_extractor.policy_net, policy.action_net]
        if isinstance(policy.action_dist, Categorical | Categoricals):
            return policy.pi_features_extractor, modules, "scores", None
        spread = policy.log_std if type(policy.action_dist) is Gaussian else None
        return policy.pi_features_extractor, modules, _cut(policy), spread
    if isinstance(policy, DQNPolicy):
        return policy.q_net.features_extractor, [policy.q_net.q_net], "values", None
    if hasattr(actor, "latent_pi"):  # of SAC and what is made like it
        spread = None if actor.use_sde else actor.log_std
        return actor.features_extractor, [actor.latent_pi, actor.mu], "tanh", spread
    if isinstance(actor, TD3Actor):
        return actor.features_extractor, [actor.mu], "clip", None
    raise NotPlain(f"the policy class {type(policy).__name__}")


def _cut(policy: Any) -> str:
    return "tanh" if policy.squash_output else "clip"


def _flat(modules: list[Any]) -> Iterator[Any]:
    for module in modules:
        if isinstance(module, torch.nn.Sequential):
            yield from _flat([*module])
        else:
            yield module


def _is_default(module: Any) -> bool:
    """Whether an activation has the numbers that torch gives it by itself."""
    return str(module) == str(type(module)())


def _named(spread: Any, names: Mapping[int, str]) -> Any:
    if isinstance(spread, torch.nn.Linear):
        return [names[id(spread.weight)], names[id(spread.bias)]]
    return None if spread is None else names[id(spread)]
