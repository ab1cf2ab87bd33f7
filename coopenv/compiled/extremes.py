"""The lower or higher of two numbers in compiled code, by the instructions that numba has for it.

Numba compiles `min` and `max` to functions of their own for every pair of types, in all of its
steps down to machine code, and calls them wherever they are written.
"""

import operator
from collections.abc import Iterator
from typing import Any

from numba import types
from numba.core import ir
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.cpython.builtins import do_minmax
from numba.extending import intrinsic


def _of_two(builtin: Any, compare: Any) -> Any:
    """What builds the instructions; ``compare`` says whether the second of two numbers is taken.

    Of anything else than numbers it is what numba makes of the builtin.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return do_minmax(context, builder, signature.args, values, compare)

    def taken(typingctx: Any, one: Any, other: Any) -> Any:
        plain = types.unliteral(one), types.unliteral(other)
        if all(isinstance(kind, types.Number | types.Boolean) for kind in plain):
            unified = typingctx.unify_types(*plain)
            if unified is not None:
                return unified(*plain), generate
        made = typingctx.resolve_value_type(builtin).get_call_type(typingctx, plain, {})
        return made.return_type(*plain), as_numba

    def as_numba(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.compile_internal(builder, lambda a, b: builtin(a, b), signature, values)

    taken.__name__ = builtin.__name__  # in messages
    return intrinsic(taken)


_TAKEN = {min: _of_two(min, operator.lt), max: _of_two(max, operator.gt)}


@register_pass(mutates_CFG=False, analysis_only=False)
class Extremes(FunctionPass):
    """Has `min` and `max` of two numbers built where they stand."""

    _name = "extremes_of_two"

    def __init__(self):
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        """Whether anything has changed."""
        changed = False
        for called in _called(state.func_ir):
            called.value = _TAKEN[called.value]
            changed = True
        return changed


def _called(func_ir: Any) -> Iterator[Any]:
    """The builtins that a function calls with two arguments, and uses in no other way."""
    names: dict[str, Any] = {}
    for block in func_ir.blocks.values():
        for one in block.find_insts(ir.Assign):
            named = isinstance(one.value, ir.Global | ir.FreeVar)
            if named and any(one.value.value is known for known in _TAKEN):
                names[one.target.name] = one.value
    for block in func_ir.blocks.values():
        for one in block.body:
            value: Any = getattr(one, "value", None)
            is_call = isinstance(value, ir.Expr) and value.op == "call"
            if is_call and len(value.args) == 2 and not (value.kws or value.vararg):
                used = value.args
            elif isinstance(value, ir.Global | ir.FreeVar):
                continue
            else:
                used = one.list_vars()
            for variable in used:
                names.pop(variable.name, None)
    yield from names.values()
