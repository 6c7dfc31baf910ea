"""A control loop that chooses the swing leg's foothold in every tick, and how well it keeps its deadlines.

python deploy/python/control_loop.py MAP.npz --rate 100 --seconds 10

The base walks over the middle of the map along x, to and fro; legs swing in turns. Each tick asks for the foothold of
the leg in the air and stays with the last one unless another is clearly better. Put your state estimate and your map in
place of `Walk`; the rest stays.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footsel import ElevationMap
from footsel.errors import FootselError
from footsel.footholds import Foothold, LegLayout
from footsel.runtime import FootholdSelector

#: A crawl's order of legs, seconds of each swing, and the speed of the base in [m/s].
ORDER, SWING, SPEED = ("LH", "LF", "RH", "RF"), 0.5, 0.1


class Walk:
    """Stands in for the robot: where its base is and which leg swings at a time in [s]."""

    def __init__(self, elevation_map: ElevationMap, layout: LegLayout) -> None:
        self._map, self._layout = elevation_map, layout
        self._reach = max(elevation_map.size[0] / 2 - 1.0, 0.0)

    def pose(self, now: float) -> list[float]:
        """x, y, z, roll, pitch, yaw of the base, z at standing height over the ground, in [m] and [rad]."""
        along = 0.0 if self._reach == 0 else abs((SPEED * now) % (4 * self._reach) - 2 * self._reach) - self._reach
        x, y = self._map.position + np.array([along, 0.0])
        ground = self._layout.ground_height(self._map, x, y, 0.0)
        return [x, y, (0.0 if np.isnan(ground) else ground) + self._layout.standing_height, 0.0, 0.0, 0.0]

    def swing_leg(self, now: float) -> str:
        """The leg in the air."""
        return ORDER[int(now / SWING) % len(ORDER)]


def run(selector: FootholdSelector, elevation_map: ElevationMap, rate: float, seconds: float) -> dict[str, object]:
    """Ticks at `rate` [Hz]; returns what came of them, times in [ms]."""
    walk, period = Walk(elevation_map, selector.layout), 1 / rate
    selector.select(elevation_map, walk.pose(0.0))  # onnxruntime lays out its memory on first use.
    previous: dict[str, Foothold] = {}
    times, late, none = [], 0, 0
    start = time.perf_counter()
    for tick in range(round(rate * seconds)):
        deadline = start + (tick + 1) * period
        began = time.perf_counter()
        leg = walk.swing_leg(tick * period)
        chosen = selector.select(elevation_map, walk.pose(tick * period), (leg,), previous=previous)[leg]
        # A foothold that is "none" is for the gait to handle: stop, shorten the step, lower the base.
        previous = {leg: chosen} if chosen.status == "ok" else {}
        none += chosen.status == "none"
        now = time.perf_counter()
        times.append(now - began)
        late += now > deadline
        time.sleep(max(deadline - time.perf_counter(), 0))
    return {"ticks": len(times), "rate_hz": rate, "late": late, "none": none, "time_ms": _spread(np.array(times) * 1e3)}


def _spread(times: NDArray[np.float64]) -> dict[str, float]:
    shares = {"p50": 50, "p99": 99, "p999": 99.9, "max": 100}
    return {name: round(float(np.percentile(times, share)), 3) for name, share in shares.items()}


def main() -> int:
    """Parse, run, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", metavar="MAP", type=Path, help="elevation map, as footsel select reads it")
    parser.add_argument("--model", default="anymal_b", help="released model or model folder (default: %(default)s)")
    parser.add_argument("--rate", type=float, default=100.0, help="ticks a second [Hz] (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="how long [s] (default: %(default)s)")
    args = parser.parse_args()
    if not (args.rate > 0 and args.seconds > 0):
        parser.error("--rate and --seconds must be above 0")
    try:
        selector, elevation_map = FootholdSelector.load(args.model), ElevationMap.load(args.map)
        print(json.dumps(run(selector, elevation_map, args.rate, args.seconds)))
    except FootselError as error:
        print(f"control_loop.py: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
