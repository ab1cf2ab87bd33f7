"""Where a file can be changed, and what is left out because no change there is one of behaviour.

Left out are docstrings, annotations, type aliases, imports, decorators, code for type checkers,
``__all__``, messages of errors and warnings, assertions, formatted text, and words that describe.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace

from benchmarks.mutants.operators import edits
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.statements import Function, dropped

DESCRIBING = {"describe", "description", "encoding", "help", "stacklevel", "strict", "title"}
GENERIC = {"dict", "frozenset", "list", "set", "tuple", "type"}


@dataclass(frozen=True)
class Where:
    """What surrounds a node."""

    owner: str = ""
    function: Function | None = None
    role: str = ""


def places(source: Source) -> list[list[Change]]:
    """For each place that can be changed, the changes of it."""
    return [
        changes
        for node, where in _nodes(source.tree, Where())
        if (changes := _changes(source, node, where))
    ]


def _changes(source: Source, node: ast.AST, where: Where) -> list[Change]:
    found = list(edits(source, node, where.role))
    if isinstance(node, ast.stmt):
        found += dropped(source, node, where.function)
    return [
        Change(
            file=source.file,
            line=source.line(start),
            start=start,
            end=end,
            new=new,
            operator=operator,
            owner=where.owner,
            at_import=where.function is None,
        )
        for operator, start, end, new in found
    ]


def is_another_program(source: Source, change: Change) -> bool:
    """Whether the changed text can be read, and says something else."""
    try:
        changed = ast.parse(change.applied(source.text))
    except SyntaxError:
        return False
    return ast.dump(changed) != ast.dump(source.tree)


def _nodes(node: ast.AST, where: Where) -> Iterator[tuple[ast.AST, Where]]:
    """Nodes that can be changed, with what surrounds them, from the top of the file down."""
    if _is_left_out(node):
        return
    yield node, where
    match node:
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant()):
            return
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            yield from _function(node, where)
        case ast.ClassDef():
            for each in node.body:
                yield from _nodes(each, replace(where, owner=where.owner or node.name))
        case ast.AnnAssign() if node.value is not None:
            owner = where.owner or _name(node.target)
            yield from _nodes(node.value, replace(where, owner=owner, role="default"))
        case ast.Assign():
            for each in (*node.targets, node.value):
                owner = where.owner or _name(node.targets[0])
                yield from _nodes(each, replace(where, owner=owner, role=""))
        case ast.Compare():
            for each in ast.iter_child_nodes(node):
                yield from _nodes(each, replace(where, role="compared"))
        case ast.Subscript():
            yield from _nodes(node.value, replace(where, role=""))
            if not _is_type(node.value):
                yield from _nodes(node.slice, replace(where, role="index"))
        case ast.Call():
            yield from _call(node, where)
        case ast.Slice() | ast.Tuple() if where.role == "index":
            for each in ast.iter_child_nodes(node):
                yield from _nodes(each, where)
        case _:
            for each in ast.iter_child_nodes(node):
                yield from _nodes(each, replace(where, role=""))


def _function(node: Function, where: Where) -> Iterator[tuple[ast.AST, Where]]:
    inside = replace(where, owner=where.owner or node.name)
    for default in filter(None, (*node.args.defaults, *node.args.kw_defaults)):
        yield from _nodes(default, replace(inside, role="default"))
    for each in node.body:
        yield from _nodes(each, replace(inside, function=node, role=""))


def _call(node: ast.Call, where: Where) -> Iterator[tuple[ast.AST, Where]]:
    yield from _nodes(node.func, replace(where, role=""))
    role = "shape" if _name(node.func) == "reshape" else ""
    for each in node.args:
        yield from _nodes(each, replace(where, role=role))
    for keyword in node.keywords:
        if keyword.arg not in DESCRIBING:
            role = "axis" if keyword.arg == "axis" else ""
            yield from _nodes(keyword.value, replace(where, role=role))


def _is_left_out(node: ast.AST) -> bool:
    match node:
        case ast.Import() | ast.ImportFrom() | ast.Assert() | ast.Raise() | ast.JoinedStr():
            return True
        case ast.If(test=test):
            return "TYPE_CHECKING" in ast.unparse(test) or "__name__" in ast.unparse(test)
        case ast.Assign(targets=[ast.Name(id="__all__")]):
            return True
        case ast.Call(func=function):
            return _is_message(function)
        case ast.Expr(value=ast.Constant()):
            return True
        case ast.BinOp(op=ast.BitOr()):  # a union of types
            return any(_is_type(side) for side in (node.left, node.right))
        case _:
            return False


def _is_message(function: ast.expr) -> bool:
    """Whether a call makes an error or tells one."""
    name = _name(function)
    ends = ("Error", "Exception", "Warning", "Input", "UnknownName", "MissingExtra", "ResetNeeded")
    return name.endswith(ends) or name in ("warn", "warning", "TypeVar", "NewType")


def _is_type(node: ast.expr) -> bool:
    """Whether a name is that of a type, as in ``Literal[...]`` or ``dict[...]``."""
    name = _name(node)
    return name in GENERIC or (name[:1].isupper() and not name.isupper())


def _name(node: ast.AST) -> str:
    if isinstance(node, ast.Name):
        return node.id
    return node.attr if isinstance(node, ast.Attribute) else ""
