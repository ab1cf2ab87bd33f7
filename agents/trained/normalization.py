"""Normalisation of observations with the statistics of a policy's training."""

import io
import zipfile
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from coopenv.arrays import FloatArray

MOST_BYTES = 10**7  # of unpacked statistics, two numbers a feature


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Normalization:
    """(obs − mean) / √(variance + epsilon), within ± clip: as ``VecNormalize`` does it."""

    mean: FloatArray  # (feature,), in the observation's units
    variance: FloatArray  # (feature,)
    epsilon: float
    clip: float

    def __call__(self, rows: npt.NDArray) -> npt.NDArray[np.float32]:
        """Normalised observations ``(row, feature)``."""
        scaled = (rows - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.clip(scaled, -self.clip, self.clip).astype(np.float32)

    def to_bytes(self) -> bytes:
        """As an NPZ archive of plain arrays."""
        buffer = io.BytesIO()
        np.savez(
            buffer,
            mean=self.mean,
            variance=self.variance,
            epsilon=np.float64(self.epsilon),
            clip=np.float64(self.clip),
        )
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """What `to_bytes` wrote; raises `ValueError`, or of another kind, for anything else."""
        with zipfile.ZipFile(io.BytesIO(data)) as members:
            unpacked = sum(member.file_size for member in members.infolist())
        if unpacked > MOST_BYTES:
            raise ValueError(f"its statistics would unpack to {unpacked:,} bytes")
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            mean, variance = (arrays[name].astype(np.float64) for name in ("mean", "variance"))
            found = cls(
                mean=mean,
                variance=variance,
                epsilon=float(arrays["epsilon"]),
                clip=float(arrays["clip"]),
            )
        numbers = np.concatenate([mean, variance, [found.epsilon, found.clip]])
        if mean.shape != variance.shape or not np.isfinite(numbers).all() or found.clip <= 0:
            raise ValueError("its statistics are no finite means and variances")
        if (variance + found.epsilon <= 0).any():
            raise ValueError("its statistics have variances that are not positive")
        return found
