"""What numba does in less time while it compiles a kernel of ours comes to the same."""

from typing import Any

import numpy as np
from llvmlite import binding
from llvmlite import ir as llvm
from numba.core import ir
from numba.core.compiler import run_frontend
from numba.core.registry import cpu_target

from coopenv.compiled import compiled
from coopenv.compiled.lighter import lighter


def _function(values, limit):
    total, pair = 0.0, (limit, values[0])
    for k in range(len(values)):
        if values[k] > limit:
            total += np.hypot(values[k], pair[1]) - values[1:k][0]
    return {"total": total, "limit": limit}


def _variables():
    blocks = run_frontend(_function).blocks.values()
    return [[str(one) for one in each.list_vars()] for block in blocks for each in block.body]


def test_the_variables_of_instructions_are_those_that_numba_finds():
    numbas = _variables()
    with lighter():
        assert ir.Inst._rec_list_vars.__module__ == "coopenv.compiled.lighter"
        assert _variables() == numbas
    assert ir.Inst._rec_list_vars.__module__ == "numba.core.ir"


def test_the_sizes_of_types_are_those_that_llvm_tells():
    target: Any = cpu_target.target_context
    data, word, byte = target.target_data, llvm.IntType(64), llvm.IntType(8)
    kinds = [byte, word, llvm.ArrayType(byte, 3), llvm.LiteralStructType([byte, word])]
    told = [kind.get_abi_size(data) for kind in kinds]
    with lighter():
        assert [kind.get_abi_size(data) for kind in kinds * 2] == told * 2 == [1, 8, 3, 16] * 2


def test_whoever_listens_to_llvm_does_so_again_after_a_kernel_is_compiled():
    @compiled
    def doubled(x):
        return 2.0 * x

    heard = []
    listener = (lambda: heard.append("begin"), lambda: heard.append("end"))
    binding.ffi.register_lock_callback(*listener)
    try:
        assert doubled(2.0) == 4.0
        heard.clear()
        binding.get_default_triple()
        assert heard[:2] == ["begin", "end"]
    finally:
        binding.ffi.unregister_lock_callback(*listener)
