"""Times that are written as text, or as time stamps, as seconds since the first of them."""

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.logs.limits import shown

ISO = "iso"
SECOND, DAY = 10**9, 86_400 * 10**9  # [ns]
MONTHS = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"]
PARTS = {  # directive -> what stands there
    "Y": r"(?P<Y>\d{4})", "y": r"(?P<y>\d{2})", "m": r"(?P<m>\d{1,2})", "d": r"(?P<d>\d{1,2})",
    "b": r"(?P<b>[A-Za-z]{3})", "H": r"(?P<H>\d{1,2})", "I": r"(?P<I>\d{1,2})",
    "M": r"(?P<M>\d{1,2})", "S": r"(?P<S>\d{1,2})", "f": r"(?P<f>\d{1,9})",
    "p": r"(?P<p>[AaPp][Mm])", "z": r"(?P<z>Z|[+-]\d{2}:?\d{2})",
}  # fmt: skip
ISO_PATTERN = (
    rf"{PARTS['Y']}-{PARTS['m']}-{PARTS['d']}(?:[T ]{PARTS['H']}:{PARTS['M']}"
    rf"(?::{PARTS['S']}(?:[.,]{PARTS['f']})?)?\s*{PARTS['z']}?)?"
)
CLOCKS = (  # how times without a day are written
    (re.compile(r"\d{1,2}:\d{2}:\d{2}\.\d+"), "%H:%M:%S.%f"),
    (re.compile(r"\d{1,2}:\d{2}:\d{2}:\d+"), "%H:%M:%S:%f"),
    (re.compile(r"\d{1,2}:\d{2}:\d{2}"), "%H:%M:%S"),
)


def written_as(text: str) -> str:
    """How a time is written, if it looks like one in ISO 8601 or of a clock; else empty."""
    text = text.strip()
    if re.fullmatch(ISO_PATTERN, text):
        return ISO
    return next((form for pattern, form in CLOCKS if pattern.fullmatch(text)), "")


def is_form(said: str) -> bool:
    """Whether a unit of time is none, but says how times are written."""
    return said == ISO or "%" in said


def require_form(said: str) -> None:
    """Raise `InvalidInput` unless it is ``iso`` or made of known directives with a time."""
    if said != ISO:
        _pattern(said)


class Origin:
    """From when several files count their times: the first that is read."""

    nanoseconds: int | None = None


