"""Recordings and layouts that are well formed as files, and wrong in what they hold."""

import io
import json
import struct
import warnings
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.logs import cases

ODD_NUMBERS = (
    "nan", "inf", "-inf", "1e999", "-1e60", "1_0", "0x10", "\uff11", "", " ", "1,5", "True",
    "1e-400", "9" * 400, "--1", "null", "\0", "\ufeff1", "é",
)  # fmt: skip
ODD_NAMES = (
    "f999999999x", "f10000000x", "f99999999999999999999y", "f0x", "f\u0661x", "f1x", "", "time",
    "a" * 5000, "r101z", "t3x", "omega_z", "x", "qw", "cost", "relative_cost", "trial", "a\tb",
    "$\\frac$", "[bold]", "=1+1", "../../a", "é",
)  # fmt: skip


def columns(rng: np.random.Generator) -> dict[str, Any]:
    """A right recording of a few rows, in the plane or in space."""
    rows, effectors = int(rng.integers(1, 25)), int(rng.integers(1, 4))
    make = cases.planar if rng.random() < 0.7 else cases.spatial
    made = make(rows, effectors, int(rng.integers(1000)))
    if make is cases.planar:
        for i in range(effectors):
            made |= {f"r{i + 1}x": np.full(rows, float(i)), f"r{i + 1}y": np.full(rows, 0.1)}
    if rng.random() < 0.4:
        made["note"] = np.array([f"row {k}" for k in range(rows)])
    if rng.random() < 0.3:
        made["trial"] = np.sort(rng.integers(3, size=rows))
    return made


def text(rng: np.random.Generator) -> bytes:
    """CSV with something wrong in a cell, a line or the header."""
    given = columns(rng)
    separator = str(rng.choice([",", ";", "\t"]))
    rows = [list(given)] + [
        [cases.as_text(cell) for cell in row] for row in zip(*given.values(), strict=True)
    ]
    for _ in range(int(rng.integers(3))):
        _spoil_table(rows, rng)
    lines = [separator.join(row) for row in rows]
    end = str(rng.choice(["\n", "\r\n", "\n\n", "\r"], p=[0.6, 0.25, 0.1, 0.05]))
    coding = str(rng.choice(["utf-8", "utf-8-sig", "latin-1", "utf-16"], p=[0.8, 0.1, 0.07, 0.03]))
    return end.join(lines).encode(coding, "replace")


def _spoil_table(rows: list[list[str]], rng: np.random.Generator) -> None:
    line = int(rng.integers(len(rows)))
    row = rows[line]
    if not row:
        return
    at = int(rng.integers(len(row)))
    cell = row[at]
    kind = int(rng.integers(11))
    if kind == 0:
        row[at] = str(rng.choice(ODD_NAMES if line == 0 else ODD_NUMBERS))
    elif kind == 1:
        quoted = ('"{}"', '"{}', '{}"', '"{}\r"', '"{}\r\n"', '"{}\n"', '"{}""', "'{}'", '""{}""')
        row[at] = str(rng.choice(quoted)).replace("{}", cell)
    elif kind == 2:
        rows.insert(line, list(row))
    elif kind == 3:
        row.insert(at, str(rng.choice(ODD_NAMES)))
    elif kind == 4:
        row.pop(at)
    elif kind == 5:
        other = int(rng.integers(len(row)))
        row[at], row[other] = row[other], row[at]
    elif kind == 6:
        row[at] = cell + "7" * int(
            rng.choice([10, 1000, 200_000, 1_200_000], p=[0.4, 0.4, 0.1, 0.1])
        )
    elif kind == 7:
        rows[0].append(str(rng.choice(ODD_NAMES)))
        for each in rows[1:]:
            each.append("1")
    elif kind == 8:
        rows[:] = rows[: line + 1]
    elif kind == 9:
        rows[line] = []
    else:
        row[at] = cell + str(rng.choice(["\r", "\0", "\x1a", "\u2028", "\x85"]))


