"""Text files as streams of UTF-8, whatever encoding they have and whether they are compressed."""

import codecs
import gzip
import io
from pathlib import Path
from typing import IO

from coopenv.errors import InvalidInput
from coopenv.logs.limits import shown

PIECE = 1 << 20  # [bytes] that are decoded at once
MARKS = (  # at the beginning of a file; the longer ones first
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
SAMPLE = 64  # [bytes] in which UTF-16 without a mark shows by its zeros


class Text:
    """A text file, opened as often as it is read.

    Parameters
    ----------
    path
        Of the file; ``.gz`` at its end says that it is compressed.
    encoding
        Of `coopenv.logs.declared.dialect.ENCODINGS`, or ``"auto"``.
    """

    def __init__(self, path: Path, encoding: str):
        self._path = path
        self._compressed = path.name.lower().endswith(".gz")
        with path.open("rb") as raw:
            begin = self._bytes(raw).read(SAMPLE)
        mark, found = next(((m, name) for m, name in MARKS if begin.startswith(m)), (b"", ""))
        self.encoding = encoding if encoding != "auto" else found or _without_mark(begin)
        self._mark = mark if self.encoding == "utf-8" else b""
        self._size = max(path.stat().st_size, 1)

    def open(self) -> "Stream":
        """From its beginning, without a mark of its encoding."""
        raw = self._path.open("rb")
        try:
            file = self._bytes(raw)
            file.read(len(self._mark))
        except BaseException:
            raw.close()
            raise
        if self.encoding != "utf-8":
            file = io.BufferedReader(_Decoded(file, self.encoding, self._path), PIECE)
        return Stream(file, raw, self._size)

    def _bytes(self, raw: IO[bytes]) -> IO[bytes]:
        return io.BufferedReader(gzip.GzipFile(fileobj=raw), PIECE) if self._compressed else raw


class Stream:
    """Bytes of UTF-8 that are read one after the other.

    Parameters
    ----------
    file
        What is read.
    raw
        The file itself, for how much of it that was.
    size
        Of the file itself [bytes].
    """

    def __init__(self, file: IO[bytes], raw: IO[bytes], size: int):
        self._file, self._raw, self._size = file, raw, size
        self.readline, self.read = file.readline, file.read

    def skip(self, size: int) -> None:
        """Pass over so many bytes."""
        while size > 0:
            size -= len(self.read(min(size, PIECE))) or size

    @property
    def progress(self) -> float:
        """Share of the file that has been read, in [0, 1]."""
        return min(1.0, self._raw.tell() / self._size)

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self._raw.close()


class _Decoded(io.RawIOBase):
    """Another encoding as UTF-8, in pieces."""

    def __init__(self, file: IO[bytes], encoding: str, path: Path):
        self._file, self._path, self._encoding = file, path, encoding
        self._decoder = codecs.getincrementaldecoder(encoding)()
        self._rest, self._line, self._ended = memoryview(b""), 1, False

    def readable(self) -> bool:
        return True

    def readinto(self, buffer) -> int:
        while not self._rest and not self._ended:
            self._rest = memoryview(self._next())
        size = min(len(buffer), len(self._rest))
        buffer[:size], self._rest = self._rest[:size], self._rest[size:]
        return size

    def close(self) -> None:
        self._file.close()
        super().close()

    def _next(self) -> bytes:
        data = self._file.read(PIECE // 4)  # UTF-8 may need more
        self._ended = not data
        try:
            text = self._decoder.decode(data, final=self._ended)
        except UnicodeError as error:
            raise self._refusal(error) from error
        self._line += text.count("\n")
        return text.encode("utf-8", "replace")  # single halves of pairs are no characters

    def _refusal(self, error: UnicodeError) -> InvalidInput:
        line, seen = self._line, shown(error)
        if isinstance(error, UnicodeDecodeError):
            right = error.object[: error.start].decode(self._encoding, "ignore")
            line, seen = line + right.count("\n"), str(error.object[error.start :][:8])
        return InvalidInput(
            f"{self._path}, line {line} must be text in {self._encoding}, got {seen}; say another "
            "--encoding, or save the file again"
        )


def _without_mark(begin: bytes) -> str:
    """UTF-16 of Latin letters, in which every other byte is zero; else UTF-8."""
    pairs = begin[: len(begin) // 2 * 2]
    if len(pairs) >= 8:
        if not any(pairs[1::2]) and all(pairs[::2]):
            return "utf-16-le"
        if not any(pairs[::2]) and all(pairs[1::2]):
            return "utf-16-be"
    return "utf-8"
