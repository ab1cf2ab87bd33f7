"""A mistake that would account for a misfit, and how sensors are named in it."""

from dataclasses import dataclass


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


def sensors_named(group: tuple[int, ...], count: int) -> str:
    """Some sensors in words."""
    if len(group) == 1:
        return f"sensor {group[0] + 1}"
    return (
        "all sensors"
        if len(group) == count and count > 2
        else "sensors " + " and ".join(str(i + 1) for i in group)
    )
