"""Vectors of four numbers (SIMD) for compiled code.

``Lanes`` are four numbers that take ``+ - * /`` and comparisons like one, with each other or with
a number. What happens in a lane depends on no other lane. A comparison gives a ``Mask``. LLVM
compiles them to whatever instructions the processor has. `memory` says how they lie there.
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

from coopenv.compiled import fused_inlined, in_llvm
from coopenv.compiled.operators import Plain

LANES = 4
FLAGS = ("contract",)  # a product and a sum may become one instruction
VECTOR = ir.VectorType(ir.DoubleType(), LANES)
declared: Any = infer_global

NUMBER_AND_NUMBER = {"add": "fadd", "sub": "fsub", "mul": "fmul", "truediv": "fdiv"}
COMPARISONS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">="}


def new_type(name: str, represented: ir.Type) -> Any:
    """Make a type of compiled code that LLVM holds as ``represented``."""

    def begin(self: Any) -> None:
        types.Type.__init__(self, name)

    def layout(self: Any, manager: Any, kind: Any) -> None:
        models.PrimitiveModel.__init__(self, manager, kind, represented)

    kind: Any = type(name, (Plain,), {"__init__": begin})
    register_model(kind)(type(name, (models.PrimitiveModel,), {"__init__": layout}))
    return kind()


lanes = new_type("Lanes", VECTOR)
mask = new_type("Mask", ir.VectorType(ir.IntType(1), LANES))


@lower_cast(types.Float, type(lanes))
@lower_cast(types.Integer, type(lanes))
def _repeat(context, builder, given, _, value):
    """Take a number for four lanes."""
    value = context.cast(builder, value, given, types.float64)
    single = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, cgutils.int32_t(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(single, single, zeros)


def _define_operator(function: Callable[..., Any], result: Any, generate: Any, count: int) -> None:
    """Let an operator take ``count`` lanes, of which all but one may be numbers."""

    @declared(function)
    class _Operator(AbstractTemplate):
        def generic(self, args, kws):
            fits = all(a == lanes or isinstance(a, types.Number) for a in args)
            return signature(result, *[lanes] * count) if lanes in args and fits else None

    @lower_builtin(function, *[type(lanes)] * count)
    def _(context, builder, sig, args):
        return generate(builder, *args)


def _arithmetic(name: str) -> Any:
    return lambda builder, a, b: getattr(builder, name)(a, b, flags=FLAGS)


def _comparison(sign: str) -> Any:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


for _name, _instruction in NUMBER_AND_NUMBER.items():
    for _form in (_name, f"i{_name}"):
        _define_operator(getattr(operator, _form), lanes, _arithmetic(_instruction), 2)
for _name, _sign in COMPARISONS.items():
    _define_operator(getattr(operator, _name), mask, _comparison(_sign), 2)
_define_operator(operator.neg, lanes, lambda builder, a: builder.fneg(a), 1)


@declared(operator.and_)
class _And(AbstractTemplate):
    def generic(self, args, kws):
        return signature(mask, mask, mask) if args == (mask, mask) else None


@lower_builtin(operator.and_, type(mask), type(mask))
def _and(context, builder, sig, args):
    return builder.and_(*args)


@in_llvm
def splat(typing_context, number):
    """Take a number four times."""
    return lanes(lanes), lambda context, builder, sig, args: args[0]


@in_llvm
def where(typing_context, condition, yes, no):
    """Take ``yes`` in the lanes that meet the condition, ``no`` in the others."""
    return lanes(mask, lanes, lanes), lambda context, builder, sig, args: builder.select(*args)


def _chosen(sign: str) -> Any:
    """Code that takes the first of two where it compares so with the second."""

    def generate(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(sign, *args), *args)

    return generate


@in_llvm
def larger(typing_context, a, b):
    """The larger of two, lane by lane; b where one is not a number."""
    return lanes(lanes, lanes), _chosen(">")


@in_llvm
def smaller(typing_context, a, b):
    """The smaller of two, lane by lane; b where one is not a number."""
    return lanes(lanes, lanes), _chosen("<")


def _of_llvm(name: str) -> Any:
    """Code that calls an intrinsic function of LLVM."""

    def generate(context, builder, sig, args):
        kind, full_name = ir.FunctionType(VECTOR, [VECTOR]), f"llvm.{name}.v{LANES}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, full_name), args)

    return generate


@in_llvm
def root(typing_context, x):
    """Square root of every lane."""
    return lanes(lanes), _of_llvm("sqrt")


@in_llvm
def size(typing_context, x):
    """Absolute value of every lane."""
    return lanes(lanes), _of_llvm("fabs")


@in_llvm
def some(typing_context, condition):
    """Whether any lane meets the condition."""

    def generate(context, builder, sig, args):
        bits = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, bits.type(0))

    return types.boolean(mask), generate


@in_llvm
def element(typing_context, x, which):
    """One lane as a number."""

    def generate(context, builder, sig, args):
        return builder.extract_element(*args)

    return types.float64(lanes, types.intp), generate


@in_llvm
def together(typing_context, first, second, third, fourth):
    """Four numbers as lanes."""

    def generate(context, builder, sig, args):
        made = ir.Constant(VECTOR, ir.Undefined)
        for i, number in enumerate(args):
            made = builder.insert_element(made, number, cgutils.int32_t(i))
        return made

    return lanes(*[types.float64] * LANES), generate


@fused_inlined
def total(x):
    """Return the sum of the lanes."""
    return (element(x, 0) + element(x, 2)) + (element(x, 1) + element(x, 3))


@fused_inlined
def largest(x):
    """Return the largest of the lanes."""
    return max(max(element(x, 0), element(x, 2)), max(element(x, 1), element(x, 3)))


@fused_inlined
def smallest(x):
    """Return the smallest of the lanes."""
    return min(min(element(x, 0), element(x, 2)), min(element(x, 1), element(x, 3)))
