"""Worlds that TorchRL leaves out of a step: their episode is over and they wait for a reset."""

import numpy as np

from coopenv.arrays import BoolArray, IntArray
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.transport import Transport


class Resting:
    """Keeps worlds going that wait for a reset, since the core steps all worlds or none.

    ``rollout(break_when_all_done=True)`` marks the worlds to be stepped with ``"_step"``. The
    others begin an episode of which nobody hears, with actions of zero, until they are reset.

    Parameters
    ----------
    transport
        Whose worlds they are.
    """

    def __init__(self, transport: Transport):
        self._transport = transport
        self._resting = np.zeros(transport.num_worlds, dtype=np.bool_)
        self._any = False

    def wake(self, mask: BoolArray | None) -> None:
        """Worlds that ``mask`` marks, or all, were reset."""
        self._resting = self._resting & (False if mask is None else ~mask)
        self._any = bool(self._resting.any())

    def check(self, stepped: BoolArray | None) -> None:
        """Raise unless worlds that are to be stepped run, and those that are not have ended.

        Raises
        ------
        ResetNeeded
            If a world is to be stepped that rests.
        InvalidInput
            If one is not to be stepped whose episode is under way.
        """
        tired = self._resting if stepped is None else self._resting & stepped
        if self._any and tired.any():
            raise ResetNeeded(
                "worlds whose episode has ended must be reset before the next step, got a step of "
                f"world {np.flatnonzero(tired)[0]}; call reset with '_reset' marking it"
            )
        if stepped is not None:
            running = ~stepped & ~self._resting & ~self.ended()
            if running.any():
                raise InvalidInput(
                    "_step must mark every world whose episode is under way, got False for world "
                    f"{np.flatnonzero(running)[0]}; step all that run, or use fewer worlds"
                )

    def rest(self, stepped: BoolArray) -> None:
        """Worlds that are not ``stepped`` rest until they wake."""
        self._resting = self._resting | ~stepped
        self._any = bool(self._resting.any())

    def get_state(self, worlds: IntArray) -> BoolArray:
        """Which of ``worlds`` rest."""
        return self._resting[worlds]

    def set_state(self, state: BoolArray | None, worlds: IntArray) -> None:
        """Let ``worlds`` rest as `get_state` told; none of them for ``None``."""
        self._resting = self._resting.copy()
        self._resting[worlds] = False if state is None else state
        self._any = bool(self._resting.any())

    def ended(self) -> BoolArray:
        """Worlds of the core that have no episode under way."""
        last = self._transport.transition
        if last is None:
            return np.zeros(self._transport.num_worlds, dtype=np.bool_)  # the core refuses them
        return last.terminated | last.truncated
