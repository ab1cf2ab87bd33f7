"""Tares found in a file: means of what is left of the wrench while nothing is held.

They are found in a pass of their own over the rows of the rests, before anything is handed on.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.processing import Filters
from coopenv.logs.calibration.sensor import Tare
from coopenv.logs.calibration.tare import drift
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording

Opener = Callable[[str, Layout], Iterable[Recording]]


@dataclass(frozen=True, slots=True)
class Bias:
    """What is taken off an effector's wrench at its grip, object frame: constant, or drifting."""

    place: int  # of the effector, from 0
    first: FloatArray  # (3 or 6,)
    last: FloatArray | None = None
    times: tuple[float, float] = (0.0, 0.0)  # [s] of first and last

    def at(self, time: FloatArray | None, rows: int) -> FloatArray:
        """``(T, 3 or 6)``."""
        if self.last is None or time is None:
            return np.broadcast_to(self.first, (rows, len(self.first)))
        return drift(time, self.times, self.first, self.last)


def find_biases(path: str, layout: Layout, opener: Opener) -> list[Bias]:
    """Read what is needed of the file itself and of those that the layout names.

    Parameters
    ----------
    path
        Of the recording.
    layout
        Of it; files of rest have the same.
    opener
        Opens a file as recordings.

    Raises
    ------
    InvalidInput
        If there is no good row in a rest.
    """
    plain = without_tares(layout)
    found: list[Bias] = []
    told = {number: sensor.tare for number, sensor in layout.sensors.items()}
    own = {n: tare for n, tare in told.items() if isinstance(tare, Tare) and tare.file is None}
    if own:
        found += _own_rests(path, own, opener(path, plain))
    for number, tare in told.items():
        if isinstance(tare, Tare) and tare.file is not None:
            mean = _Mean()
            _require_own_devices(path, tare.file, layout, f"sensors.{number}.tare.file")
            for recording in opener(tare.file, plain):
                if not number <= recording.num_effectors:
                    raise InvalidInput(
                        f"sensors.{number}.tare.file must be of that effector too, got "
                        f"{tare.file!r} with {recording.num_effectors}; name another"
                    )
                mean.add(recording, recording.good, number - 1)
            found.append(Bias(number - 1, mean.value(f"sensors.{number}.tare.file", tare.file)[0]))
    return found


def _require_own_devices(path: str, rest: str, layout: Layout, key: str) -> None:
    """Raise where a file of rest would be joined with what other devices recorded in a trial."""
    for device in layout.devices("recording"):
        here, there = (Path(each).resolve().parent / device.path for each in (path, rest))
        if device.path and here == there:
            raise InvalidInput(
                f"{key} must lie beside files of its own where devices are joined, got {rest!r} "
                f"beside {device.path!r} of the trial; put what all of them recorded at rest into "
                "another folder"
            )


def without_tares(layout: Layout) -> Layout:
    """The layout for what is read only to find tares: constant ones stay, filters go."""
    sensors = {
        number: replace(sensor, tare=None) if isinstance(sensor.tare, Tare) else sensor
        for number, sensor in layout.sensors.items()
    }
    return replace(layout, sensors=sensors, filters=Filters())


class _Mean:
    """Running mean of wrenches and of their times."""

    def __init__(self):
        self._rows, self._time = 0, 0.0
        self._sum: FloatArray | float = 0.0

    def add(self, recording: Recording, rows: BoolArray, place: int) -> None:
        """Append some rows of an effector."""
        self._rows += int(rows.sum())
        self._sum = self._sum + recording.applied[rows, place].sum(axis=0)
        if recording.time is not None:
            self._time += float(recording.time[rows].sum())

    def value(self, key: str, place: str) -> tuple[FloatArray, float]:
        """Mean wrench and mean time."""
        if not self._rows:
            raise InvalidInput(
                f"{key} must be a rest with good rows, got none in {place}; name another time"
            )
        return np.asarray(self._sum) / self._rows, self._time / self._rows


def _own_rests(path: str, tares: Mapping[int, Tare], recordings: Iterable[Recording]) -> list[Bias]:
    """Biases from rests in the recording itself; it is read until the last of them is over."""
    rests: dict[int, list[tuple[float, float]]] = {}
    means: dict[int, list[_Mean]] = {}
    for recording in recordings:
        time = recording.time
        assert time is not None
        if not rests:
            usable = time[np.isfinite(time)]
            start = float(usable[0]) if len(usable) else 0.0
            for number, tare in tares.items():
                first = (start, start + tare.first) if tare.first is not None else (0.0, 0.0)
                rests[number] = list(tare.rests) if tare.rests is not None else [first]
                means[number] = [_Mean() for _ in rests[number]]
        of_first = recording.good & (recording.trial == 0)
        for number, ends in rests.items():
            for mean, (start, end) in zip(means[number], ends, strict=True):
                mean.add(recording, of_first & (time >= start) & (time <= end), number - 1)
        latest = max(end for ends in rests.values() for _, end in ends)
        if recording.trial[-1] > 0 or np.nanmax(np.append(time, -np.inf)) > latest:
            break
    return [_bias(path, number, ends, means[number]) for number, ends in rests.items()]


def _bias(path: str, number: int, ends: list[tuple[float, float]], means: list[_Mean]) -> Bias:
    values = [
        mean.value(
            f"sensors.{number}.tare", f"{path} from {start:g} to {end:g} s of its first trial"
        )
        for mean, (start, end) in zip(means, ends, strict=True)
    ]
    if len(values) == 1:
        return Bias(number - 1, values[0][0])
    (first, start), (last, end) = values
    return Bias(number - 1, first, last, (start, end))
