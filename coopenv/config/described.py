"""Keywords and JSON from which a description is made, and the JSON that it makes."""

from collections.abc import Mapping
from dataclasses import Field, fields
from typing import Any, ClassVar, TypeVar

from coopenv.config.document import document_of, fields_in
from coopenv.config.keywords import complete
from coopenv.config.own_code import Trust

_Kind = TypeVar("_Kind", bound="Described")


class Described:
    """A frozen dataclass that is read from keywords or JSON, and written as JSON."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @classmethod
    def parse(
        cls: type[_Kind], keywords: Mapping[str, Any], defaults: Mapping[str, Any] | None = None
    ) -> _Kind:
        """The configuration that ``keywords`` describe; an unknown name raises `UnknownName`.

        ``defaults`` stand for what the keywords leave out, unless these bring a task of another
        kind than theirs.

        ``max_episode_steps`` (Gymnasium's word) and ``max_cycles`` (PettingZoo's) stand for
        ``horizon`` and override it.
        """
        return cls(**complete(keywords, defaults or {}, [entry.name for entry in fields(cls)]))

    def to_json(self) -> str:
        """All of it as JSON text, from which `from_json` makes an equal one.

        The text is strict JSON, made for people, and always the same for the same configuration.
        Every object says its kind by its public name, and all its fields, so that a default that
        changes later changes nothing here. Functions and frozen dataclasses of your own are named
        ``module:name`` with a hash of their source file.

        Raises
        ------
        InvalidInput
            If something could not be found again by its name (a lambda, what is defined in a
            function or in the script that runs) or would not come back equal; the message names it.
        """
        return document_of({entry.name: getattr(self, entry.name) for entry in fields(self)})

    @classmethod
    def from_json(cls: type[_Kind], text: str, *, trust: Trust = False) -> _Kind:
        """The configuration that `to_json` wrote.

        A field that is not there has its default.

        Parameters
        ----------
        text
            JSON.
        trust
            Whether code that is not of coopenv may be imported where the text names it: of these
            modules (with what is in them), or ``True``: of any. Without it a text from elsewhere
            runs nothing, whatever is imported already.

        Raises
        ------
        InvalidInput, UnknownName
            If the text is not JSON of this format, a kind, a field or a value is wrong, or code of
            your own is not trusted, not there, or in a file that has changed since.
        """
        return cls(**fields_in(text, [entry.name for entry in fields(cls)], trust))
