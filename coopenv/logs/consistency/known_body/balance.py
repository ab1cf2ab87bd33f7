"""Balance of a recording with the motion of a body whose mass and inertia are known."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.consistency.known_body.explanations import Explanation, explanations
from coopenv.logs.consistency.known_body.known import Motion, Windows
from coopenv.logs.consistency.known_body.late import Times
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.consistency.windows import Segments
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording
from coopenv.logs.recorded.devices import Devices

MOST_ROWS = 30_000  # that are kept, after averaging to some hundred a second: five minutes
ENOUGH = 20  # rows in a window of `Segments`, of more some are averaged
LEAST = 20  # windows


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """Comparison along one axis of the object: measured = gain · expected + bias."""

    name: str  # fx … tz
    r2: float  # square of the correlation, in [0, 1]
    gain: float
    bias: float  # [N] or [N·m]
    size: float  # root mean square of what is expected, its mean taken off [N] or [N·m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """Result of the comparison of G h with M dv/dt + D v and weight."""

    axes: tuple[Axis, ...] = ()
    left: float = np.nan  # part of what moves the body that is not accounted for; 0 is perfect
    delay: float = np.nan  # [s] by which the pose is late, where that fits best
    rows: int = 0  # compared, after averaging
    unchecked: str = ""  # why nothing could be compared
    devices: tuple[str, ...] = ()  # how late each of several fits best, in words
    explanations: tuple[
        Explanation, ...
    ] = ()  # mistakes that would account for it, likeliest first

    def lines(self) -> Iterator[str]:
        """What a summary says of it."""
        if self.unchecked:
            yield f"not compared with the known body: {self.unchecked}"
            return
        for axis in self.axes:
            unit = "N" if axis.name[0] == "f" else "N·m"
            yield (
                f"known body, {axis.name}: r² {axis.r2:.3f}, gain {axis.gain:.3f}, bias "
                f"{axis.bias:+.3g} {unit} of {axis.size:.3g} {unit}"
            )
        yield (
            f"known body: {100 * self.left:.2g} % of what moves it is not accounted for; the pose "
            f"fits best {self.delay:+.3f} s late"
        )
        yield from (f"known body: {said}" for said in self.devices)


class Balancing:
    """Collects the rows of a recording that comes chunk by chunk, as many as fit in memory."""

    def __init__(self, layout: Layout, devices: Devices | None = None):
        self._layout, self._devices = layout, devices
        self._segments = Segments(ENOUGH)
        self._kept: list[Recording] = []
        self._rows = 0

    def add(self, recording: Recording) -> None:
        """Append rows."""
        if recording.position is None or recording.orientation is None or self._rows >= MOST_ROWS:
            return
        for segment, _ in self._segments.of(recording):
            if self._rows < MOST_ROWS:
                self._kept.append(replace(segment, carried={}))
                self._rows += len(segment)

    def result(self) -> Balance:
        """Of the rows so far."""
        runs = [run for run in _joined(self._kept) if run.time is not None and len(run) > 2]
        motions = [Motion.of(run) for run in runs]
        windows = [each for each in map(Windows, motions) if len(each)]
        if sum(map(len, windows)) < LEAST:
            return Balance(unchecked="fewer than some seconds with time and pose in sequence")
        body, dimension = self._layout.body, runs[0].grips.shape[-1]
        misfit = Misfit.of(windows, body, dimension)
        if misfit.is_still():
            return Balance(unchecked="it hardly moves")
        motions = [each.motion for each in windows]
        times = Times.of(motions, body, dimension, self._devices)
        return Balance(
            axes=tuple(_axes(misfit, dimension)),
            left=misfit.share(),
            delay=times.delay,
            devices=times.lines(),
            rows=self._rows,
            explanations=tuple(explanations(windows, misfit, self._layout, dimension, times)),
        )


def _joined(kept: list[Recording]) -> list[Recording]:
    """Segments that overlap, as they came, as runs without the rows that come twice."""
    runs: list[Recording] = []
    for segment in kept:
        assert segment.time is not None
        last = runs[-1] if runs else None
        if last is not None and last.time is not None and last.trial[-1] == segment.trial[0]:
            step = float(np.median(np.diff(last.time))) if len(last) > 1 else 0.0
            new = segment.time > last.time[-1] + step / 2
            if new.any() and segment.time[new][0] - last.time[-1] < 3 * step:
                runs[-1] = Recording.joined([last, segment.take(new)])
                continue
        runs.append(segment)
    return runs


def _axes(misfit: Misfit, dimension: int) -> Iterator[Axis]:
    names = ("fx", "fy", "fz", "tx", "ty", "tz")
    for name in names if dimension == 3 else ("fx", "fy", "tz"):
        j = names.index(name)
        yield _axis(name, misfit.acting[:, j], misfit.wanted[:, j])


def _axis(name: str, acting: FloatArray, wanted: FloatArray) -> Axis:
    about, moved = acting - acting.mean(), wanted - wanted.mean()
    size, other = float(moved @ moved), float(about @ about)
    product = float(about @ moved)
    gain = product / size if size > 0 else np.nan
    return Axis(
        name=name,
        r2=product**2 / (size * other) if size > 0 and other > 0 else np.nan,
        gain=gain,
        bias=float(acting.mean() - gain * wanted.mean()),
        size=float(np.sqrt(size / len(moved))),
    )
