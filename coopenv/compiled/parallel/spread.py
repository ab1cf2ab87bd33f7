"""Spread: a kernel's work in parts, for whoever is there to take them."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils

from coopenv.compiled import instructions
from coopenv.compiled.kinds import compiled, in_llvm
from coopenv.compiled.parallel.board import (
    ARGUMENTS,
    BED,
    COUNT,
    DONE,
    END_BITS,
    FAILED,
    JOB_BITS,
    MOST_PARTS,
    NAP,
    ONE_FRONT,
    OWNER,
    PARTS,
    TASK,
    TICKET,
    add,
    exchanged,
    read,
    write,
)
from coopenv.compiled.parallel.gates import nap

_PATIENCE, _NAP = 100_000, 50  # looks for the last part, and then [µs] between them


def _lent(context, builder, kind, value):
    """A value whose arrays nobody counts references to.

    Threads that count those of one array wait for each other at every view that they make of it.
    Whoever put the job on the board keeps the arrays until it is done.
    """
    if isinstance(kind, types.BaseTuple):
        kinds: Any = kind  # it can be gone through
        parts = zip(kinds, cgutils.unpack_tuple(builder, value), strict=True)
        lent = [_lent(context, builder, one, part) for one, part in parts]
        return context.make_tuple(builder, kind, lent)
    if not isinstance(kind, types.Array):
        return value
    array = context.make_array(kind)(context, builder, value)
    array.meminfo = cgutils.get_null_value(array.meminfo.type)
    return array._getvalue()


@instructions.instruction(types.intp, types.intp, types.intp, types.intp, types.intp)
def _call(builder, task, arguments, start, stop):
    """Call what `_task` made, for rows from ``start`` to before ``stop``; 1 if it failed."""
    return instructions.call(builder, ir.IntType(64), task, arguments, start, stop)


@compiled
def take_part(board, from_front):
    """Do a part of the job on the board, if one is left; whether there was one."""
    ticket = read(board, TICKET)
    front, back = (ticket >> END_BITS) & MOST_PARTS, ticket & MOST_PARTS
    if front >= back:
        return False
    if not exchanged(board, TICKET, ticket, ticket + ONE_FRONT if from_front else ticket - 1):
        return True  # another was quicker
    number = front if from_front else back - 1
    count, parts = read(board, COUNT), read(board, PARTS)
    start, stop = number * count // parts, (number + 1) * count // parts
    if _call(read(board, TASK), read(board, ARGUMENTS), start, stop) != 0:
        write(board, FAILED, 1)
    add(board, DONE, 1)
    return True


@compiled
def _together(board, parts, count, task, kept):
    """Put a task on the board that is ours, do it with who helps, and leave the board."""
    write(board, TASK, task)
    write(board, ARGUMENTS, kept)
    write(board, COUNT, count)
    write(board, PARTS, parts)
    write(board, FAILED, 0)
    write(board, DONE, 0)
    number = (read(board, TICKET) >> JOB_BITS) + 1
    write(board, TICKET, (number << JOB_BITS) + parts)
    while take_part(board, True):
        pass
    looks = 0
    while read(board, DONE) < parts:
        looks += 1
        if looks > _PATIENCE:  # whoever has the last part may wait for this core
            nap(read(board, NAP), read(board, BED), _NAP)
    failed = read(board, FAILED)
    write(board, OWNER, 0)
    return failed


@compiled
def _do(board, parts, count, task, kept):
    """Do a task, for which `spread` has made code and kept the arguments."""
    if board == 0 or parts <= 1 or not exchanged(board, OWNER, 0, 1):
        failed = _call(task, kept, 0, count)
    else:
        failed = _together(board, parts, count, task, kept)
    if failed != 0:
        raise MemoryError("memory must suffice for what compiled code works in")


@in_llvm
def spread(typingctx, board, parts, count, kernel, arguments):
    """Do ``kernel(start, stop, *arguments)`` for all rows from 0 to ``count``, in ``parts``.

    Threads of the crew take parts too; this returns when all are done. If another thread's job is
    on the board, the caller does its own alone.

    Parameters
    ----------
    board
        Its address; 0: nobody helps.
    parts
        In how many parts; the rows of each are a kernel call's.
    count
        Rows.
    kernel
        A function of `coopenv.compiled.compiled` that writes into its arguments and returns
        nothing.
    arguments
        Tuple.

    Raises
    ------
    MemoryError
        If a part could not be done: kernels raise nothing else.
    """
    inner = kernel.get_call_type(typingctx, (types.intp, types.intp, *arguments), {})
    if inner.return_type != types.none:
        raise TypeError("a kernel that is spread must return nothing")
    compiled_kernel = kernel.dispatcher.get_compile_result(inner)
    doing = types.Dispatcher(_do).get_call_type(typingctx, (types.intp,) * 5, {})
    compiled_do = _do.get_compile_result(doing)

    def generate(context, builder, signature, values):
        *numbers, _, given = values
        for made in (compiled_kernel, compiled_do):
            context.active_code_library.add_linking_library(made.library)
        task, kept = _task(context, builder, compiled_kernel.fndesc, inner, arguments, given)
        places = zip(numbers, signature.args, strict=False)
        numbers = [context.cast(builder, number, kind, types.intp) for number, kind in places]
        called = [*numbers, task, kept]
        return context.call_internal(builder, compiled_do.fndesc, doing, called)

    return types.none(board, parts, count, kernel, arguments), generate


def _task(context, builder, fndesc, inner, arguments, given):
    """Addresses of a function that does a part of a kernel's rows, and of the arguments it takes.

    They stay valid until the function returns that this is compiled into.
    """
    kept = cgutils.alloca_once_value(builder, given)
    word = ir.IntType(64)
    name = builder.module.get_unique_name(f"{builder.function.name}.task")
    task = ir.Function(builder.module, ir.FunctionType(word, (word, word, word)), name=name)
    task.linkage = "internal"
    inside = ir.IRBuilder(task.append_basic_block("entry"))
    loaded = inside.load(inside.inttoptr(task.args[0], kept.type))
    lent = _lent(context, inside, arguments, loaded)
    values = [task.args[1], task.args[2], *cgutils.unpack_tuple(inside, lent)]
    status, _ = context.call_internal_no_propagate(inside, fndesc, inner, values)
    inside.ret(inside.zext(status.is_error, word))
    return builder.ptrtoint(task, word), builder.ptrtoint(kept, word)
