"""Type of a table for the type checker."""

from typing import Any, TypeAlias

Table: TypeAlias = Any
"""A `pandas.DataFrame`.

pandas annotates most results as Series, DataFrame or scalar alike, which would need a cast at every
step; its own stubs are a further package.
"""
