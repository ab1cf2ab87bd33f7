"""Functions of compiled code made of LLVM's own instructions: calls of addresses, atomic words."""

from collections.abc import Callable
from functools import wraps
from typing import Any

from llvmlite import ir
from numba import types

from coopenv.compiled.dependencies import seen
from coopenv.compiled.kinds import in_llvm


def instruction(result: Any, *parameters: Any) -> Callable[[Callable[..., Any]], Any]:
    """Make a function of compiled code from one that builds its instructions.

    Who uses it imports this module, not the name: by that a kernel's cache knows this file.

    Parameters
    ----------
    result, parameters
        Numba's types of what it returns, ``void`` for nothing, and of what it takes.

    Returns
    -------
    A decorator of a function of LLVM's builder, by which instructions are added, and of the
    parameters, as LLVM has them; it returns the result.
    """

    def decorate(build: Callable[..., Any]) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature
            built = build(builder, *arguments)
            return context.get_dummy_value() if result is types.void else built

        @wraps(build)  # numba leaves its first parameter out, and takes the names of the others
        def define(typingctx: Any, *arguments: Any) -> Any:
            del typingctx, arguments
            return result(*parameters), generate

        seen(build)
        return in_llvm(define)

    return decorate


def call(builder: Any, result: ir.Type, address: Any, *arguments: Any) -> Any:
    """Call the function at an address, a number; of the types that the arguments have."""
    kind = ir.FunctionType(result, [each.type for each in arguments])
    return builder.call(builder.inttoptr(address, kind.as_pointer()), arguments)
