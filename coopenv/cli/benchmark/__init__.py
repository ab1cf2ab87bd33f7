"""``coopenv benchmark``: enter policies in the suites of the benchmark."""

from coopenv.cli.benchmark.command import Benchmark

__all__ = ["Benchmark"]
