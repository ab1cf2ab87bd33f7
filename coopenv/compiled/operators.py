"""Typing of operators, remembered: what the product of two floats is, numba asks anew each time.

It asks all that know the operator in turn, of which there are dozens, and for vectors of the
processor (`coopenv.compiled.lanes`) the last one knows. That takes half of the time of typing.
"""

import operator
from functools import cache
from typing import Any

from numba import types
from numba.core.typing.context import Context

_OPERATORS = frozenset((bool, *filter(callable, vars(operator).values())))


class _Remembering(Context):
    """A context of numba's, by another name: all that it knows or learns is that one's."""

    def __init__(self, context: Context):
        self.__dict__ = context.__dict__

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """As numba does it; once for each operator and the types that it is used on."""
        called = func.typing_key if isinstance(func, types.Function) else func
        if kws or called not in _OPERATORS or not all(map(_is_lasting, args)):
            return super().resolve_function_type(func, args, kws)
        key = (func, *args)
        found = _known.get(key)
        if found is None:  # what cannot be typed is asked for again, for the sake of its message
            found = super().resolve_function_type(func, args, kws)
            if found is not None:
                _known[key] = found
        return found


class Plain(types.Type):
    """A type of compiled code whose operators are all declared where it is made."""


def _is_lasting(kind: Any) -> bool:
    """Whether nothing that is defined later changes what operators make of a type."""
    if isinstance(kind, types.BaseTuple):  # an index
        elements: Any = kind  # it can be gone through
        return all(map(_is_lasting, elements))
    return isinstance(kind, _LASTING)


_LASTING = types.Number, types.Boolean, types.Array, types.SliceType, Plain
remembering: Any = cache(_Remembering)  # one for each: numba remembers what it compiled for whom
_known: dict[Any, Any] = {}
