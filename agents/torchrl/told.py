"""Infos as tensors with a row for each agent that learns."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from coopenv.errors import UnknownName
from coopenv.info import TRIPLES, Info
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
        self.names: tuple[str, ...] = ()
        self.example: dict[str, torch.Tensor] = {}
        self._forms: dict[str, _Form] = {}
        if wanted is not False:
            like = Transport(num_worlds=transport.num_worlds, config=transport.config)
            _, info = like.reset(seed=0)
            self.names = tuple(info) if wanted is True else _known(wanted, info)
            learners = list(transport.learners)
            self._forms = {name: _form(name, info[name], learners) for name in self.names}
            self.example = self(info)

    def __call__(self, info: Info) -> dict[str, torch.Tensor]:
        """Tensors ``(world, learner, …)`` of their own memory: float32, or bool of flags.

        A number that is of a whole world is told to each of its agents.
        """
        return {name: _rows(info[name], form) for name, form in self._forms.items()}


class _Form(NamedTuple):
    """How an info becomes a tensor: found once, as it is the same in every step."""

    kind: type[np.generic]  # of the tensor's numbers
    shape: tuple[int, ...]  # with an axis for agents, and one for numbers
    repeats: int  # along the axis for agents
    picked: list[int] | None  # the agents whose rows are told; ``None``: all it has


def _form(name: str, value: npt.NDArray, learners: list[int]) -> _Form:
    count, kind = len(learners), np.bool_ if value.dtype == np.bool_ else np.float32
    if value.ndim == 1 or name in TRIPLES:
        return _Form(kind, (len(value), 1, value[0].size), count, None)
    picked = learners if value.shape[1] > count else None
    return _Form(kind, (len(value), count, *(value.shape[2:] or (1,))), 1, picked)


def _rows(value: npt.NDArray, form: _Form) -> torch.Tensor:
    if form.picked is not None:
        value = value[:, form.picked]
    numbers = value.astype(form.kind, order="C").reshape(form.shape)
    if form.repeats > 1:
        numbers = numbers.repeat(form.repeats, axis=1)
    return torch.from_numpy(numbers)


def _known(wanted: Iterable[str], info: Info) -> tuple[str, ...]:
    names = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    for name in names:
        if name not in info:
            raise UnknownName("info", name, info)
    return names