def archive(rng: np.random.Generator, *, compressed: bool) -> bytes:
    """NPZ with arrays of other types, shapes, orders and headers."""
    arrays: dict[str, Any] = dict(columns(rng))
    if rng.random() < 0.3:
        arrays |= _blocks(arrays, rng)
    raw: dict[str, bytes] = {}
    for _ in range(int(rng.integers(3))):
        name = str(rng.choice(list(arrays)))
        spoilt = _spoilt_array(arrays[name], rng)
        if isinstance(spoilt, bytes):
            raw[name] = spoilt
        else:
            arrays[str(rng.choice([name, name, *ODD_NAMES]))] = spoilt
    file = io.BytesIO()
    known = [zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED] * 40
    method = int(rng.choice([*known, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]))
    with warnings.catch_warnings(), zipfile.ZipFile(file, "w", method) as made:
        warnings.simplefilter("ignore")  # of names that are there twice, of structured headers
        for name, array in arrays.items():
            entry = io.BytesIO()
            np.lib.format.write_array(entry, np.asanyarray(array), allow_pickle=True)
            made.writestr(_member(name, method), raw.get(name, entry.getvalue()))
        if rng.random() < 0.1:
            made.writestr(_member("f1x", method), b"again")
    return file.getvalue()


def _member(name: str, method: int) -> zipfile.ZipInfo:
    """Of an array, without the time of day: equal contents are equal bytes."""
    member = zipfile.ZipInfo(f"{name}.npy")
    member.compress_type = method
    return member


