"""Info: a dictionary of names and numbers whose entries are made when they are asked for."""

from collections.abc import Iterator
from typing import Any, Protocol

from coopenv.pytrees import register_dictionary

FIRST = "success"  # is always there, and made at once
REWARD, BODY, COST = "reward/", "body/", "cost"  # what keys of a group begin with
GROUPS = {  # what indexing gives as a dictionary of its own
    "reward_terms": REWARD,
    "body": BODY,
    "cost_terms": f"{COST}/",
}


class Source(Protocol):
    """What an `Info` of a step takes its entries from when it is asked for them."""

    def __iter__(self) -> Iterator[str]:
        """Names of the entries, in order."""
        ...

    def __contains__(self, name: object) -> bool:
        """Whether there is an entry of that name."""
        ...

    def __getitem__(self, name: str) -> Any:
        """An entry, made anew or never changed."""
        ...


class Info(dict[str, Any]):
    """What an environment tells beside the observation: names and numbers.

    ``info["reward_terms"]`` is the dictionary of all ``info["reward/<term>"]``, and
    ``info["body"]``, where bodies are randomised, that of all ``info["body/<number>"]``; where
    there is a cost, ``info["cost_terms"]`` is that of all ``info["cost/<term>"]``. They are made
    when they are asked for: they are no entries, and nothing that goes through the entries meets
    them.

    The entries of a step are made when they are asked for too: one that is indexed by itself, all
    of them by anything else. They are of their step, however late that is; to whoever uses it, it
    is a dictionary that has had them from the beginning.

    >>> info = Info({"success": False, "reward/progress": 0.25})
    >>> info["reward_terms"]
    {'progress': 0.25}
    >>> list(info)
    ['success', 'reward/progress']
    """

    pending: Source | None = None  # where entries come from that are still to be made

    @classmethod
    def of(cls, source: Source) -> "Info":
        """An info whose entries are made when they are asked for.

        All but one, since Python's JSON takes a dictionary for empty by its memory.
        """
        info = cls()
        dict.__setitem__(info, FIRST, source[FIRST])
        info.pending = source
        return info

    def __missing__(self, name: str) -> Any:
        source = self.pending
        if source is not None and name in source:
            entry = source[name]
            dict.__setitem__(self, name, entry)
            return entry
        start = GROUPS.get(name)
        group = {} if start is None else self._group(start)
        if start is None or (not group and name != "reward_terms"):
            raise KeyError(name)
        return group

    def _group(self, start: str) -> dict[str, Any]:
        return {name[len(start) :]: self[name] for name in self.names() if name.startswith(start)}

    def __contains__(self, name: object) -> bool:
        return dict.__contains__(self, name) or (self.pending is not None and name in self.pending)

    def get(self, name: str, default: Any = None) -> Any:
        """The entry of that name, or ``default``; no group."""
        known = name in self
        return self[name] if known else default

    def names(self) -> Iterator[str]:
        """Names of the entries, of which none is made for that."""
        return dict.__iter__(self) if self.pending is None else iter(self.pending)

    def copy(self) -> "Info":
        """A copy that knows its groups too."""
        return type(self)(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)

    def complete(self) -> None:
        """Make the entries that are missing, and put all in order."""
        source = self.pending
        if source is None:
            return
        made = {
            name: dict.__getitem__(self, name) if dict.__contains__(self, name) else source[name]
            for name in source
        }
        dict.clear(self)
        dict.update(self, made)
        self.pending = None


class _Completed:
    """A method of `dict` that meets all entries, or changes some.

    Of the class it is that of `dict` itself, by which `pprint` and IPython know how to write one.
    """

    def __init__(self, name: str):
        self._of_dict = getattr(dict, name)

    def __get__(self, info: Info | None, owner: type | None = None) -> Any:
        if info is None:
            return self._of_dict
        info.complete()
        return self._of_dict.__get__(info)


def _compared(name: str) -> Any:
    """`dict.__eq__`, say, of all entries of both."""
    of_dict = getattr(dict, name)

    def compare(info: Info, other: object) -> Any:
        info.complete()
        if isinstance(other, Info):
            other.complete()
        return of_dict(info, other)

    return compare


for _name in (
    "__iter__", "__reversed__", "__len__", "__or__", "__ror__", "__ior__",
    "__repr__", "__setitem__", "__delitem__", "__sizeof__", "clear", "items", "keys", "pop",
    "popitem", "setdefault", "update", "values",
):  # fmt: skip
    setattr(Info, _name, _Completed(_name))
for _name in ("__eq__", "__ne__"):
    setattr(Info, _name, _compared(_name))

register_dictionary(Info)
