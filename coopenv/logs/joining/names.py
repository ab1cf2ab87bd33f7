"""Names of the columns of joined devices: what each is called, and whose it is."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from coopenv.errors import InvalidInput
from coopenv.logs.formats.chunks import Roles, Wanted
from coopenv.logs.joining.stream import Stream

TIME = "time"


class Owned(NamedTuple):
    """A column, and whose it is."""

    stream: Stream
    name: str  # in its file


class Names(Mapping[str, Owned]):
    """Columns of all devices but their times, by the names under which they are joined.

    A column is called as in its file if no other file has one of that name, else ``left/Fx``.
    """

    def __init__(self, streams: Sequence[Stream]):
        self._streams = streams
        self._place: dict[str, Owned] = {}
        count = Counter(name for stream in streams for name in stream.columns)
        for stream in streams:
            for name in stream.columns:
                alone = count[name] == 1 and name != TIME
                self._place[name if alone else f"{stream.name}/{name}"] = Owned(stream, name)

    def __getitem__(self, name: str) -> Owned:
        return self._place[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._place)

    def __len__(self) -> int:
        return len(self._place)

    @property
    def units(self) -> dict[str, str]:
        """Units of columns, where their files say them."""
        return {
            name: unit
            for name, (stream, own) in self.items()
            if (unit := stream.source.units.get(own))
        }

    @property
    def made(self) -> list[str]:
        """Columns that are made of others, and are in no file."""
        return [name for name, (stream, own) in self.items() if own in stream.source.made]

    def offer(self, names: Iterable[str]) -> None:
        """Make columns of what names say by device, and of parts of arrays.

        Raises
        ------
        InvalidInput
            If several devices have a column of such a name.
        """
        for name in names:
            if name in self._place:
                continue
            of_device = [each for each in self._streams if name.startswith(f"{each.name}/")]
            for stream in of_device or self._streams:
                own = name.removeprefix(f"{stream.name}/") if of_device else name
                self._offer(name, stream, own)

    def _offer(self, name: str, stream: Stream, own: str) -> None:
        if own not in stream.source.columns:
            stream.source.offer([own])
        if own not in stream.columns:
            return
        if name in self._place:
            first = self._place[name].stream.name
            raise InvalidInput(
                f"{name} must be a column of one device, got it of {first} and {stream.name}; "
                f"write {first}/{name}"
            )
        for other, there in list(self._place.items()):
            if there == (stream, own):  # under its name alone
                del self._place[other]
        self._place[name] = Owned(stream, own)

    def wanted_of(self, stream: Stream, wanted: Wanted) -> Wanted:
        """What is wanted of one device, as its file calls it."""

        def own(names: Sequence[str]) -> list[str]:
            there = (self[name].name for name in names if self._is_of(stream, name))
            return list(dict.fromkeys(there))

        return Wanted(own(wanted.numbers), own(wanted.carried))

    def roles_of(self, stream: Stream, roles: Roles) -> Roles:
        """What columns of one device are, as its file calls them."""
        own = {
            name: self[name].name
            for name in (*roles.quaternion, roles.angle)
            if self._is_of(stream, name)
        }
        return Roles(
            quaternion=tuple(own[name] for name in roles.quaternion if name in own),
            angle=own.get(roles.angle, ""),
            period=roles.period,
        )

    def _is_of(self, stream: Stream, name: str) -> bool:
        return name in self and self[name].stream is stream
