"""Opening of a recording: one file, or those of several devices, with gaps filled if asked for."""

import os
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs.corrections.oriented import as_made, key_of, oriented, unsigned, written_in
from coopenv.logs.declared.devices import Device
from coopenv.logs.declared.stamps import Origin
from coopenv.logs.formats import open_source, parts_of
from coopenv.logs.formats.chunks import Source
from coopenv.logs.joining.filled import FilledSource
from coopenv.logs.joining.source import JoinedSource
from coopenv.logs.joining.stream import Stream
from coopenv.logs.layout import Layout
from coopenv.logs.limits import shown


class Opened(NamedTuple):
    """A recording, and what its layout means for it."""

    source: Source
    layout: Layout


def open_recording(path: str | os.PathLike, layout: Layout, *, strict: bool = True) -> Opened:
    """What a layout makes of a file and those beside it.

    Where devices are joined, time comes in seconds and under its own name: so the layout that is
    returned says.

    Parameters
    ----------
    path
        Of the recording.
    layout
        As declared.
    strict
        Whether bad samples of the devices beside it are errors, rather than none.

    Raises
    ------
    InvalidInput
        If a file cannot be read, or devices cannot be joined as the layout says.
    UnknownName
        If the clock is none of the devices.
    """
    path = Path(path)
    devices = _devices(path, layout)
    first = devices[0]
    alone = len(devices) == 1 and not (first.part or first.rate or first.delay or first.time)
    if alone and layout.join_rate is None and not first.unit:
        source = open_source(path, first.dialect, layout.limits)
        source = oriented(source, f"{path}", layout)
    else:
        source = _joined(path, layout, devices, strict)
        columns = {name: theirs for name, theirs in layout.columns.items() if name != "time"}
        layout = replace(layout, columns=columns, time="s")
    layout = as_made(layout)
    return Opened(source if layout.fill == "none" else FilledSource(source, layout), layout)


def _devices(path: Path, layout: Layout) -> tuple[Device, ...]:
    """Those that are declared; the streams of a file that has several, where none is."""
    devices = layout.devices(path.name.split(".")[0] or "recording")
    parts = parts_of(path, layout.limits)
    own = [device for device in devices if not device.path and not device.part]
    if not parts or not own:
        return devices
    streams = [replace(own[0], name=part, part=part) for part in parts]
    return (*streams, *(device for device in devices if device not in own))


def _joined(path: Path, layout: Layout, devices: tuple[Device, ...], strict: bool) -> JoinedSource:
    by_rows = layout.join_method == "rows"
    names = [device.name for device in devices]
    if layout.clock and layout.clock not in names:
        raise UnknownName(f"clock of {path}", layout.clock, names)
    if layout.join_rate is not None and (by_rows or layout.clock):
        raise InvalidInput(
            f"{path}: join_rate must be said alone, got a clock or join_method rows too; leave one "
            "out"
        )
    several = sum(not device.path for device in devices) > 1
    if several and not layout.clock and layout.join_rate is None:
        raise InvalidInput(
            f"{path} must be joined on the clock of one of its streams, got "
            f"{', '.join(map(shown, names))}; say --clock {shown(names[0])}, or --join-rate"
        )
    origin = Origin()
    streams = [
        Stream(
            device,
            path.parent / device.path if device.path else path,
            layout,
            origin,
            by_rows=by_rows,
            strict=strict,
        )
        for device in devices
    ]
    _orient(path, layout, streams)
    clock = streams[names.index(layout.clock) if layout.clock else 0]
    kept = clock if layout.join_rate is None else None
    return JoinedSource(streams, kept, layout.join_rate, layout.limits, by_rows=by_rows)


def _orient(path: Path, layout: Layout, streams: list[Stream]) -> None:
    """Make the documented orientation of the device that has the columns of ``[pose]``."""
    asked = written_in(layout)
    if not asked:
        return
    found: list[tuple[Stream, tuple[str, ...]]] = []
    for stream in streams:
        own = tuple(_own(name, stream.name) for name in asked)
        stream.source.offer(name for each in own for name in (each, each.removeprefix("-")))
        columns = stream.source.columns
        if set(unsigned(own, columns)) <= set(columns):
            found.append((stream, own))
    if len(found) != 1:
        which = " and ".join(shown(stream.name) for stream, _ in found) or "none"
        remedy = f"write {found[0][0].name}/{asked[0]} …" if found else "look at their names"
        raise InvalidInput(
            f"{path}: {key_of(layout)} must be columns of one device, got "
            f"{', '.join(map(shown, asked))} of {which}; {remedy}"
        )
    stream, own = found[0]
    stream.source = oriented(stream.source, f"{stream.path}", layout, own)


def _own(name: str, device: str) -> str:
    """What a device calls a column that a layout calls by the device, with its sign."""
    sign = "-" * name.startswith(f"-{device}/")
    return sign + name.removeprefix("-" if sign else "").removeprefix(f"{device}/")
