"""Four numbers at once: vectors of the processor, for the compiled code of the structured solver.

``Lanes`` are four numbers that take ``+ - * /`` and comparisons like one. In memory the fields of
four blocks lie side by side, ``k[chunk, field, lane]``; `four` gives a chunk's fields as lanes and
`one` the fields of a single block as numbers, both by ``[field]``. LLVM makes of it whatever the
processor has. What happens in a lane depends on no other lane.
"""

import operator
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, models, register_model

LANES = 4
TABLE_WIDTH = 6
FLAGS = ("contract",)  # a product and a sum may become one instruction
VECTOR = ir.VectorType(ir.DoubleType(), LANES)


def _new_type(name: str, represented: ir.Type) -> Any:
    """Make a type of compiled code that LLVM holds as ``represented``."""
    cls = type(name, (types.Type,), {"__init__": lambda self: types.Type.__init__(self, name)})

    def layout(self: Any, manager: Any, kind: Any) -> None:
        models.PrimitiveModel.__init__(self, manager, kind, represented)

    register_model(cls)(type(name, (models.PrimitiveModel,), {"__init__": layout}))
    return cls()


lanes = _new_type("Lanes", VECTOR)
mask = _new_type("Mask", ir.VectorType(ir.IntType(1), LANES))
fields_of_four = _new_type("Four", ir.DoubleType().as_pointer())
fields_of_one = _new_type("One", ir.DoubleType().as_pointer())
table = _new_type("Table", ir.DoubleType().as_pointer())


