"""Dropped statements: calls, assignments into what has a value, early ends of loops, functions."""

import ast
from collections.abc import Iterator

from benchmarks.mutants.operators import Edit
from benchmarks.mutants.source import Source

Function = ast.FunctionDef | ast.AsyncFunctionDef


def dropped(source: Source, node: ast.stmt, function: Function | None) -> Iterator[Edit]:
    """The statement left out, where what follows can still run."""
    if _can_go(node, function):
        yield "dropped", *source.span(node), "pass"


def _can_go(node: ast.stmt, function: Function | None) -> bool:
    match node:
        case ast.Expr(value=ast.Call()):
            return True
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            return function is not None and function.name != "__init__"
        case ast.Assign(targets=[ast.Name(id=name)]) if function is not None:
            return _has_value(name, node, function)
        case ast.AugAssign() | ast.Continue():
            return True
        case ast.Break() if function is not None:
            loops = [each for each in ast.walk(function) if isinstance(each, ast.While)]
            return not any(isinstance(loop.test, ast.Constant) for loop in loops)
        case ast.Return() if function is not None:
            return node is not function.body[-1] and _is_early(node, function)
        case _:
            return False


def _has_value(name: str, node: ast.stmt, function: Function) -> bool:
    """Whether a local name is a parameter or is assigned above the statement."""
    arguments = function.args
    named = {each.arg for each in (*arguments.args, *arguments.kwonlyargs, *arguments.posonlyargs)}
    above = {
        each.id
        for each in ast.walk(function)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        if each.lineno < node.lineno
    }
    return name in named | above


def _is_early(node: ast.Return, function: Function) -> bool:
    """Whether the function goes on below the statement's branch."""
    last = function.body[-1]
    return node.lineno < last.lineno
