"""Infos as tensors with a row for each agent that learns."""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import torch

from coopenv.errors import UnknownName
from coopenv.info import POSES, Info
from coopenv.transport import Transport


class Told:
    """Which infos are handed out, and how they become tensors.

    Parameters
    ----------
    transport
        Whose infos they are.
    wanted
        Their names; ``True``: all there are, ``False``: none.

    Attributes
    ----------
    names
        Of the infos that are handed out.
    example
        Those of a reset, as tensors.

    Raises
    ------
    UnknownName
        If no info has such a name.
    """

    def __init__(self, transport: Transport, wanted: bool | Iterable[str]):
        learners = list(transport.learners)
        self._count = len(learners)
        self._picked = learners if self._count < transport.num_agents else None
        self.names: tuple[str, ...] = ()
        self.example: dict[str, torch.Tensor] = {}
        if wanted is not False:
            like = Transport(num_worlds=transport.num_worlds, config=transport.config)
            _, info = like.reset(seed=0)
            self.names = tuple(info) if wanted is True else _known(wanted, info)
            self.example = self(info)

    def __call__(self, info: Info) -> dict[str, torch.Tensor]:
        """Tensors ``(world, learner, …)`` of their own memory: float32, or bool of flags.

        A number that is of a whole world is told to each of its agents.
        """
        return {name: self._rows(name, info[name]) for name in self.names}

    def _rows(self, name: str, value: npt.NDArray) -> torch.Tensor:
        if value.ndim == 1 or name in POSES:
            numbers = value.reshape(len(value), 1, -1).repeat(self._count, axis=1)
        elif self._picked is not None and value.shape[1] > self._count:
            numbers = value[:, self._picked]
        else:
            numbers = value
        numbers = numbers if numbers.ndim > 2 else numbers[..., None]
        kind = np.bool_ if value.dtype == np.bool_ else np.float32
        return torch.from_numpy(np.array(numbers, dtype=kind, order="C"))


def _known(wanted: Iterable[str], info: Info) -> tuple[str, ...]:
    names = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    for name in names:
        if name not in info:
            raise UnknownName("info", name, info)
    return names