def _blocks(arrays: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """The same as one array a quantity, which then may be said twice."""
    wrench = cases.wrench(arrays)
    size = 2 if wrench.shape[-1] == 3 else 3
    for name in [each for each in arrays if each[0] in "ft" and each[1:2].isdigit()]:
        if rng.random() < 0.98:
            del arrays[name]
    torque = wrench[..., size:]
    made = {"force": wrench[..., :size], "torque": torque[..., 0] if size == 2 else torque}
    if rng.random() < 0.3:
        made["grips"] = np.ones([(wrench.shape[1], size), (4, 2), (2,)][int(rng.integers(3))])
    return made


def _spoilt_array(array: Any, rng: np.random.Generator) -> Any:
    array = np.asarray(array)
    kinds = (
        "O", "c16", "?", ">f8", "f2", "g", "S8", "U8", "M8[s]", "m8[ms]", "V8", "i1", "u8", "S0",
        "f4,i4", "(2,)f8", "3f8",
    )  # fmt: skip
    kind = int(rng.integers(8))
    if kind < 3:
        dtype = np.dtype(str(rng.choice(kinds)))
        return np.zeros(array.shape, dtype) if rng.random() < 0.5 else _cast(array, dtype)
    if kind == 3:
        return np.asfortranarray(np.stack([array] * 3, axis=-1))
    if kind == 4:
        return array[int(rng.integers(3)) :]
    if kind == 5:
        return array.ravel()[:1].reshape(()) if array.size else array
    if kind == 6:
        odd = [np.nan, np.inf, 1e300, -1e300, 2**63, -1, "a", None]
        made = array.astype(object)
        made.ravel()[: int(rng.integers(3))] = odd[int(rng.integers(len(odd)))]
        return _cast(made, np.float64)
    shapes = (
        "(10**12,)", "(-5,)", "(5, 10**9)", "(5, 10000000, 2)", "()", "(True,)", "(5,", "((5,),)",
        "(5, 2, 10**30)", "(" * 300 + ")" * 300,
    )  # fmt: skip
    descr = str(
        rng.choice(["'<f8'", "'|O'", "'<U99999999'", "[('a', '<f8')]", "'|V0'", "5", "'<f8"])
    )
    return header(descr, str(rng.choice(shapes)), fortran=bool(rng.random() < 0.5)) + bytes(40)


def header(descr: str, shape: str, *, fortran: bool = False) -> bytes:
    """Header of an array that may claim anything."""
    for power in ("10**30", "10**12", "10**9"):
        shape = shape.replace(power, str(10 ** int(power[4:])))
    said = f"{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(said)) + said


def _cast(array: Any, dtype: Any) -> Any:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            return array.astype(dtype)
        except (TypeError, ValueError, OverflowError):
            return np.zeros(array.shape, dtype)


def parquet(rng: np.random.Generator) -> bytes:
    """Parquet with columns of other types."""
    import pyarrow as pa
    from pyarrow import parquet

    arrays = {name: pa.array(np.asarray(column)) for name, column in columns(rng).items()}
    rows = len(arrays["f1x"])
    for _ in range(int(rng.integers(3))):
        name = str(rng.choice([*arrays, *ODD_NAMES]))
        arrays[name] = _odd_column(rows, int(rng.integers(14)))
    table = pa.table(arrays)
    out = io.BytesIO()
    parquet.write_table(
        table.slice(0, 0) if rng.random() < 0.05 else table,
        out,
        compression=str(rng.choice(["snappy", "zstd", "gzip", "none"])),
        use_dictionary=bool(rng.random() < 0.5),
        row_group_size=int(rng.choice([1, 5, 1000])),
    )
    return out.getvalue()


def _odd_column(rows: int, kind: int) -> Any:
    import pyarrow as pa

    made: tuple[Callable[[], Any], ...] = (
        lambda: pa.nulls(rows),
        lambda: pa.array(["a"] * rows),
        lambda: pa.array([True] * rows),
        lambda: pa.array([b"\xff\x00"] * rows),
        lambda: pa.array([b"ab"] * rows, pa.binary(2)),
        lambda: pa.array([[1.0]] * rows),
        lambda: pa.array([{"a": 1}] * rows),
        lambda: pa.array(["a", None] * rows)[:rows].dictionary_encode(),
        lambda: pa.array([1] * rows, pa.timestamp("ns", "UTC")),
        lambda: pa.array([1] * rows, pa.duration("s")),
        lambda: pa.array([1] * rows, pa.decimal128(5, 2)),
        lambda: pa.array([1] * rows, pa.uint64()),
        lambda: pa.array(np.ones(rows, np.float16)),
        lambda: pa.array(["x" * 1_100_000, *["y"] * rows][:rows], pa.large_string()),
    )
    return made[kind]()


def layout(rng: np.random.Generator, *, toml: bool) -> bytes:
    """A layout with values of other types, sizes and depths."""
    fields: dict[str, Any] = {
        "frame": "world", "force": "kN", "grips": [[-0.9, 0.0], [0.9, 0.0]], "forces_only": False,
        "trial_columns": ["trial"], "max_effectors": 8, "decimal": ".", "twist_frame": "object",
    }  # fmt: skip
    odd = (
        None, 3, -1, 1.5, "a", [], {}, [1], [[1, 2], [3]], [["a"]], True, "é" * 2000, 10**400,
        [None], {"f1x": 1}, {"f1x": "Fx"}, {"fx": "a"}, {"f999999999x": "f1x"}, "\0", float("nan"),
        float("inf"), [1e300, 1e300, 1, 1], [[True, False], [False, True]], list(range(3000)),
        {"left": {"path": "none.csv"}}, {"left": {"rate": 10**400}}, {"left": {"time": 1}},
    )  # fmt: skip
    named = (
        *fields,
        "columns",
        "files",
        "join",
        "clock",
        "fill",
        "longest_gap",
        "join_rate",
        "separator",
        "skip_lines",
        "max_rows",
        "max_row_bytes",
        "angle",
        "time",
        "fram",
        "é" * 1500,
        "",
    )
    for _ in range(int(rng.integers(4))):
        fields[str(rng.choice(named))] = odd[int(rng.integers(len(odd)))]
    if rng.random() < 0.05:
        depth = int(rng.choice([20, 100_000]))
        nested = "[" * depth + "]" * depth
        return (f"grips = {nested}" if toml else f'{{"grips": {nested}}}').encode()
    if not toml:
        return json.dumps(fields).encode()
    return "\n".join(
        f"{json.dumps(name)} = {_toml(value)}" for name, value in fields.items()
    ).encode()


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    return "nothing" if value is None else json.dumps(value)
