"""How colours look to those who lack one kind of cone: Machado, Oliveira & Fernandes 2009."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray

# (3, 3) for linear RGB, at full severity
LACKING = {
    "nothing": np.eye(3),
    "long": np.array(
        [
            (0.152286, 1.052583, -0.204868),
            (0.114503, 0.786281, 0.099216),
            (-0.003882, -0.048116, 1.051998),
        ]
    ),
    "middle": np.array(
        [
            (0.367322, 0.860646, -0.227968),
            (0.280085, 0.672501, 0.047413),
            (-0.011820, 0.042940, 0.968881),
        ]
    ),
    "short": np.array(
        [
            (1.255528, -0.076749, -0.178779),
            (-0.078411, 0.930809, 0.147602),
            (0.004733, 0.691367, 0.303900),
        ]
    ),
}
_XYZ = np.array(  # of linear sRGB, white of D65
    [
        (0.4124564, 0.3575761, 0.1804375),
        (0.2126729, 0.7151522, 0.0721750),
        (0.0193339, 0.1191920, 0.9503041),
    ]
)
GREY = np.array([(0.2126729, 0.7151522, 0.0721750)] * 3)  # what a printer without colours makes


def apart(one: npt.ArrayLike, other: npt.ArrayLike, seen: FloatArray) -> float:
    """How far two colours (0-255) are from each other, ΔE of CIELAB; 2 is just seen.

    ``seen`` is one of `LACKING`, or `GREY`.
    """
    return float(np.linalg.norm(_lab(one, seen) - _lab(other, seen)))


def _lab(color: npt.ArrayLike, seen: FloatArray) -> FloatArray:
    value = np.asarray(color, dtype=np.float64) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    white = _XYZ.sum(axis=1)
    light = _XYZ @ np.clip(seen @ linear, 0.0, 1.0) / white
    x, y, z = np.where(light > 0.008856, np.cbrt(light), 7.787 * light + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])
