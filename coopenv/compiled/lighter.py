"""What numba does over and over while it compiles a kernel, done in less time.

It goes through all instructions of a function six times for the variables in them, has LLVM read a
module for the size of every type that it meets, and tells of every call of LLVM, to nobody. After
each pass it finds out which variables live in which block; only interpreted code (numba's
``objmode``) asks for that. What numba looks for though it does not change is in
`coopenv.compiled.remembered`.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import Any

from llvmlite import binding
from llvmlite import ir as llvm
from numba.core import analysis, base, errors, ir, lowering, postproc, transforms, typeinfer, utils
from numba.core.types import functions
from numba.core.typing import context as typing

from coopenv.compiled.operators import remembering
from coopenv.compiled.remembered import ordering, refreshing, signatures

_errors: Any = errors  # of which not all is public
_utils: Any = utils
_NO_VARIABLES = frozenset((str, int, float, bool, type(None), ir.Loc))
_sizes: dict[Any, int] = {}


@contextmanager
def lighter() -> Iterator[None]:
    """For whoever holds numba's lock of compilation, until this ends."""
    with ExitStack() as changed:
        for owner, name, value in _LIGHTER:
            changed.enter_context(_replaced(owner, name, value))
        yield


@contextmanager
def _replaced(owner: Any, name: str, value: Any) -> Iterator[None]:
    """Nothing is replaced in a numba that has no such thing."""
    if not hasattr(owner, name):
        yield
        return
    before = getattr(owner, name)
    setattr(owner, name, value)
    try:
        yield
    finally:
        setattr(owner, name, before)


def _variables(instruction: Any, value: Any) -> list[Any]:
    """The variables in what an instruction holds, as numba finds them."""
    if type(value) in _NO_VARIABLES:
        return []
    if isinstance(value, ir.Var):
        return [value]
    if isinstance(value, ir.Inst):
        return value.list_vars()
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, list | tuple):
        return []
    found = []
    for one in value:
        if type(one) not in _NO_VARIABLES:
            found += _variables(instruction, one)
    return found


_size_of: Any = getattr(llvm.Type, "get_abi_size", None)


def _size(kind: Any, target_data: Any, context: Any = None) -> int:
    """Bytes of a type; LLVM is asked once for each that is written alike."""
    key = str(kind), target_data, context
    if key not in _sizes:
        _sizes[key] = _size_of(kind, target_data, context)
    return _sizes[key]


class _Told:
    """What an error is told of where it comes from, as numba has it by a generator."""

    __slots__ = ("_given", "_keywords", "_text")

    def __init__(self, fmt_: str, *args: Any, **kwargs: Any):
        self._text, self._given, self._keywords = fmt_, args, kwargs

    def __enter__(self) -> None:
        loc = self._keywords.get("loc")
        if loc is not None and not loc.filename.startswith(_errors._numba_path):
            _errors.loc_info.update(self._keywords)

    def __exit__(
        self, kind: type | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if isinstance(error, errors.NumbaError):
            plain = not self._given and not self._keywords
            told = self._text if plain else self._text.format(*self._given, **self._keywords)
            error.add_context(told)


def _process(processor: Any, emit_dels: bool = False, **others: Any) -> None:
    """Numba's look at a function between passes, without what `_entry_variables` finds if asked."""
    function = processor.func_ir
    if function.is_generator:
        _process_all(processor, emit_dels, **others)
        return
    function.blocks = transforms.canonicalize_cfg(function.blocks)
    function.variable_lifetime = postproc.VariableLifetime(function.blocks)
    function.generator_info = None
    if emit_dels:
        processor._insert_var_dels(**others)


def _entry_variables(function: Any, block: Any) -> Any:
    """The variables that live where a block begins, found for all when first asked for."""
    known = function.block_entry_vars
    if block not in known:
        life, blocks = function.variable_lifetime, function.blocks
        alive = analysis.compute_live_variables(
            life.cfg, blocks, life.usedefs.defmap, life.deadmaps.combined
        )
        known.update({blocks[at]: names for at, names in alive.items()})
    return known[block]


_process_all: Any = postproc.PostProcessor.run
_order: Any = ordering(utils.order_by_target_specificity)
_LIGHTER: tuple[tuple[Any, str, Any], ...] = (
    (ir.Inst, "_rec_list_vars", _variables),
    (llvm.Type, "get_abi_size", _size),
    (getattr(getattr(binding.ffi, "lib", None), "_lock", None), "_cblist", []),
    (errors, "new_error_context", _Told),
    (lowering, "new_error_context", _Told),
    (typeinfer, "new_error_context", _Told),
    (postproc.PostProcessor, "run", _process),
    (ir.FunctionIR, "get_block_entry_vars", _entry_variables),
    (base.BaseContext, "refresh", refreshing(base.BaseContext.refresh)),
    (typing.BaseContext, "refresh", refreshing(typing.BaseContext.refresh)),
    (functions.BaseFunction, "get_call_type", remembering(functions.BaseFunction.get_call_type)),
    (utils, "pysignature", signatures(_utils.pysignature)),
    (utils, "order_by_target_specificity", _order),
    (typing, "order_by_target_specificity", _order),
)
