"""Statistics of running and finished episodes, for training logs and evaluation alike."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from typing_extensions import Self

from coopenv.arrays import BoolArray, FloatArray, IntArray, with_rows
from coopenv.info import COST, Info


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Episodes:
    """What finished episodes showed; every array has one entry an episode.

    Levels are means over the episode's steps. Load shares are means over the steps in which they
    are defined, and NaN where that is none.
    """

    reward: FloatArray  # (episode, agent): undiscounted sum of the agent's rewards
    length: IntArray  # (episode,) control steps
    success: BoolArray  # (episode,)
    relative_cost: FloatArray  # (episode,): γ
    wasted_cost: FloatArray  # (episode,): J(h) − J(h_M) [N]
    internal_force_level: FloatArray  # (episode,): F_I [N]
    internal_torque_level: FloatArray  # (episode,): T_I [N·m]
    force_load_share: FloatArray  # (episode, agent)
    torque_load_share: FloatArray  # (episode, agent)
    load_imbalance: FloatArray  # (episode,): of force; 0: all carry alike, 1: one carries all
    contact_impulse: FloatArray  # (episode,): sum [N·s]
    reward_terms: dict[str, FloatArray] = field(default_factory=dict)  # (episode, agent): sums
    costs: dict[str, FloatArray] = field(default_factory=dict)  # likewise, named as infos name them

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Several lots of episodes as one."""
        joined: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in _arrays(cls)
        }
        for group in _GROUPS:
            joined[group] = {
                name: np.concatenate([getattr(part, group)[name] for part in parts])
                for name in getattr(parts[0], group)
            }
        return cls(**joined)

    def pick(self, episodes: IntArray) -> Self:
        """Only the given episodes, in the given order."""
        picked: dict[str, Any] = {
            name: getattr(self, name)[episodes] for name in _arrays(type(self))
        }
        for group in _GROUPS:
            picked[group] = {name: term[episodes] for name, term in getattr(self, group).items()}
        return replace(self, **picked)


def _arrays(kind: type[Episodes]) -> list[str]:
    return [entry.name for entry in fields(kind) if entry.name not in _GROUPS]


_GROUPS = ("reward_terms", "costs")  # dictionaries of arrays
_MEANS = ("relative_cost", "wasted_cost", "internal_force_level", "internal_torque_level")


class EpisodeSums:
    """Adds up every step of every world; `take` hands out and forgets the finished ones."""

    def __init__(self, num_worlds: int, num_agents: int):
        self._num_worlds, self._num_agents = num_worlds, num_agents
        self._length = np.zeros(num_worlds, dtype=np.int64)
        self._success = np.zeros(num_worlds, dtype=np.bool_)
        self._sums: dict[str, FloatArray] = {}
        self._terms: dict[str, FloatArray] = {}
        self._costs: dict[str, FloatArray] = {}

    def add(self, reward: FloatArray, info: Info) -> None:
        """Add a step, given what `coopenv.Transport.step` returned."""
        force, torque = info["force_load_share"], info["torque_load_share"]
        force_defined = info["force_load_share_defined"][:, None]
        torque_defined = info["torque_load_share_defined"][:, None]
        self._length += 1
        self._success = info["success"].copy()
        steps = {
            "reward": reward,
            "force_defined": force_defined,
            "torque_defined": torque_defined,
            "force_load_share": force * force_defined,
            "torque_load_share": torque * torque_defined,
            "load_imbalance": self._imbalance(force) * force_defined[:, 0],
            **{name: info[name] for name in _MEANS},
            "contact_impulse": info["contact_impulse"],
        }
        _accumulate(self._sums, steps)
        _accumulate(self._terms, info["reward_terms"])
        if COST in info:
            parts = {f"{COST}/{name}": part for name, part in info["cost_terms"].items()}
            _accumulate(self._costs, {COST: info[COST], **parts})

    def take(self, worlds: IntArray) -> Episodes:
        """Episodes that ended in ``worlds``; their sums start from zero again."""
        length = self._length[worlds].copy()
        sums = {name: _taken(total, worlds) for name, total in self._sums.items()}
        terms = {name: _taken(total, worlds) for name, total in self._terms.items()}
        costs = {name: _taken(total, worlds) for name, total in self._costs.items()}
        self._length[worlds] = 0
        defined = sums["force_defined"]
        return Episodes(
            reward=sums["reward"],
            length=length,
            success=self._success[worlds].copy(),
            force_load_share=_mean(sums["force_load_share"], defined),
            torque_load_share=_mean(sums["torque_load_share"], sums["torque_defined"]),
            load_imbalance=_mean(sums["load_imbalance"], defined[:, 0]),
            contact_impulse=sums["contact_impulse"],
            reward_terms=terms,
            costs=costs,
            **{name: sums[name] / length for name in _MEANS},
        )

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """The sums of ``worlds``, one row each."""
        return {
            "length": self._length[worlds],
            "success": self._success[worlds],
            "sums": {name: total[worlds] for name, total in self._sums.items()},
            "terms": {name: total[worlds] for name, total in self._terms.items()},
            "costs": {name: total[worlds] for name, total in self._costs.items()},
        }

    def set_state(self, state: dict[str, Any] | None, worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned; from zero for ``None``."""
        state = state or {"length": 0, "success": False, "sums": {}, "terms": {}, "costs": {}}
        self._length[worlds] = state["length"]
        self._success = with_rows(self._success, worlds, state["success"])
        for mine, group in ((self._sums, "sums"), (self._terms, "terms"), (self._costs, "costs")):
            given = state[group]
            for name, rows in given.items():
                mine.setdefault(name, np.zeros((self._num_worlds, *rows.shape[1:])))
            for name, total in mine.items():
                total[worlds] = given.get(name, 0.0)

    def _imbalance(self, share: FloatArray) -> FloatArray:
        """How far the largest share is above 1/n, ``(world,)`` in [0, 1]."""
        even = 1 / self._num_agents
        return (share.max(axis=1) - even) / (1 - even) if self._num_agents > 1 else 0 * share[:, 0]


def _accumulate(sums: dict[str, FloatArray], step: dict[str, FloatArray]) -> None:
    for name, value in step.items():
        if name not in sums:
            sums[name] = np.zeros(value.shape)
        sums[name] += value


def _taken(total: FloatArray, worlds: IntArray) -> FloatArray:
    taken = total[worlds].copy()
    total[worlds] = 0.0
    return taken


def _mean(total: FloatArray, count: FloatArray) -> FloatArray:
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
