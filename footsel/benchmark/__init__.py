"""Latency of every stage and every model variant on the machine at hand."""

from footsel.benchmark.histogram import draw_histogram
from footsel.benchmark.run import BenchmarkSize, run_benchmark
from footsel.benchmark.table import as_table

__all__ = ["BenchmarkSize", "as_table", "draw_histogram", "run_benchmark"]
