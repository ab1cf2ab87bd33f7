"""What libraries raise where a file is damaged, as one error of ours."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from coopenv.errors import CoopenvError, InvalidInput, MissingExtra
from coopenv.logs.limits import shown


@contextmanager
def parsing(
    path: Path, what: str, remedy: str, *, missing: MissingExtra | None = None
) -> Iterator[None]:
    """Say of a file that a library does not understand which it is and what it should be.

    They raise a dozen kinds of errors, `MemoryError` among them where a file claims to be large;
    what the system says of a file is left as it is. A library that is of an extra is
    imported in here, and ``missing`` raised where it is not installed.
    """
    try:
        yield
    except CoopenvError:
        raise
    except Exception as error:
        if isinstance(error, ImportError) and missing is not None:
            raise missing from error
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise InvalidInput(
            f"{path} must be {what}, got {type(error).__name__}: {shown(error)}; {remedy}"
        ) from error
