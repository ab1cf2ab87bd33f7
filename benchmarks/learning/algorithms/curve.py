"""When a policy that explores succeeds how often, in seconds of the processor."""

import time
from collections import deque
from collections.abc import Sequence
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback

from coopenv.agents.curves import Row

EVERY = 25  # control steps of each world between two points


class Curve:
    """Success rates of the episodes that ended lately, that is in as long as one may last.

    Seconds are those of the processor since it was made.

    Parameters
    ----------
    horizon
        Control steps of the longest episode.
    num_worlds
        Stepped together.
    """

    def __init__(self, horizon: int, num_worlds: int):
        self.points: list[tuple[float, Row]] = []  # [s], and a row with `steps` and `success`
        self.num_worlds = num_worlds
        self._lately: deque[Sequence[bool]] = deque(maxlen=horizon)
        self._done, self._began = 0, time.process_time()

    @property
    def steps(self) -> int:
        """Control steps of all worlds together."""
        return self._done * self.num_worlds

    @property
    def seconds(self) -> float:
        """Of the processor so far."""
        return time.process_time() - self._began

    def take(self, row: Row) -> None:
        """Note a row of a training that draws its own curve, with `steps` and `success`."""
        self._done = int(row["steps"]) // self.num_worlds
        self.points.append((self.seconds, row))

    def add(self, ended: Sequence[bool]) -> None:
        """A control step of every world: which of the episodes that ended in it succeeded."""
        self._lately.append(ended)
        self._done += 1
        if self._done % EVERY:
            return
        successes = [success for step in self._lately for success in step]
        if successes:
            rate = sum(successes) / len(successes)
            self.points.append((self.seconds, {"steps": self.steps, "success": rate}))


class Drawn(BaseCallback):
    """Draws the curve of a training of Stable-Baselines3, where a row of its worlds is a world.

    Parameters
    ----------
    curve
        Of the training.
    """

    def __init__(self, curve: Curve):
        super().__init__()
        self._curve = curve

    def _on_step(self) -> bool:
        infos: list[dict[str, Any]] = self.locals["infos"]
        self._curve.add([info["is_success"] for info in infos if "is_success" in info])
        return True
