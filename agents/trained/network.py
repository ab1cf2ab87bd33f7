"""Network of a policy in NumPy: from what it sees to its mean action, a sample, or a choice."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

Rows = npt.NDArray[np.float32]  # (row, unit)

OUTPUTS = (
    *("clip", "tanh"),  # an action, cut off at ±1 or squashed
    *(
        "scores",
        "values",
    ),  # of pushes: the largest is chosen; scores are logits of a choice as well
)
# Multiplications that OpenBLAS leaves to one thread (GEMM_MULTITHREAD_THRESHOLD of its build). For
# more it wakes one a core; they wait for each other in a loop, which costs many times the product
# where layers are as small as those of policies, most of all on a busy machine.
SMALL = 2**18
FEW = 8  # rows, of which a product at a time costs more than threads do
_LOG_STD = -20.0, 2.0  # of a spread that a layer gives, as Stable-Baselines3 bounds it


def _sigmoid(x: Rows) -> Rows:
    with np.errstate(over="ignore"):  # of exp, where the answer is 0
        return np.float32(1) / (np.float32(1) + np.exp(-x))


def _elu(x: Rows) -> Rows:
    return np.where(x > 0, x, np.expm1(np.minimum(x, 0)))


ACTIVATIONS: Mapping[str, Callable[[Rows], Rows]] = {  # as torch defines them by default
    "identity": lambda x: x,
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0),
    "elu": _elu,
    "leaky_relu": lambda x: np.where(x > 0, x, np.float32(0.01) * x),
    "sigmoid": _sigmoid,
    "silu": lambda x: x * _sigmoid(x),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """activation(x Wᵀ + b)."""

    weight: Rows  # (unit, input)
    bias: npt.NDArray[np.float32]  # (unit,)
    activation: str = "identity"  # of `ACTIVATIONS`

    def __call__(self, x: Rows) -> Rows:
        """Units of each row."""
        units = np.empty((len(x), len(self.weight)), dtype=np.float32)
        rows = SMALL // self.weight.size
        if rows < FEW:  # threads pay for a layer that is so large
            rows = max(1, len(x))
        for first in range(0, len(x), rows):
            part = slice(first, first + rows)
            np.matmul(x[part], self.weight.T, out=units[part])
        units += self.bias
        return ACTIVATIONS[self.activation](units)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Network:
    """Scaled features through layers to a row's actions, in single precision."""

    scale: npt.NDArray[np.float32] | None  # (feature,), by which features are multiplied
    layers: tuple[Layer, ...]
    output: str  # of `OUTPUTS`
    spread: npt.NDArray[np.float32] | Layer | None  # log σ, or its layer beside the last one

    @classmethod
    def of(cls, said: Mapping[str, Any], arrays: Mapping[str, npt.NDArray]) -> Self:
        """The network that ``said`` describes, in plain values with names of ``arrays``.

        Parameters
        ----------
        said
            ``scale``: a name or None; ``layers``: weight, bias or None, and activation of each;
            ``output``; ``spread``: a name, or weight and bias, or None.

        Raises
        ------
        Exception
            Of any kind, if it is described otherwise or arrays do not fit into one another.
        """
        if set(said) != {"scale", "layers", "output", "spread"} or said["output"] not in OUTPUTS:
            raise ValueError(f"its network is described by {sorted(said)!r:.80}")
        layers = tuple(_layer(arrays, *each) for each in said["layers"])
        for before, after in pairwise(layers):
            if before.weight.shape[0] != after.weight.shape[1]:
                raise ValueError("its layers do not fit into one another")
        scale = None if said["scale"] is None else _numbers(arrays, said["scale"], 1)
        if scale is not None and scale.shape != layers[0].weight.shape[1:]:
            raise ValueError("its scale is of other features")
        spread = said["spread"]
        if isinstance(spread, list):
            spread = _layer(arrays, *spread)
        elif spread is not None:
            spread = _numbers(arrays, spread, 1)
        made = cls(scale=scale, layers=layers, output=said["output"], spread=spread)
        wide = made.spread.weight if isinstance(made.spread, Layer) else made.spread
        if wide is not None and wide.shape != (
            layers[-1].weight.shape if isinstance(made.spread, Layer) else layers[-1].bias.shape
        ):
            raise ValueError("its spread is of other actions")
        return made

    @property
    def features(self) -> int:
        """Of a row."""
        return self.layers[0].weight.shape[1]

    @property
    def chooses(self) -> bool:
        """Whether it chooses from pushes."""
        return self.output in ("scores", "values")

    @property
    def has_spread(self) -> bool:
        """Whether it can act by a sample."""
        return self.spread is not None or self.output == "scores"

    @property
    def units(self) -> int:
        """Numbers that come out for a row: of its actions, or scores."""
        return len(self.layers[-1].bias)

    def mean(self, rows: npt.NDArray) -> Rows:
        """Actions ``(row, action)`` in [−1, 1] without randomness."""
        return self._within(self.layers[-1](self._latent(rows)))

    def sampled(self, rows: npt.NDArray, noise: npt.NDArray) -> Rows:
        """As `mean`, with standard normal ``noise`` ``(row, action)`` in units of the spread."""
        latent = self._latent(rows)
        log_std = self.spread
        if isinstance(log_std, Layer):
            log_std = np.clip(log_std(latent), *map(np.float32, _LOG_STD))
        assert log_std is not None
        moved = self.layers[-1](latent) + np.exp(log_std) * noise.astype(np.float32)
        return self._within(moved)

    def ratings(self, rows: npt.NDArray, agents: int) -> Rows:
        """Scores or values ``(row, agent, push)``."""
        return self.layers[-1](self._latent(rows)).reshape(len(rows), agents, -1)

    def _latent(self, rows: npt.NDArray) -> Rows:
        x = np.asarray(rows, dtype=np.float32)
        if self.scale is not None:
            x = x * self.scale
        for layer in self.layers[:-1]:
            x = layer(x)
        return x

    def _within(self, action: Rows) -> Rows:
        return np.tanh(action) if self.output == "tanh" else np.clip(action, -1, 1)


def _layer(
    arrays: Mapping[str, npt.NDArray], weight: str, bias: str | None, activation: str = "identity"
) -> Layer:
    if activation not in ACTIVATIONS:
        raise ValueError(f"its activation is {activation!r:.40}")
    matrix = _numbers(arrays, weight, 2)
    zero = np.zeros(len(matrix), dtype=np.float32)
    offset = zero if bias is None else _numbers(arrays, bias, 1)
    if offset.shape != matrix.shape[:1] or not matrix.size:
        raise ValueError(f"{weight!r:.60} and its bias have other shapes")
    return Layer(weight=matrix, bias=offset, activation=activation)


def _numbers(arrays: Mapping[str, npt.NDArray], name: str, dimensions: int) -> npt.NDArray:
    found = arrays[name]
    if found.dtype != np.float32 or found.ndim != dimensions:
        raise ValueError(f"{name!r:.60} is {found.dtype} of shape {found.shape}")
    return found
