"""The oracle's time per local map, beside a loop that labels cell by cell."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from footsel.benchmark.cases import Case
from footsel.benchmark.timing import milliseconds, percentiles, with_progress
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.oracle.brute_force import BruteForceOracle
from footsel.terrain import LocalMap


def time_oracle(oracle: Oracle, cases: Sequence[Case]) -> dict[str, Any]:
    """`oracle_ms_per_map` over all cases, and `oracle_ms_by_terrain`: over all on level and on tilted bases, and by
    family on both."""
    layout = oracle.robot.layout
    flat = LocalMap(np.full((40, 40), -layout.standing_height), layout.resolution, np.zeros(3), 0.0)
    for leg in LEGS:
        oracle.label(flat, leg)  # Reads the tables and compiles what is compiled, which a robot does once.
    times: defaultdict[str, list[float]] = defaultdict(list)
    for case in with_progress(cases, "oracle"):
        local_map = case.local_map(layout)
        elapsed = milliseconds(lambda: oracle.label(local_map, case.leg, case.pose.roll, case.pose.pitch))  # noqa: B023
        for group in ("all", case.family, "tilted" if case.tilted else "level"):
            times[group].append(elapsed)
    groups = {group: percentiles(values) for group, values in times.items()}
    return {"oracle_ms_per_map": groups.pop("all"), "oracle_ms_by_terrain": groups}


def time_naive_oracle(oracle: Oracle, cases: Sequence[Case]) -> dict[str, Any]:
    """`oracle_naive_ms_per_map`: the mean of the brute-force loop, without its search for the kinematic margin, and
    `oracle_times_as_fast`: the median of how many times as fast the oracle labels the same map, margins included.

    That search takes over a second for each feasible cell; the stages have its time.
    """
    robot = oracle.robot
    naive, fast = [], []
    for case in with_progress(cases, "naive oracle"):
        brute_force, local_map = BruteForceOracle(robot, case.leg), case.local_map(robot.layout)
        tilt = case.pose.roll, case.pose.pitch
        naive.append(milliseconds(lambda: brute_force.label(local_map, *tilt)))  # noqa: B023
        fast.append(milliseconds(lambda: oracle.label(local_map, case.leg, *tilt)))  # noqa: B023
    return {
        "oracle_naive_ms_per_map": round(float(np.mean(naive)), 1),
        "oracle_times_as_fast": round(float(np.median(np.divide(naive, fast)))),
    }
