"""Compilation with numba: one spelling for each kind, and a cache that knows what a kernel uses.

``@compiled``
    Called from Python or from other kernels; cached on disk.
``@inlined``
    Always put into the kernel that calls it, where a call would cost more than the work.
``@anywhere``
    The same arithmetic for all: Python calls it as it is, with numbers or arrays of any shape, and
    a kernel that calls it has it compiled in.
``@in_llvm``
    Called from kernels only; its body says what instructions it becomes.
``@gufunc(layout, signature)``
    A NumPy ufunc over any batch shape, compiled when it is first called.
``@fused``, ``@fused_inlined``, ``@fused_entry``
    The same for code in which a product and a sum may become one instruction: helpers, which
    only compiled code can call and which are cached with whoever calls them, and the function that
    Python calls.

Between kernels, numbers that belong together go as a named tuple, at no cost. What Python calls
takes its arrays one by one, as unpacking a named tuple takes longer than a small batch.

An import compiles nothing. What a kernel calls is optimised and made machine code as part of the
kernel alone: a helper is in the cache only within the kernels that Python has called.

In all of them dividing by zero is no error, and the interpreter's lock is released (for gufuncs by
NumPy).

Numba recompiles a cached kernel when the kernel's own file changes. Here a kernel is recompiled
also when a file changes from which it takes compiled helpers or named tuples, directly or through
others, and when a constant does: what it depends on is found from what its module imports.

What the cache holds damaged counts as not there, and where nothing can be written kernels are
compiled in memory.
"""

from coopenv.compiled.kinds import (
    TINY,
    anywhere,
    compiled,
    fused,
    fused_entry,
    fused_inlined,
    gufunc,
    in_llvm,
    inlined,
)

__all__ = [
    "TINY",
    "anywhere",
    "compiled",
    "fused",
    "fused_entry",
    "fused_inlined",
    "gufunc",
    "in_llvm",
    "inlined",
]
