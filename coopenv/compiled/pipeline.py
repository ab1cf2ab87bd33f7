"""What compiles all functions of ours: numba's pipeline, less what they do not need.

Two of its passes take a twelfth of the time and only ever change code that a kernel hardly has:
functions within functions, and sums or products of whole arrays.
"""

from types import CodeType
from typing import Any

from numba import types
from numba.core import ir
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes, IRProcessing

from coopenv.compiled.borrowing import Lowering
from coopenv.compiled.extremes import Extremes

_OF_ARRAYS = ("binop", "inplace_binop", "unary", "call")  # what array expressions are made of


@register_pass(mutates_CFG=True, analysis_only=False)
class _ArrayRewrites(NopythonRewrites):
    """Numba's rewriting of array expressions, where there are some."""

    _name = "rewrites_of_arrays"

    def run_pass(self, state: Any) -> Any:
        """Whether anything has changed."""
        return any(map(_made(state), state.func_ir.blocks.values())) and super().run_pass(state)


def _made(state: Any) -> Any:
    """What tells whether a block makes an array."""

    def makes_array(block: Any) -> bool:
        return any(
            isinstance(one.value, ir.Expr)
            and one.value.op in _OF_ARRAYS
            and isinstance(state.typemap[one.target.name], types.Array)
            for one in block.find_insts(ir.Assign)
        )

    return makes_array


_OURS: dict[Any, Any] = {NopythonRewrites: _ArrayRewrites, NativeLowering: Lowering}


class Lean(Compiler):
    """Numba's compiler with what is said above."""

    def define_pipelines(self) -> Any:
        """As numba does it."""
        pipelines = super().define_pipelines()
        for one in pipelines:
            passes = [
                (_OURS.get(kind, kind), name)
                for kind, name in one.passes
                if kind is not InlineClosureLikes or _has_functions(self.state.func_id.code)
            ]
            places = [at for at, (kind, _) in enumerate(passes) if kind is IRProcessing]
            for at in places:
                passes.insert(at + 1, (Extremes, "extremes of two numbers"))
            one.passes = passes
            one.finalize()
        return pipelines


def _has_functions(code: CodeType) -> bool:
    return any(isinstance(constant, CodeType) for constant in code.co_consts)
