"""The modules of this repository and what they import, read from their syntax alone."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PACKAGE = {"coopenv": "coopenv", "agents": "coopenv.agents", "rewards": "coopenv.rewards"}
AROUND = ("benchmarks", "examples", "tests")


class Arrow(NamedTuple):
    """Something that a module imports."""

    target: str  # the module it is imported from
    name: str  # what is taken from that module; empty where it is the module itself
    known_as: str
    line: int
    for_types: bool  # under ``if TYPE_CHECKING``


@cache
def modules() -> dict[str, Path]:
    """Name → file of every module, those around the package included."""
    found = {}
    for folder in (*PACKAGE, *AROUND):
        for path in _files(ROOT / folder):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            parts = parts[:-1] if parts[-1] == "__init__" else parts
            found[".".join((PACKAGE.get(folder, folder), *parts))] = path
    return found


@cache
def inside() -> dict[str, Path]:
    """Name → file of the modules of the package alone."""
    return {name: path for name, path in modules().items() if name.split(".")[0] == "coopenv"}


@cache
def syntax(module: str) -> ast.Module:
    path = modules()[module]
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def place(module: str, node: ast.AST | Arrow) -> str:
    """File and line, as editors open them."""
    line = node.line if isinstance(node, Arrow) else getattr(node, "lineno", 1)
    return f"{modules()[module].relative_to(ROOT)}:{line}"


@cache
def arrows(module: str) -> tuple[Arrow, ...]:
    """What a module imports, at its top and inside functions."""
    made = []
    for node, for_types in _imports(syntax(module), for_types=False):
        for each in node.names:
            known_as = each.asname or each.name
            if isinstance(node, ast.Import):
                made.append(Arrow(each.name, "", known_as, node.lineno, for_types))
                continue
            source = _absolute(module, node)
            target = f"{source}.{each.name}"
            taken = (target, "") if target in modules() else (source, each.name)
            made.append(Arrow(*taken, known_as, node.lineno, for_types))
    return tuple(made)


def circles(with_types: bool) -> list[list[str]]:
    """Groups of modules of the package, each of which is reached from each other."""
    graph = {
        module: {
            arrow.target
            for arrow in arrows(module)
            if arrow.target in inside() and (with_types or not arrow.for_types)
        }
        for module in inside()
    }
    reach = {module: _reached(module, graph) for module in graph}
    groups = {
        tuple(sorted(other for other in reach[module] if module in reach[other]))
        for module in graph
        if module in reach[module]
    }
    return sorted(map(list, groups))


def _files(top: Path) -> list[Path]:
    """Python files below a folder; what is linked into it belongs to another."""
    links = [path for path in top.iterdir() if path.is_symlink()]
    return [
        path
        for path in sorted(top.rglob("*.py"))
        if not any(path.is_relative_to(link) for link in links)
    ]


def _imports(tree: ast.AST, for_types: bool) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Imports below a node, and whether only a type checker comes there."""
    if isinstance(tree, ast.Import | ast.ImportFrom):
        yield tree, for_types
    elif isinstance(tree, ast.If) and "TYPE_CHECKING" in ast.unparse(tree.test):
        for node in tree.body:
            yield from _imports(node, True)
        for node in tree.orelse:
            yield from _imports(node, for_types)
    elif not isinstance(tree, ast.expr):
        for node in ast.iter_child_nodes(tree):
            yield from _imports(node, for_types)


def _absolute(module: str, node: ast.ImportFrom) -> str:
    """The module that is named after ``from``."""
    if not node.level:
        return node.module or ""
    parts = module.split(".")
    of_face = modules()[module].name == "__init__.py"
    parts = parts[: len(parts) - node.level + of_face]
    return ".".join([*parts, *([node.module] if node.module else [])])


def _reached(module: str, graph: dict[str, set[str]]) -> set[str]:
    """Where the arrows lead from a module; itself only if they come back."""
    seen: set[str] = set()
    left = list(graph[module])
    while left:
        name = left.pop()
        if name not in seen:
            seen.add(name)
            left += graph[name]
    return seen
