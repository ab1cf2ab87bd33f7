"""Counting of references in compiled code, only where there is something to count.

Numba counts a reference up where a variable gets a value and down where its last use lies behind
it, whatever the value is: for numbers too it goes through all that their type is made of, finds no
memory that is shared, reads what the variable held before to drop it, and sets it to zero so that
nothing is dropped twice. Of an array it takes apart shape and strides, for the one member that is
counted. Nineteen of twenty variables of kernels are numbers or tuples of them.

A function that only borrows counts nothing: its arrays are its arguments', and views of them, which
live as long as its caller holds them, and that is longer than the call. Counting up and down within
it comes to nothing, and LLVM needs time to find that out. Where anything is done of which that is
not known, numba counts all.
"""

import math
from functools import cache, cached_property
from typing import Any

import numpy as np
from numba.core import ir, types
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.runtime.context import NRTContext
from numba.core.typed_passes import NativeLowering

from coopenv.compiled.dependencies import ANYWHERE


@cache
def _is_counted(models: Any, kind: Any) -> bool:
    """Whether a value of a type has memory that is shared, or a member that has."""
    model = models[kind]
    if model.has_nrt_meminfo():
        return True
    return any(_is_counted(models, member) for member, _ in model.traverse(None))


class _Counting(NRTContext):
    """What numba counts references with; it takes values apart only where there is one."""

    def __init__(self, context: Any, lower: Any):
        super().__init__(context, context.enable_nrt)
        self._lower = lower

    @cached_property
    def _borrows(self) -> bool:
        kinds, models = self._lower.fndesc.typemap, self._context.data_model_manager
        return _Known(kinds, models).borrows(self._lower.func_ir)

    def get_meminfos(self, builder: Any, ty: Any, val: Any) -> list[Any]:
        """As numba finds them, a type and an address for each; none in a function that borrows."""
        models: Any = self._context.data_model_manager
        if not _is_counted(models, ty):
            return []
        if self._borrows and builder.function is self._lower.function:  # none that it is made of
            return []
        model = models[ty]
        found = [(ty, model.get_nrt_meminfo(builder, val))] if model.has_nrt_meminfo() else []
        for member, getter in model.traverse(builder):
            if _is_counted(models, member):
                found += self.get_meminfos(builder, member, getter(val))
        return found


class _Known:
    """What is known to neither make a reference nor keep one, by the types in a function."""

    def __init__(self, kinds: Any, models: Any):
        self._kinds, self._models = kinds, models

    def borrows(self, func_ir: Any) -> bool:
        """Whether all that a function holds is its caller's, for as long as the call takes."""
        blocks = func_ir.blocks.values()
        return func_ir.generator_info is None and all(
            self._is_known(one) for block in blocks for one in block.body
        )

    def _is_known(self, one: Any) -> bool:
        if isinstance(one, ir.Assign):
            made = one.value
            named = isinstance(made, ir.Arg | ir.Var | ir.Const | ir.Global | ir.FreeVar)
            return self._is_plain(one.target) and (named or self._makes_none(made, one.target))
        if isinstance(one, ir.SetItem | ir.StaticSetItem):  # rows would be copied if they overlap
            return self._is_free(one.value) and self._is_part(one.target, one, one.value)
        if isinstance(one, ir.Return):  # of what is returned a caller gets a reference of its own
            return self._is_free(one.value)
        return isinstance(one, ir.Del | ir.Branch | ir.Jump | ir.PopBlock | ir.StaticRaise)

    def _makes_none(self, made: Any, target: Any) -> bool:
        """Whether an expression gives numbers, or what is held already."""
        op = getattr(made, "op", None)
        if op == "call":
            return self._is_known_call(made, target)
        if op in ("static_getitem", "getitem"):
            return self._is_part(made.value, made, target)
        if op == "getattr":
            kind = self._kinds[made.value.name]
            held = isinstance(kind, types.Array) or self._is_free(made.value)
            return isinstance(kind, types.BaseNamedTuple) or (held and self._is_free(target))
        if op == "exhaust_iter":
            return isinstance(self._kinds[made.value.name], types.BaseTuple)
        if op in ("build_tuple", "cast"):
            return True
        return op in _OF_NUMBERS and all(map(self._is_free, (target, *made.list_vars())))

    def _is_known_call(self, made: Any, target: Any) -> bool:
        called = self._kinds[made.func.name]
        if isinstance(called, types.NamedTupleClass):
            return True
        if not self._is_free(target):
            return False
        if type(called) is types.Dispatcher:  # it counts for itself, or borrows in turn
            return True
        if isinstance(called, types.Function) and called.typing_key is len:
            return True
        listed = isinstance(called, types.NumberClass) or (
            isinstance(called, types.Function) and _is_of_numbers(called.typing_key)
        )
        return listed and all(map(self._is_free, made.list_vars()))

    def _is_part(self, whole: Any, one: Any, part: Any) -> bool:
        """Whether what an index gives is no copy."""
        kind = self._kinds[whole.name]
        if isinstance(kind, types.Array):
            at = one.index if isinstance(one.index, ir.Var) else one.index_var
            return at is not None and _is_basic(self._kinds[at.name])
        return isinstance(kind, types.BaseTuple) or (self._is_free(whole) and self._is_free(part))

    def _is_free(self, variable: Any) -> bool:
        return not _is_counted(self._models, self._kinds[variable.name])

    def _is_plain(self, variable: Any) -> bool:
        return self._is_free(variable) or _is_plain(self._models, self._kinds[variable.name])


