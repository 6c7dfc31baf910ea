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
        for words, key in (("one leg", "select_one_leg_ms"), ("four legs", "select_four_legs_ms")):
            if "other_core_busy" in parts:
                row(f"  other core busy: {words}", parts["other_core_busy"][key])
    for name, parts in figures["other_models"].items():
        row(f"{name}: network", parts["network_ms"])
        row(f"{name}: select one leg", parts["select_one_leg_ms"])
        row(f"{name}: select four legs", parts["select_four_legs_ms"])
    for variant, parts in figures["cpp"].items():
        row(f"C++, {variant}: network", parts["network_ms"])
        row(f"C++, {variant}: select one leg", parts["select_one_leg_ms"])
        row(f"C++, {variant}: select four legs", parts["select_four_legs_ms"])
    for name, parts in figures["baselines"].items():
        row(f"{name.replace('_', ' ')}: network", parts["network_ms"])
        if "in_turns_with_it" in parts:
            row("  ours in turns with it", parts["in_turns_with_it"])
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
    lines += _speed(figures)
    return "\n".join(lines)


def _speed(figures: Mapping[str, Any]) -> list[str]:
    """Operations and maps per second."""
    lines = []
    if "matmul_gflops" in figures:
        lines += ["", f"{'matrix product, float32':34}{figures['matmul_gflops']:>10.1f}  GFLOP/s"]
    for variant, parts in figures["models"].items():
        if "gflops" in parts:
            count = f"{parts['multiply_adds'] / 1e6:.1f} M multiply-adds a map"
            lines.append(
                f"{variant:34}{parts['gflops']:>10.1f}  GFLOP/s, {parts['share_of_matmul']:.0%} of it; {count}"
            )
    batches = list(next(iter(next(iter(figures["maps_per_second"].values())).values())))
    lines += ["", f"{'maps per second, batch':34}" + "".join(f"{batch:>10}" for batch in batches)]
    measured = {
        f"{variant}: {name.replace('_', ' ')}": rates
        for variant, rows in figures["maps_per_second"].items()
        for name, rates in rows.items()
    }
    measured |= {f"C++, {variant}: one core": parts["maps_per_second"] for variant, parts in figures["cpp"].items()}
    for name, rates in measured.items():
        lines.append(f"{name:34}" + "".join(f"{rates[batch]:>10.0f}" for batch in batches))
    return lines
