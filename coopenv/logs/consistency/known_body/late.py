"""By how much the stamps of each device are late, and what of a layout takes it back."""

import json
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from coopenv.logs.calibration.body import Body
from coopenv.logs.consistency.known_body.found import Explanation, label
from coopenv.logs.consistency.known_body.known import Motion
from coopenv.logs.consistency.known_body.misfit import best_delay
from coopenv.logs.formats.chunks import Owner
from coopenv.logs.layout import Layout
from coopenv.logs.limits import shown
from coopenv.logs.recorded.devices import Devices

LEAST = 0.004  # [s] that is told
DOUBT = 0.0005  # `Misfit.share` above which more than one device may be late
SWEEPS = 3  # over devices, where several are late
BARE = re.compile(r"[A-Za-z0-9_-]+")  # names that TOML has without quotation marks


class Late(NamedTuple):
    """A device, by how much it is late beyond what is declared, and what is left then."""

    owner: Owner
    delay: float  # [s]
    left: float  # `Misfit.share`


class Times(NamedTuple):
    """By how much the pose is late where that fits best, and each device of several."""

    delay: float  # of the pose alone [s]
    left: float  # `Misfit.share` then
    devices: Devices | None = None
    alone: tuple[Late, ...] = ()
    all: tuple[Late, ...] = ()  # together, where one alone does not explain it

    @classmethod
    def of(
        cls, motions: Sequence[Motion], body: Body, dimension: int, devices: Devices | None
    ) -> "Times":
        """Of runs, each compared with what moves the known body."""
        delay, left = best_delay(motions, body, dimension)
        if devices is None:
            return cls(delay, left)
        alone = each_alone(motions, body, dimension, devices)
        several = len([owner for owner in devices.owners if owner != devices.pose]) > 1
        doubtful = several and min(late.left for late in alone) > DOUBT
        found = together(motions, body, dimension, devices) if doubtful else ()
        return cls(delay, left, devices, alone, found)

    def lines(self) -> tuple[str, ...]:
        """What a summary says of several devices."""
        if self.devices is None:
            return ()
        return tuple(
            f"{_who(late.owner, self.devices)} fits best {late.delay:+.3f} s late"
            for late in self.alone
        )

    def explanations(self, layout: Layout) -> Iterator[Explanation]:
        """Mistakes of times that would account for a misfit."""
        devices = self.devices
        pose = None if devices is None else devices.pose
        apart = devices is not None and pose is not None and not devices.sensors_of(pose)
        if abs(self.delay) > LEAST and not apart:
            total = layout.pose.delay + self.delay
            text = f"the pose is {abs(self.delay):.3f} s {'late' if self.delay > 0 else 'early'}"
            yield Explanation(
                "delay", text, f"[pose] delay = {round(total, 3) + 0.0:.3f}", self.left, 1
            )
        if devices is not None:
            for late in self.alone:
                yield from late_devices((late,), layout, devices)
            yield from late_devices(self.all, layout, devices, rank=2)


def each_alone(
    motions: Sequence[Motion], body: Body, dimension: int, devices: Devices
) -> tuple[Late, ...]:
    """The delay of each device that fits best, the others as they are declared."""
    made = []
    for owner in _told_apart(devices):
        sensors, pose = _of(owner, devices)
        made.append(Late(owner, *best_delay(motions, body, dimension, sensors, pose=pose)))
    return tuple(made)


def together(
    motions: Sequence[Motion], body: Body, dimension: int, devices: Devices
) -> tuple[Late, ...]:
    """The delays of all devices that fit best, against the pose, which is taken to be on time."""
    owners = [owner for owner in _told_apart(devices) if owner != devices.pose]
    found = dict.fromkeys(owners, 0.0)
    left = 1.0
    for _ in range(SWEEPS):
        before = dict(found)
        for owner in owners:
            moved = list(motions)
            for other in owners:
                sensors, pose = devices.sensors_of(other), False
                if other != owner:
                    rows = [round(found[other] / each.step) for each in moved]
                    moved = [
                        each.shifted(k, sensors, pose=pose)
                        for each, k in zip(moved, rows, strict=True)
                    ]
            found[owner], left = best_delay(
                moved, body, dimension, devices.sensors_of(owner), pose=False
            )
        if all(abs(found[owner] - before[owner]) < LEAST / 2 for owner in owners):
            break
    return tuple(Late(owner, delay, left) for owner, delay in found.items())


def late_devices(
    found: Sequence[Late], layout: Layout, devices: Devices, rank: int = 1
) -> Iterator[Explanation]:
    """One mistake, that the stamps of these devices are late; nothing where hardly any is."""
    told = [late for late in found if abs(late.delay) > LEAST]
    if not told:
        return
    parts = [
        f"{_who(late.owner, devices)} is {abs(late.delay):.3f} s "
        f"{'late' if late.delay > 0 else 'early'}"
        for late in told
    ]
    remedies = [_remedy(late.owner, layout, late.delay) for late in told]
    late_ones = [late.owner for late in told]
    if any(_is_undeclared(owner, layout) for owner in late_ones):  # who names one names all
        rest = [each for each in devices.all if each not in late_ones]
        remedies += [_remedy(each, layout) for each in rest if _is_undeclared(each, layout)]
    yield Explanation("delay", " and ".join(parts), ", ".join(remedies), told[0].left, rank)


def _told_apart(devices: Devices) -> tuple[Owner, ...]:
    """Devices whose delay shows against the others."""
    known = devices.pose is not None and None not in devices.sensors
    if known and len(devices.owners) == 2:  # of two clocks only the difference shows
        return devices.owners[:1]
    return devices.owners


def _of(owner: Owner, devices: Devices) -> tuple[tuple[int, ...], bool]:
    """Sensors that are a device's, and whether the pose is."""
    return devices.sensors_of(owner), devices.pose == owner


def _who(owner: Owner, devices: Devices) -> str:
    """A device by what it records."""
    sensors, pose = _of(owner, devices)
    words = ["the pose"] * pose + [f"sensor {i + 1}" for i in sensors]
    return " and ".join(words) + label(owner)


def _is_undeclared(owner: Owner, layout: Layout) -> bool:
    """Whether it is a part of the recording, of which all are devices as long as none is named."""
    return bool(owner.part) and owner.name not in layout.files


def _remedy(owner: Owner, layout: Layout, delay: float | None = None) -> str:
    """The line of a layout that takes a delay back, or names a part that is to stay."""
    name = owner.name if BARE.fullmatch(owner.name) else json.dumps(shown(owner.name))
    said = [f"part = {json.dumps(shown(owner.part))}"] * _is_undeclared(owner, layout)
    said += [] if delay is None else [f"delay = {round(owner.delay + delay, 3) + 0.0:.3f}"]
    return f"[files.{name}] {' '.join(said)}"
