"""What was done to a recording, in sentences: for its summary and beside its table."""

from collections.abc import Iterable, Iterator

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.sensor import Sensor, Tare
from coopenv.logs.corrections.tares import Bias
from coopenv.logs.layout import Layout


def sentences(layout: Layout, biases: list[Bias]) -> tuple[str, ...]:
    """One a correction, in the order in which they were made."""
    return tuple(_all(layout, {bias.place + 1: bias for bias in biases}))


def _all(layout: Layout, biases: dict[int, Bias]) -> Iterator[str]:
    pose, filters = layout.pose, layout.filters
    if pose.columns or pose.order is not None:
        named = f" from {', '.join(pose.columns)}" if pose.columns else ""
        yield f"orientation: {pose.orientation} {pose.order}{named}"
    if any(pose.com):
        yield (
            f"tracked origin: position, twist and grips moved to the centre of mass at "
            f"{listed(pose.com)} {layout.length} of the tracked frame"
        )
    if pose.delay:
        yield f"delay: pose and twist taken {pose.delay:g} s earlier"
    if filters.twist_window is not None:
        yield f"twist: from the pose, by cubics over {filters.twist_window:g} s"
    for number, sensor in sorted(layout.sensors.items()):
        parts = [*_sensor(sensor, layout)]
        if number in biases:
            parts.append(_tare(sensor.tare, biases[number]))
        if parts:
            yield f"sensor {number}: {'; '.join(parts)}"
    for name in ("wrench", "pose", "twist"):
        cutoff = getattr(filters, name)
        if cutoff is not None:
            yield (
                f"low pass: {name} by Butterworth of order {filters.order} at {cutoff:g} Hz, "
                "forward and backward"
            )
    if filters.rate is not None:
        yield f"resampled: {filters.rate:g} rows a second, linear, orientation by slerp"


def _sensor(sensor: Sensor, layout: Layout) -> Iterator[str]:
    if isinstance(sensor.tare, tuple):
        units = f"{layout.force}, {layout.torque}"
        yield f"bias {listed(sensor.tare)} {units} taken off"
    if sensor.cross_talk is not None:
        yield "cross-talk matrix applied"
    if sensor.sign < 0:
        yield "sign turned"
    if sensor.rotation is not None:
        yield f"turned by {_rotation(sensor, layout)}"
    load = sensor.load
    if load is not None:
        what = "weight" if load.window is None else "weight and inertial force"
        sense = "taken off" if load.side == "hand" else "added"
        yield f"{what} of {load.mass:g} kg on the {load.side}'s side {sense}"
    if any(sensor.offset):
        yield f"moved by {listed(sensor.offset)} {layout.length} to the grip"


def _rotation(sensor: Sensor, layout: Layout) -> str:
    said = sensor.rotation
    if isinstance(said, float):
        return f"{said:g} {layout.angle}"
    if isinstance(said, tuple):
        return "a matrix"
    kind = "quaternion" if "quaternion" in said else "euler"
    return f"{kind} {listed(said[kind])} {said['order']}"


def _tare(tare: Tare, bias: Bias) -> str:
    unit = "N, N·m"
    if bias.last is not None:
        return (
            f"bias from {listed(bias.first)} at {bias.times[0]:.4g} s to {listed(bias.last)} "
            f"{unit} at {bias.times[1]:.4g} s taken off"
        )
    where = "first" if tare.first is not None else "rest"
    source = f"mean of {tare.file}" if tare.file is not None else f"mean of the {where}"
    if tare.first is not None:
        source += f" {tare.first:g} s"
    return f"bias {listed(bias.first)} {unit} taken off, {source}"


def listed(numbers: Iterable[float] | FloatArray) -> str:
    """Numbers in brackets, to six digits."""
    return f"({', '.join(f'{float(each):.6g}' for each in numbers)})"
