"""TOML, read by Python's own parser, and on Python 3.10 by the package that became it."""

import sys

if sys.version_info >= (3, 11):
    from tomllib import TOMLDecodeError, loads
else:
    from tomli import TOMLDecodeError, loads  # pyright: ignore[reportMissingImports]

__all__ = ["TOMLDecodeError", "loads"]
