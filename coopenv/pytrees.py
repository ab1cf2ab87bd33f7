"""JAX pytrees: a class of ours that is a dictionary is a tree of its entries there, not a leaf.

JAX goes by the class itself, not by what it inherits from, and Minari collects infos with JAX,
which it imports in the midst of an episode. So a class is registered at the end of JAX's own
import, whenever that is; nothing of JAX is imported from here.
"""

import sys
from collections.abc import Iterable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

TREES = "jax.tree_util"  # where classes are registered


def register_dictionary(kind: type[dict[str, Any]]) -> None:
    """Make a class of dictionaries a pytree node of its entries, in the order of their names.

    At once where JAX is imported, else as soon as it is.
    """
    trees = sys.modules.get(TREES)
    if trees is not None:
        _register(kind, trees)
    else:
        sys.meta_path.insert(0, _AfterImport(kind))


class _AfterImport(MetaPathFinder):
    """Finds nothing itself: has the others find JAX's trees, and registers a class with them."""

    def __init__(self, kind: type[dict[str, Any]]):
        self.kind = kind

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """What the finders behind this one find, to be followed by the registration."""
        if fullname != TREES:
            return None
        sys.meta_path.remove(self)
        for finder in sys.meta_path:
            spec = finder.find_spec(fullname, path, target)
            if spec is not None and spec.loader is not None:
                self._follow(spec.loader)
                return spec
        return None

    def _follow(self, loader: Any) -> None:
        execute = loader.exec_module

        def exec_module(module: ModuleType) -> None:
            del loader.exec_module  # the class's own again
            execute(module)
            _register(self.kind, module)

        loader.exec_module = exec_module


def _register(kind: type[dict[str, Any]], trees: Any) -> None:
    def flat(node: dict[str, Any]) -> tuple[list[Any], tuple[str, ...]]:
        names = tuple(sorted(node))
        return [node[name] for name in names], names

    def flat_with_keys(node: dict[str, Any]) -> tuple[list[Any], tuple[str, ...]]:
        entries, names = flat(node)
        return [(trees.DictKey(n), e) for n, e in zip(names, entries, strict=True)], names

    def made(names: Iterable[str], entries: Iterable[Any]) -> dict[str, Any]:
        return kind(zip(names, entries, strict=True))

    trees.register_pytree_with_keys(kind, flat_with_keys, made, flat)
