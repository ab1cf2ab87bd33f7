"""Worlds of teams of several sizes as one Stable-Baselines3 ``VecEnv``: a row is an agent."""

from collections.abc import Sequence
from itertools import accumulate, chain
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.transport import Transport

from ..environment.teams import read_teams, team_configs, worlds_of
from ..provenance import Provenance
from ..vec_env import TransportVecEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error


class TeamsVecEnv(VecEnv):
    """A `TransportVecEnv` under shared control for each size of team, one below the other.

    Rows are those of the first size, then those of the second and so on; a row means what it means
    there, and so do infos. Attributes and methods are those of the part that a row is of.

    Parameters
    ----------
    config
        The environment; each team has its body as `coopenv.agents.environment.with_team` has it.
    num_worlds
        Worlds of all sizes together, shared out evenly.
    teams
        Different numbers of agents, at least one.

    Attributes
    ----------
    parts
        The `TransportVecEnv` of each size.
    teams
        Their sizes.

    Raises
    ------
    InvalidInput
        If a block's size grows with the team, or the body is none for any team.
    """

    __module__ = "coopenv.agents.sb3"  # where users import it from, and where pickles look for it

    control = "shared"

    def __init__(self, config: TransportConfig, num_worlds: int, teams: Sequence[int]):
        self.teams = read_teams(teams, control=self.control, num_worlds=num_worlds)
        if not self.teams:
            raise InvalidInput(
                "teams must name at least one size, got none; without teams it is a TransportVecEnv"
            )
        configs = team_configs(config, self.teams)
        shares = worlds_of(num_worlds, self.teams)
        self.parts = [
            TransportVecEnv(each, worlds, control=self.control)
            for each, worlds in zip(configs, shares, strict=True)
        ]
        rows = [part.num_envs for part in self.parts]
        self._cuts = [*accumulate(rows)][:-1]
        self._part_of = [(part, row) for part in self.parts for row in range(part.num_envs)]
        super().__init__(sum(rows), _around(self.parts), self.parts[0].action_space)
        self.metadata = {"render_modes": []}

    @property
    def transport(self) -> Transport:
        """The core of the first size."""
        return self.parts[0].transport

    def reset(self) -> npt.NDArray[np.float32]:
        """Start every world anew; seeds that were set are used once."""
        return np.concatenate([part.reset() for part in self.parts])

    def step_async(self, actions: npt.NDArray) -> None:
        """Keep the actions for `step_wait`."""
        shape = (self.num_envs, *(self.action_space.shape or ()))
        if np.shape(actions) != shape:
            raise InvalidInput(
                f"actions must have the shape {shape}, got {np.shape(actions)}; give one row an "
                "agent, those of the first size of team first"
            )
        for part, mine in zip(self.parts, np.split(actions, self._cuts), strict=True):
            part.step_async(mine)

    def step_wait(
        self,
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], BoolArray, list[dict]]:
        """Step every world, and reset those whose episode ended."""
        obs, reward, done, infos = zip(*(part.step_wait() for part in self.parts), strict=True)
        joined = (np.concatenate(each) for each in (obs, reward, done))
        return *joined, [*chain.from_iterable(infos)]  # pyright: ignore[reportReturnType]

    def to_notes(self) -> dict[str, Any]:
        """What the file of a policy that learns in it is to say (`coopenv.agents.provenance`).

        Raises
        ------
        InvalidInput
            If something in the environment cannot be written; the message says what to do.
        """
        config = self.transport.config
        return Provenance.of_environment(config, self.control, self.teams).to_notes()

    def close(self) -> None:
        """Close the parts."""
        for part in self.parts:
            part.close()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the worlds one after the other from ``seed`` on, all rows of a world alike."""
        if seed is None:
            seed = int(np.random.default_rng().integers(2**31))
        first = whole(seed, "seed", at_least=0)
        seeds: list[int | None] = []
        for part in self.parts:
            seeds += part.seed(first)
            first += part.transport.num_worlds
        return seeds

    def set_options(self, options: list[dict] | dict | None = None) -> None:
        """No start poses and goals are taken: batches of worlds are of several sizes."""
        if options:
            raise InvalidInput(
                "options must be set for each size of team, got some for all; use "
                "parts[k].set_options before reset"
            )

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the part of each index, or of its core."""
        return [part.get_attr(attr_name, row)[0] for part, row in self._chosen(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of every part that has one of the indices, or of its core."""
        for part in dict.fromkeys(part for part, _ in self._chosen(indices)):
            part.set_attr(attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of every core that has one of the indices once; one answer an index."""
        chosen = self._chosen(indices)
        answers = {
            part: part.env_method(method_name, *method_args, indices=0, **method_kwargs)[0]
            for part in dict.fromkeys(part for part, _ in chosen)
        }
        return [answers[part] for part, _ in chosen]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """True for ``Monitor``: episode statistics are reported as that wrapper would."""
        return [part.env_is_wrapped(wrapper_class, row)[0] for part, row in self._chosen(indices)]

    def get_images(self) -> Sequence[npt.NDArray | None]:
        """None; the parts have pictures."""
        return [None] * self.num_envs

    def _chosen(self, indices: Any) -> list[tuple[TransportVecEnv, int]]:
        return [self._part_of[index] for index in self._get_indices(indices)]


def _around(parts: Sequence[TransportVecEnv]) -> gymnasium.spaces.Box:
    """The observation space that holds those of all parts."""
    spaces: list[Any] = [part.observation_space for part in parts]
    low, high = (np.stack([getattr(space, end) for space in spaces]) for end in ("low", "high"))
    return gymnasium.spaces.Box(low.min(axis=0), high.max(axis=0), dtype=np.float32)