class Stamps:
    """Times as text of one form, over all pieces of a file.

    Parameters
    ----------
    form
        ``"iso"`` for ISO 8601, or directives as `datetime.datetime.strptime` takes them.
    origin
        Common to several files; one of its own if ``None``.
    """

    def __init__(self, form: str, origin: Origin | None = None):
        self.rule = "a time as in ISO 8601" if form == ISO else f"a time like {form}"
        self._pattern = ISO_PATTERN if form == ISO else _pattern(form)
        self._has_day = form == ISO or any(f"%{each}" in form for each in "djmb")
        self._origin = origin or Origin()
        self._days = 0  # since the first one, where only the clock is written
        self._last: int | None = None

    def of_texts(self, texts: Any) -> FloatArray:
        """Seconds ``(T,)`` of a pyarrow array of texts; NaN where one is no such time."""
        import pyarrow as pa
        from pyarrow import compute

        if isinstance(texts, pa.ChunkedArray):
            texts = texts.combine_chunks()
        found = compute.call_function(
            "extract_regex",
            [texts.cast(pa.string())],
            compute.ExtractRegexOptions(rf"^\s*{self._pattern}\s*$"),
        )
        time, usable = self._nanoseconds(found)
        if not self._has_day:
            time = self._over_midnight(time, usable)
        return self.of_nanoseconds(time, usable)

    def of_nanoseconds(self, time: IntArray, usable: npt.NDArray[np.bool_]) -> FloatArray:
        """Seconds ``(T,)`` of whole nanoseconds; NaN where they are not usable."""
        if self._origin.nanoseconds is None:
            if not usable.any():
                return np.full(len(time), np.nan)
            self._origin.nanoseconds = int(time[usable][0])
        with np.errstate(over="ignore"):
            return np.where(usable, (time - self._origin.nanoseconds) / SECOND, np.nan)

    def _nanoseconds(self, found: Any) -> tuple[IntArray, npt.NDArray[np.bool_]]:
        """Nanoseconds of the parts of times, and which of them there are."""
        named = {entry.name: found.field(k) for k, entry in enumerate(found.type)}
        usable = found.is_valid().to_numpy(zero_copy_only=False)

        def part(name: str, default: int = 0) -> IntArray:
            if name not in named:
                return np.full(len(usable), default)
            return _whole(named[name], default)

        hour, minute, second = part("H"), part("M"), part("S")
        if "I" in named:
            hour = part("I") % 12 + 12 * _is(named.get("p"), "p", len(usable))
        month = _month(named["b"]) if "b" in named else part("m", 1)
        year = 2000 + part("y") if "y" in named else part("Y", 1970)
        day = part("d", 1)
        usable &= (hour < 24) & (minute < 60) & (second < 60) & (month >= 1) & (month <= 12)
        first = (year.astype(np.int64) - 1970).astype("M8[Y]").astype("M8[M]") + (month - 1)
        date = first.astype("M8[D]") + (day - 1)
        usable &= (day >= 1) & (date.astype("M8[M]") == first)
        days = date.astype(np.int64)
        usable &= np.abs(days) < 100_000  # of which there are nanoseconds
        seconds = (hour * 60 + minute) * 60 + second - _offset(named.get("z"), len(usable))
        time = np.where(usable, days, 0) * DAY + seconds * SECOND
        return time + _fraction(named.get("f"), len(usable)), usable

    def _over_midnight(self, time: IntArray, usable: npt.NDArray[np.bool_]) -> IntArray:
        """Times of a clock that goes on after midnight: where it falls by half a day, a day on."""
        there = time[usable]
        if not len(there):
            return time
        before = np.concatenate([[there[0] if self._last is None else self._last], there[:-1]])
        days = self._days + np.cumsum(there - before < -DAY // 2)
        self._last, self._days = int(there[-1]), int(days[-1])
        made = time.copy()
        made[usable] += days * DAY
        return made


def _pattern(form: str) -> str:
    """Regular expression of a form."""
    made, seen = "", set()
    for literal, directive in re.findall(r"([^%]*)(?:%(.?))?", form):
        made += re.escape(literal)
        if not directive:
            continue
        if directive == "%":
            made += "%"
            continue
        if directive not in PARTS or directive in seen:
            raise InvalidInput(
                f"time must be a unit, iso, or a form of %{', %'.join(PARTS)}, each once, got "
                f"{shown(form)!r}; write the form as in %H:%M:%S.%f"
            )
        seen.add(directive)
        made += PARTS[directive]
    if not seen & set("HIMSf"):
        raise InvalidInput(
            f"time must be a form with a time of the day, got {shown(form)!r}; write it as in "
            "%H:%M:%S.%f"
        )
    return made


def _whole(column: Any, default: int) -> IntArray:
    """Digits as whole numbers; the default where there are none."""
    import pyarrow as pa
    from pyarrow import compute

    empty = compute.call_function("equal", [column, ""])
    column = compute.call_function("if_else", [empty, pa.scalar(str(default)), column])
    return column.fill_null(str(default)).cast(pa.int64()).to_numpy(zero_copy_only=False)


def _fraction(column: Any, rows: int) -> IntArray:
    """Digits after the point as nanoseconds."""
    if column is None:
        return np.zeros(rows, np.int64)
    from pyarrow import compute

    options = compute.PadOptions(9, "0")
    padded = compute.call_function("utf8_rpad", [column.fill_null("0")], options)
    return _whole(padded, 0)


def _offset(column: Any, rows: int) -> IntArray:
    """Zones of time as seconds."""
    if column is None:
        return np.zeros(rows, np.int64)
    known: dict[str | None, int] = {None: 0, "": 0, "Z": 0}
    found = column.to_pylist()
    for text in set(found) - set(known):
        digits = text[1:].replace(":", "")
        known[text] = int(f"{text[0]}1") * (int(digits[:2]) * 3600 + int(digits[2:]) * 60)
    return np.array([known[text] for text in found], dtype=np.int64)


def _month(column: Any) -> IntArray:
    """Names of months as their numbers; 0 for what is none."""
    numbers = {name: k + 1 for k, name in enumerate(MONTHS)}
    return np.array([numbers.get((name or "").lower(), 0) for name in column.to_pylist()])


def _is(column: Any, letter: str, rows: int) -> IntArray:
    """1 where a text begins with the letter."""
    if column is None:
        return np.zeros(rows, np.int64)
    return np.array([int((text or "").lower()[:1] == letter) for text in column.to_pylist()])
