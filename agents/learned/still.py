"""An environment without anything behind its spaces, from which an algorithm is constructed."""

from typing import Any

from stable_baselines3.common.vec_env import VecEnv


class Still(VecEnv):
    """Rows of two spaces with nothing behind them: it is neither reset nor stepped."""

    def __init__(self, rows: int, observation_space: Any, action_space: Any):
        super().__init__(rows, observation_space, action_space)

    def reset(self) -> Any:
        """There is nothing to reset."""
        raise NotImplementedError

    def step_async(self, actions: Any) -> None:
        """There is nothing to step."""
        raise NotImplementedError

    def step_wait(self) -> Any:
        """There is nothing to step."""
        raise NotImplementedError

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """None for every row."""
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Nothing is kept."""

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """No row has a method."""
        return []

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No row is wrapped."""
        return [False] * self.num_envs

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Nothing is drawn."""
        return [seed] * self.num_envs