@lower_cast(types.Float, type(lanes))
@lower_cast(types.Integer, type(lanes))
def _cast(context, builder, given, _, value):
    """Repeat a number in every lane."""
    value = context.cast(builder, value, given, types.float64)
    single = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, cgutils.int32_t(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(single, single, zeros)


def _define_operator(function, result, generate):
    """Let an operator take lanes and lanes, or lanes and a number."""

    @infer_global(function)
    class _(AbstractTemplate):
        def generic(self, args, kws):
            numbers = all(a == lanes or isinstance(a, types.Number) for a in args)
            if lanes in args and numbers:
                return signature(result, *[lanes] * len(args))
            return None

    given = [type(lanes)] * (1 if function is operator.neg else 2)
    lower_builtin(function, *given)(lambda context, builder, sig, args: generate(builder, *args))


for _name in ("add", "sub", "mul", "truediv"):
    _instruction = "fdiv" if _name == "truediv" else f"f{_name}"
    for _operator in (getattr(operator, _name), getattr(operator, f"i{_name}")):
        _define_operator(
            _operator,
            lanes,
            lambda builder, a, b, of=_instruction: getattr(builder, of)(a, b, flags=FLAGS),
        )
for _name, _sign in (("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">=")):
    _define_operator(
        getattr(operator, _name),
        mask,
        lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b),
    )
_define_operator(operator.neg, lanes, lambda builder, a: builder.fneg(a))


@infer_global(operator.and_)
class _And(AbstractTemplate):
    def generic(self, args, kws):
        return signature(mask, mask, mask) if args == (mask, mask) else None


@lower_builtin(operator.and_, type(mask), type(mask))
def _and(context, builder, sig, args):
    return builder.and_(*args)


PAIR = types.UniTuple(types.intp, 2)
ITEMS = {  # pointers: how they are indexed, and what is there
    fields_of_four: (types.intp, lanes),
    fields_of_one: (types.intp, types.float64),
    table: (PAIR, types.float64),
}


@infer_global(operator.getitem)
class _Get(AbstractTemplate):
    def generic(self, args, kws):
        if args[0] not in ITEMS:
            return None
        index, item = ITEMS[args[0]]
        return signature(item, args[0], index)


@infer_global(operator.setitem)
class _Set(AbstractTemplate):
    def generic(self, args, kws):
        if args[0] not in ITEMS:
            return None
        index, item = ITEMS[args[0]]
        return signature(types.void, args[0], index, item)


def _field(builder, pointer, index):
    return builder.gep(pointer, [builder.mul(index, cgutils.intp_t(LANES))], inbounds=True)


@lower_builtin(operator.getitem, type(fields_of_four), types.Integer)
def _get_four(context, builder, sig, args):
    place = builder.bitcast(_field(builder, *args), VECTOR.as_pointer())
    return builder.load(place, align=8)


@lower_builtin(operator.setitem, type(fields_of_four), types.Integer, type(lanes))
def _set_four(context, builder, sig, args):
    place = builder.bitcast(_field(builder, *args[:2]), VECTOR.as_pointer())
    builder.store(args[2], place, align=8)


@lower_builtin(operator.getitem, type(fields_of_one), types.Integer)
def _get_one(context, builder, sig, args):
    return builder.load(_field(builder, *args))


@lower_builtin(operator.setitem, type(fields_of_one), types.Integer, types.Float)
def _set_one(context, builder, sig, args):
    builder.store(args[2], _field(builder, *args[:2]))


def _place(builder, pointer, indices):
    row, column = (builder.extract_value(indices, i) for i in range(2))
    row = builder.mul(row, cgutils.intp_t(TABLE_WIDTH))
    return builder.gep(pointer, [builder.add(row, column)], inbounds=True)


@lower_builtin(operator.getitem, type(table), types.UniTuple)
def _get_of_table(context, builder, sig, args):
    return builder.load(_place(builder, *args))


@lower_builtin(operator.setitem, type(table), types.UniTuple, types.Float)
def _set_in_table(context, builder, sig, args):
    builder.store(args[2], _place(builder, *args[:2]))


def _at(kind):
    """Intrinsic function that takes an address for a pointer of this type."""

    @intrinsic
    def at(typing_context, address):
        def generate(context, builder, sig, args):
            return builder.inttoptr(args[0], ir.DoubleType().as_pointer())

        return kind(types.intp), generate

    return at


four_at, table_at = _at(fields_of_four), _at(table)
"""Take an address for that of a chunk's fields, or of a table's numbers."""


@intrinsic
def lane(typing_context, fields, which):
    """Fields of one of four blocks, each as a number."""

    def generate(context, builder, sig, args):
        return builder.gep(args[0], [args[1]], inbounds=True)

    return fields_of_one(fields_of_four, types.intp), generate


@intrinsic
def after(typing_context, fields, count):
    """Fields from number ``count`` on."""

    def generate(context, builder, sig, args):
        return _field(builder, *args)

    return fields(fields, types.intp), generate


@intrinsic
def splat(typing_context, number):
    """Take a number four times."""
    return lanes(lanes), lambda context, builder, sig, args: args[0]


@intrinsic
def where(typing_context, condition, yes, no):
    """Take ``yes`` in the lanes that meet the condition, ``no`` in the others."""

    def generate(context, builder, sig, args):
        return builder.select(*args)

    return lanes(mask, lanes, lanes), generate


def _of_llvm(name):
    """Code that calls an intrinsic function of LLVM."""

    def generate(context, builder, sig, args):
        kind = ir.FunctionType(VECTOR, [VECTOR])
        name_of_lanes = f"llvm.{name}.v{LANES}f64"
        return builder.call(
            cgutils.get_or_insert_function(builder.module, kind, name_of_lanes), args
        )

    return generate


@intrinsic
def larger(typing_context, a, b):
    """The larger of two, lane by lane; b where one is not a number."""

    def generate(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return lanes(lanes, lanes), generate


@intrinsic
def smaller(typing_context, a, b):
    """The smaller of two, lane by lane; b where one is not a number."""

    def generate(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return lanes(lanes, lanes), generate


@intrinsic
def root(typing_context, x):
    """Square root of every lane."""

    return lanes(lanes), _of_llvm("sqrt")


@intrinsic
def size(typing_context, x):
    """Absolute value of every lane."""

    return lanes(lanes), _of_llvm("fabs")


@intrinsic
def some(typing_context, condition):
    """Whether any lane meets the condition."""

    def generate(context, builder, sig, args):
        bits = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(mask), generate


@intrinsic
def element(typing_context, x, which):
    """One lane as a number."""

    def generate(context, builder, sig, args):
        return builder.extract_element(*args)

    return types.float64(lanes, types.intp), generate


@njit(error_model="numpy", forceinline=True)
def total(x):
    """Sum of the lanes."""
    return (element(x, 0) + element(x, 2)) + (element(x, 1) + element(x, 3))


@njit(error_model="numpy", forceinline=True)
def largest(x):
    """Largest of the lanes."""
    return max(max(element(x, 0), element(x, 2)), max(element(x, 1), element(x, 3)))


@njit(error_model="numpy", forceinline=True)
def smallest(x):
    """Smallest of the lanes."""
    return min(min(element(x, 0), element(x, 2)), min(element(x, 1), element(x, 3)))
