"""TorchRL specs of a transport: what its observations, actions, rewards and infos look like."""

from collections.abc import Mapping

import torch
from gymnasium import spaces
from torchrl.data import Bounded, Categorical, Composite, TensorSpec, Unbounded

from coopenv.envs.common import (
    agent_action_space,
    agent_observation_space,
    team_observation_space,
)
from coopenv.errors import InvalidInput
from coopenv.transport import Transport

GROUP = "agents"  # under which TorchRL finds what there is one of for each agent, as in VMAS


def observation_spec(
    transport: Transport, infos: Mapping[str, torch.Tensor], return_state: bool
) -> Composite:
    """What every agent sees, infos such as ``infos``, and the state if it is wanted."""
    worlds = transport.num_worlds
    shape = worlds, len(transport.learners)
    group: dict[str, TensorSpec] = {
        "observation": spec_of(agent_observation_space(transport), shape)
    }
    if infos:
        told = {name: Unbounded(shape=it.shape, dtype=it.dtype) for name, it in infos.items()}
        group["info"] = Composite(told, shape=shape)
    entries: dict[str, TensorSpec] = {GROUP: Composite(group, shape=shape)}
    if return_state:
        entries["state"] = spec_of(team_observation_space(transport), (worlds,))
    return Composite(entries, shape=(worlds,))


def action_spec(transport: Transport) -> Composite:
    """What every agent does."""
    shape = transport.num_worlds, len(transport.learners)
    return _by_agent("action", spec_of(agent_action_space(transport), shape))


def reward_spec(transport: Transport) -> Composite:
    """One reward an agent."""
    shape = transport.num_worlds, len(transport.learners), 1
    return _by_agent("reward", Unbounded(shape=torch.Size(shape)))


def done_spec(transport: Transport) -> Composite:
    """One end a world: its agents end together."""
    worlds = transport.num_worlds
    ends = {
        name: Categorical(2, shape=torch.Size((worlds, 1)), dtype=torch.bool)
        for name in ("done", "terminated", "truncated")
    }
    return Composite(ends, shape=(worlds,))


def spec_of(space: spaces.Space, batch: tuple[int, ...]) -> TensorSpec:
    """The spec of a space with ``batch`` axes in front; without bounds unless all are finite.

    Raises
    ------
    InvalidInput
        If it is neither a ``Box`` nor ``Discrete``.
    """
    if isinstance(space, spaces.Discrete):
        return Categorical(int(space.n), shape=torch.Size(batch))
    if not isinstance(space, spaces.Box):
        raise InvalidInput(f"space must be a Box or Discrete, got {space}; choose another action")
    shape = torch.Size((*batch, *space.shape))
    low, high = (torch.from_numpy(bound).expand(shape) for bound in (space.low, space.high))
    if space.is_bounded():
        return Bounded(low, high, shape=shape, dtype=low.dtype)
    return Unbounded(shape=shape, dtype=low.dtype)


def _by_agent(name: str, spec: TensorSpec) -> Composite:
    group = Composite({name: spec}, shape=spec.shape[:2])
    return Composite({GROUP: group}, shape=spec.shape[:1])
