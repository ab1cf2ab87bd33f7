"""All worlds of a `coopenv.Transport` as one TorchRL ``EnvBase``."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.config import TransportConfig
from coopenv.envs.common import Pictures, start_options
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.info import Info
from coopenv.resets import seed_worlds
from coopenv.rewards.sums import check_learnable
from coopenv.snapshot import Snapshot, chosen_worlds
from coopenv.transport import Transport

from ..environment import find_config
from ..features import scale_of_features

try:
    import torch
    from tensordict import TensorDict, TensorDictBase
    from torchrl.envs import EnvBase
except ImportError as error:
    raise MissingExtra("coopenv.agents.torchrl", "torchrl") from error

from .resting import Resting
from .specs import GROUP, action_spec, done_spec, observation_spec, reward_spec
from .told import Told

ACTION = GROUP, "action"
REWARD = GROUP, "reward"
_RESTING = "resting"  # part of a snapshot
_new = getattr(TensorDict, "_new_unsafe", TensorDict)  # without checks of shapes, where it is there


def make_env(
    env: str | TransportConfig = "coopenv/BeamTransport-v0",
    num_worlds: int = 256,
    *,
    device: "torch.device | str" = "cpu",
    seed: int | None = None,
    info: bool | Iterable[str] = False,
    return_state: bool = False,
    **keywords: Any,
) -> "TransportTorchEnv":
    """A TorchRL environment in which all worlds are stepped together.

    Parameters
    ----------
    env
        A Gymnasium id of this package, or a whole configuration.
    num_worlds
        Worlds stepped together: the batch size is ``(num_worlds,)``.
    device
        Where tensors are handed out. The worlds themselves are always stepped by the processor.
    seed
        World k begins with ``seed + k``, as by ``set_seed``.
    info
        Names of infos to hand out, or ``True`` for all of them.
    return_state
        Whether ``"state"``, what all agents of a world see, is handed out for central critics.
    **keywords
        Fields of `coopenv.TransportConfig`, over those of the id; not beside a configuration.

    Examples
    --------
    >>> env = make_env("coopenv/BeamTransport-v0", num_worlds=64, seed=0)
    >>> steps = env.rollout(10)
    >>> steps["agents", "observation"].shape
    torch.Size([64, 10, 2, 22])
    """
    config = find_config(env, keywords)
    made = TransportTorchEnv(
        config, num_worlds, device=device, info=info, return_state=return_state
    )
    if seed is not None:
        made.set_seed(seed)
    return made


def feature_scale(env: "TransportTorchEnv") -> list[float]:
    """One factor a feature of an agent, which brings it to order one."""
    return scale_of_features(env.transport)


class TransportTorchEnv(EnvBase):
    """All worlds of a `coopenv.Transport` as one batch, the agents that learn as a group.

    =================================  ====================================  =================
    key                                shape                                 of a step, a reset
    =================================  ====================================  =================
    ``("agents", "action")``           ``(world, learner, action_size)``     taken
    ``("agents", "observation")``      ``(world, learner, feature)``         both
    ``("agents", "reward")``           ``(world, learner, 1)``               step
    ``("agents", "info", name)``       ``(world, learner, …)``, if wanted    both
    ``"state"``                        ``(world, learner · feature)``, same  both
    ``"done"``, ``"terminated"``,      ``(world, 1)`` bool                   both
    ``"truncated"``
    =================================  ====================================  =================

    Observations share the core's memory, and the state the observations'.

    Parameters
    ----------
    config
        What the worlds are.
    num_worlds, device, info, return_state
        As of `make_env`.

    Attributes
    ----------
    transport
        The core.
    group_map
        Names of the agents that learn, by group: all in ``"agents"``.
    """

    __module__ = "coopenv.agents.torchrl"  # where users import it from, and where pickles look

    def __init__(
        self,
        config: TransportConfig,
        num_worlds: int = 256,
        *,
        device: "torch.device | str" = "cpu",
        info: bool | Iterable[str] = False,
        return_state: bool = False,
    ):
        core = Transport(num_worlds=num_worlds, config=config)
        super().__init__(device=device, batch_size=(core.num_worlds,))
        self.transport, self.return_state = core, return_state
        self.group_map = {GROUP: [f"agent_{i}" for i in core.learners]}
        self._told = Told(core, info)
        self._pictures = Pictures(core, "rgb_array")
        self._resting = Resting(core)
        self.observation_spec = observation_spec(core, self._told.example, return_state)
        self.action_spec = action_spec(core)
        self.reward_spec = reward_spec(core)
        self.done_spec = done_spec(core)

    def render(self, world: int = 0) -> npt.NDArray[np.uint8] | None:
        """The picture of a world ``(height, width, 3)``; ``None`` before the first reset."""
        return self._pictures.draw(world)

    def close(self, **keywords: Any) -> None:
        """Close what draws."""
        self._pictures.close()
        super().close(**keywords)

    def step(self, tensordict: TensorDictBase) -> Any:  # as vague as type checkers find TorchRL's
        """Advance every world; ``tensordict`` itself, with what came of it under ``"next"``.

        As ``EnvBase.step``, without its look whether shapes and ends are those of the specs, which
        they are here.
        """
        special = "_step" in tensordict or "next" in tensordict or self.run_type_checks
        if special or tensordict.batch_size != self.batch_size:
            return super().step(tensordict)
        return tensordict.set("next", self._step(tensordict))

    def get_state(self, worlds: Sequence[int] | IntArray | None = None) -> Snapshot:
        """As `coopenv.Transport.get_state`, with which worlds wait for a reset."""
        state = self.transport.get_state(worlds)
        chosen = chosen_worlds(worlds, self.transport.num_worlds)
        return state.with_part(_RESTING, self._resting.get_state(chosen))

    def set_state(  # pyright: ignore[reportIncompatibleMethodOverride]  # nothing but a name there
        self, state: Snapshot, worlds: Sequence[int] | IntArray | None = None
    ) -> TensorDict:
        """Go on from a state, as `coopenv.Transport.set_state`; returns what a reset does.

        Worlds whose episode had ended are ``"done"`` in it. So are those that waited for a reset:
        they are told as truncated, and what is seen of them is the core's, not their last step.
        """
        obs, info = self.transport.set_state(state, worlds)
        chosen = chosen_worlds(worlds, self.transport.num_worlds)
        self._resting.set_state(state.part_for(_RESTING, len(chosen)), chosen)
        last = self.transport.transition
        assert last is not None
        waiting = self._resting.get_state(np.arange(self.transport.num_worlds))
        return self._tensors(obs, info, last.terminated & ~waiting, (last.truncated | waiting))

    def _set_seed(self, seed: int | None) -> None:
        """Seed world k with ``seed + k``; its next episode begins as that of the other views."""
        seed_worlds(self.transport.generators, seed, np.arange(self.transport.num_worlds))

    def _reset(self, tensordict: TensorDictBase | None = None, **options: Any) -> TensorDict:
        """Begin episodes where ``"_reset"`` marks it; options are ``pose`` and ``goal``."""
        core, mask = self.transport, _marks(tensordict, "_reset")
        obs, info = core.reset(mask=mask, **start_options(options))
        self._resting.wake(mask)
        start = core.transition
        assert start is not None
        return self._tensors(obs, info, start.terminated, start.truncated)

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Advance every world, or those that ``"_step"`` marks; the others' episodes are over."""
        core, resting = self.transport, self._resting
        action, stepped = self._joint(tensordict), _marks(tensordict, "_step")
        resting.check(stepped)
        restart = None
        if stepped is not None:
            action, restart = action.copy(), ~stepped & resting.ended()
            action[~stepped] = 0
        obs, reward, terminated, truncated, info = core.advance(action, restart=restart)
        check_learnable(reward, info)
        told = self._tensors(obs, info, terminated, truncated, reward)
        if stepped is None:
            return told
        resting.rest(stepped)
        where = torch.from_numpy(stepped).to(told.device)
        names = [name for name in told.keys(True, True) if name != REWARD]
        kept = tensordict.select(*names, strict=False)
        return told.where(where, kept, pad=0)  # what is not kept, the reward, is 0

    def _joint(self, tensordict: TensorDictBase) -> npt.NDArray:
        action = tensordict.get(ACTION, None)
        if action is None:
            raise InvalidInput(
                f"tensordict must hold {ACTION}, got {list(tensordict.keys(True, True))}; let a "
                "policy write it there, or env.rand_action"
            )
        return action.numpy(force=True)

    def _tensors(
        self,
        obs: npt.NDArray[np.float32],
        info: Info,
        terminated: BoolArray,
        truncated: BoolArray,
        reward: FloatArray | None = None,
    ) -> TensorDict:
        """What a reset hands out, or a step, which also has a reward."""
        device, shape = self.device, torch.Size(obs.shape[:2])  # of TorchRL's own kind: quicker
        group: dict[str, Any] = {"observation": torch.from_numpy(obs)}
        if reward is not None:
            group["reward"] = torch.from_numpy(reward[..., None].astype(np.float32))
        if self._told.names:
            group["info"] = _unchecked(self._told(info), shape, device)
        entries: dict[str, Any] = {
            GROUP: _unchecked(group, shape, device),
            "done": torch.from_numpy((terminated | truncated)[:, None]),
            "terminated": torch.from_numpy(terminated[:, None].copy()),
            "truncated": torch.from_numpy(truncated[:, None].copy()),
        }
        if self.return_state:
            entries["state"] = torch.from_numpy(obs.reshape(len(obs), -1))
        return _unchecked(entries, self.batch_size, device)


def _unchecked(
    entries: dict[str, Any], shape: torch.Size, device: torch.device | None
) -> TensorDict:
    """A TensorDict of entries that have its shape; on another device than theirs, a copy."""
    if device is None or device.type == "cpu":
        return _new(entries, batch_size=shape, device=device)
    return TensorDict(entries, shape, device=device)


def _marks(tensordict: TensorDictBase | None, name: str) -> BoolArray | None:
    """The worlds that an entry marks; ``None`` where there is no such entry."""
    marks = None if tensordict is None else tensordict.get(name, None)
    return None if marks is None else marks.numpy(force=True).reshape(-1)
