"""Balance of a recording with the motion of a body whose mass and inertia are known."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.consistency.known_body.collected import Collected
from coopenv.logs.consistency.known_body.explanations import ENOUGH, explanations, likeliest
from coopenv.logs.consistency.known_body.found import Explanation
from coopenv.logs.consistency.known_body.known import Windows
from coopenv.logs.consistency.known_body.late import Times
from coopenv.logs.consistency.known_body.lengths import lengths
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.consistency.known_body.otherwise import Again
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording
from coopenv.logs.recorded.devices import Devices


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
        late = f"; the pose fits best {self.delay:+.3f} s late" * (self.delay == self.delay)
        yield f"known body: {100 * self.left:.2g} % of what moves it is not accounted for{late}"
        yield from (f"known body: {said}" for said in self.devices)


class Balancing:
    """Collects the rows of a recording that comes chunk by chunk, as many as fit in memory."""

    def __init__(self, layout: Layout, devices: Devices | None = None, again: Again | None = None):
        self._layout, self._devices, self._again = layout, devices, again
        self._collected = Collected()

    def add(self, recording: Recording) -> None:
        """Append rows."""
        self._collected.add(recording)

    def result(self) -> Balance:
        """Of the rows so far."""
        windows = self._collected.windows()
        if not windows:
            return Balance(unchecked="fewer than some seconds with time and pose in sequence")
        body, dimension = self._layout.body, windows[0].motion.dimension
        misfit = Misfit.of(windows, body, dimension)
        if misfit.is_still():
            return self._of_still(windows, misfit)
        times = Times.of([each.motion for each in windows], body, dimension, self._devices)
        found = explanations(windows, misfit, self._layout, times, self._again)
        return Balance(
            axes=tuple(_axes(misfit, dimension)),
            left=misfit.share(),
            delay=times.delay,
            devices=times.lines(),
            rows=self._collected.rows,
            explanations=tuple(found),
        )

    def _of_still(self, windows: list[Windows], misfit: Misfit) -> Balance:
        """Of a body that hardly moves, unless it would in another unit of lengths."""
        found = lengths(windows, self._layout, self._again)
        good = tuple(likeliest([each for each in found if each.left < ENOUGH], misfit.share()))
        if not good:
            return Balance(unchecked="it hardly moves")
        return Balance(
            axes=tuple(_axes(misfit, windows[0].motion.dimension)),
            left=misfit.share(),
            rows=self._collected.rows,
            explanations=good,
        )


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
