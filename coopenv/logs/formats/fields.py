"""Fields of a text table as numbers: what is one, what is missing, and what is neither."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray
from coopenv.logs.formats.chunks import Column

MISSING = {"", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-"}  # instead of a number


def as_numbers(column: Any, decimal: str) -> tuple[FloatArray, BoolArray | None]:
    """Numbers of a pyarrow column, NaN where a text is none; and where it is not even missing."""
    import pyarrow as pa

    if column.type == pa.float64():
        return column.to_numpy(), None
    texts = column.to_pylist()
    values = np.fromiter((_number(text, decimal) for text in texts), np.float64, len(texts))
    bad = np.zeros(len(texts), np.bool_)
    for row in np.flatnonzero(np.isnan(values)).tolist():
        bad[row] = texts[row].strip().lower() not in MISSING
    return values, bad


def _number(text: str, decimal: str) -> float:
    try:
        if "_" in text or (decimal != "." and "." in text):  # 1.234 may be meant as 1,234
            return np.nan
        return float(text.replace(decimal, "."))
    except ValueError:
        return np.nan


def spread(values: npt.NDArray, good: BoolArray, missing: object) -> Column:
    """Values where a row is good, and something else where it is not."""
    if good.all():
        return values
    made = np.full(len(good), missing, dtype=values.dtype)
    made[good] = values
    return made
