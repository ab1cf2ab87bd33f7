"""Memory of lanes: typed pointers for compiled code, without reference counts.

The fields of four blocks lie side by side in memory, field after field. ``Four`` points to them,
and ``[field]`` gives one as lanes (`lanes`). ``One`` points to the fields of a single block, and
``[field]`` gives a number. ``Table`` points to rows of six numbers, ``[row, column]``. There are
also arrays. Numba counts references to none of them, which would cost time, and checks no index
against any end: whoever made the memory must keep it alive.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, signature
from numba.extending import lower_builtin
from numba.np.numpy_support import carray

from coopenv.compiled import fused, in_llvm
from coopenv.compiled.lanes.vectors import (
    LANES,
    VECTOR,
    declared,
    lanes,
    new_type,
)

TABLE_WIDTH = 6
POINTER = ir.DoubleType().as_pointer()

fields_of_four = new_type("Four", POINTER)
fields_of_one = new_type("One", POINTER)
table = new_type("Table", POINTER)

ITEMS = {  # how they are indexed, and what is there
    fields_of_four: (types.intp, lanes),
    fields_of_one: (types.intp, types.float64),
    table: (types.UniTuple(types.intp, 2), types.float64),
}


@declared(operator.getitem)
class _Get(AbstractTemplate):
    def generic(self, args, kws):
        if args[0] not in ITEMS:
            return None
        index, item = ITEMS[args[0]]
        return signature(item, args[0], index)


@declared(operator.setitem)
class _Set(AbstractTemplate):
    def generic(self, args, kws):
        if args[0] not in ITEMS:
            return None
        index, item = ITEMS[args[0]]
        return signature(types.void, args[0], index, item)


def _field(builder: Any, pointer: Any, index: Any) -> Any:
    return builder.gep(pointer, [builder.mul(index, cgutils.intp_t(LANES))], inbounds=True)


def _fields(builder: Any, pointer: Any, index: Any) -> Any:
    return builder.bitcast(_field(builder, pointer, index), VECTOR.as_pointer())


def _cell(builder: Any, pointer: Any, indices: Any) -> Any:
    row, column = (builder.extract_value(indices, i) for i in range(2))
    offset = builder.add(builder.mul(row, cgutils.intp_t(TABLE_WIDTH)), column)
    return builder.gep(pointer, [offset], inbounds=True)


def _define_items(pointer: Any, index: Any, item: Any, place: Any) -> None:
    """Let ``pointer[index]`` be read and written at the place that is computed."""

    @lower_builtin(operator.getitem, type(pointer), index)
    def _(context, builder, sig, args):
        return builder.load(place(builder, *args), align=8)

    @lower_builtin(operator.setitem, type(pointer), index, item)
    def _(context, builder, sig, args):
        builder.store(args[2], place(builder, *args[:2]), align=8)


_define_items(fields_of_four, types.Integer, type(lanes), _fields)
_define_items(fields_of_one, types.Integer, types.Float, _field)
_define_items(table, types.UniTuple, types.Float, _cell)


def _to_pointer(context, builder, sig, args):
    return builder.inttoptr(args[0], POINTER)


@in_llvm
def four_at(typing_context, address):
    """Take an address for that of the fields of four blocks."""
    return fields_of_four(types.intp), _to_pointer


@in_llvm
def table_at(typing_context, address):
    """Take an address for that of a table."""
    return table(types.intp), _to_pointer


@in_llvm
def lane(typing_context, four, which):
    """Fields of one of the four blocks."""

    def generate(context, builder, sig, args):
        return builder.gep(args[0], [args[1]], inbounds=True)

    return fields_of_one(fields_of_four, types.intp), generate


@in_llvm
def after(typing_context, four, count):
    """Fields from number ``count`` on."""

    def generate(context, builder, sig, args):
        return _field(builder, *args)

    return fields_of_four(fields_of_four, types.intp), generate


@fused
def array_at(address, shape):
    """Take an address for that of an array of such a shape."""
    return carray(_pointer_at(address), shape, np.float64)


@in_llvm
def _pointer_at(typing_context, address):
    """Take an address for a pointer to anything."""

    def generate(context, builder, sig, args):
        return builder.inttoptr(args[0], cgutils.voidptr_t)

    return types.voidptr(address), generate
