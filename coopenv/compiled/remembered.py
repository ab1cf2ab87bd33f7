"""Answers that numba looks for again and again while it compiles, though they do not change.

It goes through all that was ever registered with it before each function, for what is new there;
takes functions of its own apart for the names of their parameters at every call of one; and sorts
the same definitions by the kind of processor that they are for.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any
from weakref import WeakKeyDictionary

from numba.core.imputils import builtin_registry


def refreshing(refresh: Callable[[Any], None]) -> Callable[[Any], None]:
    """Numba's look at what was registered, after the first one where there is something new.

    Parameters
    ----------
    refresh
        The method of a context, of types or of a kind of processor.
    """

    def refreshed(context: Any) -> None:
        seen = vars(context).setdefault("_seen_by_coopenv", {})  # numba's copies of it share this
        known, is_target = context._registries, hasattr(context, "typing_context")
        if seen and (not is_target or builtin_registry in known):
            for registry, loader in [*known.items()]:
                if seen.get(registry) != _size(registry, loader):
                    context.install_registry(registry)
            if is_target:
                context.typing_context.refresh()
        else:
            seen[None] = []  # what is registered meanwhile asks for the same
            try:
                refresh(context)
            except BaseException:
                seen.clear()
                raise
        seen.update({one: _size(one, loader) for one, loader in known.items()})

    return refreshed


def _size(registry: Any, loader: Any) -> list[int]:
    """How much there is in each list of a registry."""
    return [len(getattr(registry, name)) for name in loader.registry_items]


def signatures(signature: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Numba's way to the parameters of a function, gone once for each."""
    known: WeakKeyDictionary[Any, Any] = WeakKeyDictionary()

    def remembered(function: Any) -> Any:
        if type(function) is not FunctionType:
            return signature(function)
        found = known.get(function)
        if found is None:
            found = known[function] = signature(function)
        return found

    return remembered


def ordering(order: Callable[..., list[Any]]) -> Callable[..., list[Any]]:
    """Numba's order of definitions, made once for each processor and list of them."""
    made: dict[Any, list[Any]] = {}

    def ordered(target: Any, templates: list[Any], fnkey: Any = "") -> list[Any]:
        key = target, *templates
        if key not in made:
            made[key] = order(target, templates, fnkey=fnkey)
        return [*made[key]]

    return ordered
