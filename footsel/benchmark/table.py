"""The figures of a benchmark as text."""

from collections.abc import Mapping
from typing import Any


def as_table(figures: Mapping[str, Any]) -> str:
    """A table for people; times in ms unless another unit stands there."""
    lines = [f"{figures['cpu']}, one thread on one core", f"{'':34}{'p50':>10}{'p99':>10}{'p99.9':>10}  ms"]

    def row(name: str, times: Mapping[str, float]) -> None:
        cells = "".join(f"{times[key]:>10.3f}" if key in times else f"{'':>10}" for key in ("p50", "p99", "p999"))
        lines.append(f"{name:34}{cells}".rstrip())

    for variant, parts in figures["models"].items():
        mark = " (default)" if variant == figures["default"] else ""
        row(f"{variant}{mark}: network", parts["network_ms"])
        row(f"{variant}: select one leg", parts["select_one_leg_ms"])
        row(f"{variant}: select four legs", parts["select_four_legs_ms"])
    for name, parts in figures["baselines"].items():
        row(f"{name.replace('_', ' ')}: network", parts["network_ms"])
    if "oracle_ms_per_map" in figures:
        row("oracle: one map", figures["oracle_ms_per_map"])
        for group, times in figures["oracle_ms_by_terrain"].items():
            row(f"  {group}", times)
        lines.append(f"{'naive oracle, without margin':34}{figures['oracle_naive_ms_per_map']:>10.0f}  (mean)")
        lines.append(f"{'  the oracle is as many times as fast':38}{figures['oracle_times_as_fast']:>6.0f}  (median)")
        lines.append("")
        lines.append(f"{'oracle, by constraint':34}{'fast':>10}{'naive':>14}  us per cell")
        for stage, times in figures["oracle_us_per_cell"].items():
            lines.append(f"  {stage.replace('_', ' '):32}{times['fast']:>10.3f}{times['naive']:>14.1f}")
    return "\n".join(lines)
