"""Latency of every stage and every model variant on the machine at hand."""

from footsel.benchmark.run import BenchmarkSize, run_benchmark
from footsel.benchmark.table import as_table

__all__ = ["BenchmarkSize", "as_table", "run_benchmark"]
