"""Columns of pyarrow: kinds, lists, time stamps, and arrays of them."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats.chunks import Column


def is_text(kind: Any) -> bool:
    """Whether it is of text, or bytes."""
    from pyarrow import types

    return types.is_string(kind) or types.is_binary(kind)


def bytes_of_rows(column: Any) -> Any:
    """How long the text of each row ``(T,)`` is [bytes]; 0 where there is none."""
    from pyarrow import compute, types

    if is_list(column.type):
        return _list_bytes(column)
    listed = types.is_dictionary(column.type)
    texts = column.dictionary if listed else column
    if not (is_text(texts.type) or _is_large(texts.type)):
        return 0
    length = compute.call_function("binary_length", [texts])
    if listed:
        length = compute.take(length, column.indices)
    return compute.fill_null(length, 0).to_numpy(zero_copy_only=False)


def is_number(kind: Any) -> bool:
    """Whether it is of numbers."""
    from pyarrow import types

    return types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind)


def is_list(kind: Any) -> bool:
    """Whether it is of lists, if it is any."""
    from pyarrow import types

    return kind is not None and (
        types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)
    )


def _ends_of_lists(column: Any) -> tuple[IntArray, IntArray]:
    """Where the list of each row begins in the values of all, and where it ends."""
    from pyarrow import types

    if types.is_fixed_size_list(column.type):
        size = column.type.list_size
        starts = (np.arange(len(column)) + column.offset) * size
        ends = starts + size
    else:
        offsets = column.offsets.to_numpy()
        starts, ends = offsets[:-1].astype(np.int64), offsets[1:].astype(np.int64)
    there = column.is_valid().to_numpy(zero_copy_only=False)
    return starts, np.where(there, ends, starts)


def place_of_lists(column: Any, place: int) -> FloatArray:
    """What the list of each row has in a place; NaN where it is too short."""
    starts, ends = _ends_of_lists(column)
    values = column.values.cast("float64", safe=False).to_numpy(zero_copy_only=False)
    there = starts + place < ends
    made = np.full(len(starts), np.nan)
    made[there] = values[starts[there] + place]
    return made


def _list_bytes(column: Any) -> Any:
    """How much the list of each row holds ``(T,)`` [bytes]."""
    starts, ends = _ends_of_lists(column)
    return 8 * (ends - starts)


def seconds(column: Any, stamps: Stamps) -> FloatArray:
    """Times as text or time stamps as seconds."""
    from pyarrow import types

    if not types.is_timestamp(column.type):
        return stamps.of_texts(column)
    there = column.is_valid().to_numpy(zero_copy_only=False)
    zoneless = column.cast("int64").fill_null(0).to_numpy(zero_copy_only=False)
    size = {"s": 10**9, "ms": 10**6, "us": 1000, "ns": 1}[column.type.unit]
    return stamps.of_nanoseconds(zoneless * size, there)


def _is_large(kind: Any) -> bool:
    from pyarrow import types

    return types.is_large_string(kind) or types.is_large_binary(kind)


def as_numpy(column: Any) -> Column:
    """A column as an array; a text that many rows have is one object."""
    from pyarrow import types

    if not types.is_dictionary(column.type):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    if not is_text(column.type.value_type):
        return np.asarray(column.dictionary_decode().to_numpy(zero_copy_only=False))
    texts = np.array([*column.dictionary.to_pylist(), None], dtype=object)
    places = column.indices.fill_null(len(texts) - 1)  # the last is none
    return texts[places.to_numpy(zero_copy_only=False)]
