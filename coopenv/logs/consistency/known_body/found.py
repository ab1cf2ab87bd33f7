"""A mistake that would account for a misfit, and how sensors are named in it."""

from dataclasses import dataclass

from coopenv.logs.formats.chunks import Owner
from coopenv.logs.limits import legible, shown
from coopenv.logs.recorded.devices import Devices


@dataclass(frozen=True, slots=True)
class Explanation:
    """A mistake, what mends it, and what is left then."""

    kind: str  # "sign", "axis", "axes", "rotation", "offset", "bias", "load", "units", "delay" …
    text: str  # "if" goes before it
    remedy: str
    left: float  # `Misfit.share`
    rank: int  # the simpler, the smaller
    sensors: int = 1  # how many of them have it, where it is one of sensors


def are(group: tuple[int, ...]) -> str:
    """The verb that goes with them."""
    return "is" if len(group) == 1 else "are"


def sensors_named(group: tuple[int, ...], count: int, devices: Devices | None = None) -> str:
    """Some sensors in words, each with its file where several are joined."""
    named = [f"{i + 1}{label(devices.sensors[i]) if devices else ''}" for i in group]
    if len(group) == 1:
        return f"sensor {named[0]}"
    if len(group) == count and count > 2:
        return "all sensors"
    return f"sensors {' and '.join(named)}"


def label(owner: Owner | None) -> str:
    """A device in brackets, where there is one."""
    return "" if owner is None else f" ({shown(legible(owner.label))})"