def _is_plain(models: Any, kind: Any) -> bool:
    """Whether a type is an array of numbers, or a tuple with some."""
    if isinstance(kind, types.Array):
        return isinstance(kind.dtype, types.Number | types.Boolean)
    if not isinstance(kind, types.BaseTuple):
        return False
    members: Any = kind
    return all(not _is_counted(models, one) or _is_plain(models, one) for one in members)


def _is_basic(kind: Any) -> bool:
    """Whether an index of a type gives a number or a view; others copy."""
    if isinstance(kind, types.BaseTuple):
        indices: Any = kind
        return all(map(_is_basic, indices))
    return isinstance(kind, types.Integer | types.SliceType | types.EllipsisType | types.NoneType)


def _is_of_numbers(function: Any) -> bool:
    """Whether compiled code of a function, called with numbers, has nothing but numbers."""
    known = function in _BUILTIN or isinstance(function, np.ufunc) or function in ANYWHERE
    place = getattr(getattr(function, "_defn", None), "__module__", "")  # of what is `in_llvm`
    return known or place.startswith("coopenv.") or function in vars(math).values()


_OF_NUMBERS = frozenset(
    ("binop", "inplace_binop", "unary", "getiter", "iternext", "pair_first", "pair_second")
)
_BUILTIN = frozenset((abs, bool, float, int, max, min, range, round, slice))


class _Lower(Lower):
    """Numba's translation to LLVM; what holds no reference is neither dropped nor reset."""

    def init(self) -> None:
        super().init()
        if self.context.enable_nrt:
            self.context.nrt = _Counting(self.context, self)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        """As numba does it, which reads what the variable held before."""
        alone = getattr(self, "_singly_assigned_vars", (name,))  # these have no place in memory
        if argidx is not None or name in alone or self._is_counted(name):
            super().storevar(value, name, argidx)
        else:
            self.builder.store(value, self.getvar(name))

    def delvar(self, name: str) -> None:
        """As numba does it."""
        if self._is_counted(name):
            super().delvar(name)

    def _is_counted(self, name: str) -> bool:
        return _is_counted(self.context.data_model_manager, self.typeof(name))


@register_pass(mutates_CFG=True, analysis_only=False)
class Lowering(NativeLowering):
    """Numba's pass of that translation, for functions of ours."""

    _name = "lowering_that_borrows"

    @property
    def lowering_class(self) -> Any:
        """What translates."""
        return _Lower
