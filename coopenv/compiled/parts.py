"""Parts of kernels: functions that compiled code calls, made machine code with their callers alone.

Numba optimises a function and makes machine code of it before it is put into the kernel that calls
it, where it is optimised again: with six levels of calls, seven times. Here it is translated for
LLVM once, and optimised as part of each kernel that Python calls. That takes two thirds of the
time.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from llvmlite.binding import Linkage
from numba import njit, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Flags

from coopenv.compiled.pipeline import Lean


class _Codegen:
    """Numba's generator of code, for what is no code yet."""

    def __init__(self, codegen: Any):
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Leave it to the kernel that the part goes into."""


class _Part(JITCodeLibrary):
    """A library that is linked into others as it is."""

    @property
    def codegen(self) -> Any:
        return _Codegen(self._codegen)

    def finalize(self) -> None:
        self._raise_if_finalized()
        for library in self._linking_libraries if hasattr(self, "_reload_init") else ():
            self._reload_init.update(library._reload_init)  # not in the oldest numba
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    def _get_module_for_linking(self) -> Any:
        """Own code, and that of all parts that it calls."""
        module = self._own_module().clone()
        for library in self._reached():
            own = isinstance(library, _Part)
            code = library._own_module() if own else library._get_module_for_linking()
            module.link_in(code, preserve=True)
        return module

    def _own_module(self) -> Any:
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == Linkage.external:
                    function.linkage = Linkage.linkonce_odr
            self._shared_module = self._final_module
        return self._shared_module

    def _reached(self) -> list[Any]:
        """Libraries that it calls, directly or through parts."""
        found: dict[Any, None] = {}
        waiting = [*self._linking_libraries]
        while waiting:
            library = waiting.pop()
            if library not in found and library is not self:
                found[library] = None
                waiting += library._linking_libraries if isinstance(library, _Part) else ()
        return list(found)


class _Kept(Flags):
    """Flags that are never changed, of which there is one object for all that are equal.

    Numba looks up what it compiled of its own functions by the flags of their caller, each time
    that one is called. To compare and hash them costs more than all else of the look-up.
    """

    __slots__ = ("_hash",)

    def __init__(self, copy_from: Flags):
        super().__init__(copy_from)
        self._hash = super().__hash__()

    def __hash__(self) -> int:
        return self._hash

    def copy(self) -> Flags:
        """A copy that may be changed."""
        return Flags(self)


_all_kept: dict[_Kept, _Kept] = {}


class _Flags(Flags):
    """Flags of a part; numba gives a copy of them to all that it compiles for the part."""

    __slots__ = ("_copy",)

    def __init__(self, copy_from: Flags):
        super().__init__(copy_from)
        self._copy: _Kept | None = None

    def copy(self) -> _Kept:
        """As they are now, to be kept."""
        last = self._copy
        if last is None or last._values != self._values:
            kept = _Kept(self)
            last = self._copy = _all_kept.setdefault(kept, kept)
        return last


class _Pipeline(Lean):
    def compile_extra(self, func: Any) -> Any:
        self.state.flags = _Flags(self.state.flags)
        return super().compile_extra(func)

    def define_pipelines(self) -> Any:
        if self.state.library is None:
            codegen = self.state.targetctx.codegen()
            self.state.library = _Part(codegen, self.state.func_id.func_qualname)
        return super().define_pipelines()


def part(function: Callable[..., Any], **options: Any) -> Any:
    """Compile a function into each kernel that calls it; Python cannot call it."""
    alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _Pipeline}
    made: Any = njit(**options, **alone)(function)
    template = made.get_call_template
    answers: dict[Any, Any] = {}

    def once_for_all_numbers(args: Any, keywords: Any) -> Any:
        """Numba would compile a function for every number that it is called with."""
        plain = {name: types.unliteral(kind) for name, kind in keywords.items()}
        key = tuple(map(types.unliteral, args)), tuple(plain.items())
        if key not in answers:
            answers[key] = template(key[0], plain)
        return answers[key]

    made.get_call_template = once_for_all_numbers
    return made


def also_part(kernel: Any, **options: Any) -> Any:
    """Let other kernels call a kernel as a part."""

    @cache
    def own() -> Any:
        return part(kernel.py_func, **options)

    kernel.get_call_template = lambda args, keywords: own().get_call_template(args, keywords)
    kernel.get_overload = lambda signature: own().get_overload(signature)
    kernel.get_compile_result = lambda signature: own().get_compile_result(signature)
    return kernel
