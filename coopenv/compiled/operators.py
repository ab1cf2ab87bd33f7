"""Typing of operators, remembered: what the product of two floats is, numba asks anew each time.

It asks all that know the operator in turn, of which there are dozens, and for vectors of the
processor (`coopenv.compiled.lanes`) the last one knows. It does so for each place where an operator
stands, and once or twice again when the place is translated. That takes half of the time of typing.
An ``@overload`` of an operator is asked for each time, as it is compiled with its caller's flags.
"""

import operator
from collections.abc import Callable
from typing import Any

from numba import types

_OPERATORS = frozenset((bool, *filter(callable, vars(operator).values())))


def remembering(ask: Callable[..., Any]) -> Callable[..., Any]:
    """Numba's answer to what a function makes of types; one for each operator and its types."""
    known: dict[Any, tuple[Any, Any]] = {}

    def answer(function: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws or function.typing_key not in _OPERATORS or not all(map(_is_lasting, args)):
            return ask(function, context, args, kws)
        key = id(function), id(context), *args
        if key in known:
            return known[key][1]
        found = ask(function, context, args, kws)  # raises where there is none
        if function.get_impl_key(found) is function.typing_key:  # no `@overload`
            known[key] = (function, context), found
        return found

    return answer


class Plain(types.Type):
    """A type of compiled code whose operators are all declared where it is made."""


def _is_lasting(kind: Any) -> bool:
    """Whether nothing that is defined later changes what operators make of a type."""
    if isinstance(kind, types.BaseTuple):  # an index
        elements: Any = kind  # it can be gone through
        return all(map(_is_lasting, elements))
    return isinstance(kind, _LASTING)


_LASTING = types.Number, types.Boolean, types.Array, types.SliceType, Plain
