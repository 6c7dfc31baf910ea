"""Measure the camera map on walking courses: docs/results/mapping.json, and the picture docs/figures/mapping.png.

The robot is carried along each course at a crawl's speed, level with the ground under its feet, believes to be where
`camera_sight` has it, and maps what it sees. Errors are those of the terrain relative to the robot, at the way's end.
"""

import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from footsel.benchmark.machine import cpu_name
from footsel.files import write_json
from footsel.legs import LEGS
from footsel.mapping import D435, ElevationMapping
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.sensing import CameraMap, camera_sight
from footsel.walking.sensing.mounts import FRONT
from footsel.walking.sensing.own_bodies import OwnBodies
from footsel.walking.sensing.renderer import true_depth
from footsel.walking.simulation import Simulation

DOCS = Path(__file__).resolve().parent
COURSES, SEEDS = ("flat", "slopes", "stairs", "blocks", "rubble", "stones"), (0, 1)
#: How far the robot is carried, how fast, and how often it looks. [m], [m/s], [s]
WAY, SPEED, PERIOD = 0.8, 0.055, 0.5
#: Where the next front feet may land, ahead of the base and to its sides. [m]
REACH, SIDE = (0.25, 0.95), 0.5
#: Errors of height are told of cells within 4 cm of which the ground changes by less, and which lie in no gap. [m]
EDGE, GAP = 0.04, -0.25
#: A known cell that is off by more than this from all that is around it shows what is not there. [m]
MISTAKE = 0.05
#: The median of squares of a standard normal number.
MEDIAN_SQUARE = 0.455
#: Of the picture.
PICTURE = ("stones", 1)
DPI, COLOURS = 110, 128
UNKNOWN = "white"


def main() -> None:
    """Measure and draw."""
    courses = {name: [measure(name, seed) for seed in SEEDS] for name in COURSES}
    means = {
        name: {key: float(np.mean([run[key] for run in runs])) for key in runs[0]} for name, runs in courses.items()
    }
    write_json(
        DOCS / "results" / "mapping.json",
        {"cpu": cpu_name(), "seeds": len(SEEDS), "way_m": WAY, "courses": means, "time_ms": times()},
    )
    draw(*PICTURE)


def measure(name: str, seed: int) -> dict[str, float]:
    """Figures of one course."""
    source, true_base, estimate, ground = list(carried(name, seed))[-1]
    found, expected, (x, y) = compared(source.elevation_map(), true_base, estimate, ground)
    highest, lowest = (around(expected, extreme) for extreme in (np.fmax, np.fmin))
    near = (x > REACH[0]) & (x < REACH[1]) & (np.abs(y) < SIDE) & np.isfinite(expected)
    change = around(highest, np.fmax) - around(lowest, np.fmin)
    known, even = near & np.isfinite(found), (change < EDGE) & (expected > GAP)
    error = (found - expected)[known & even]
    return {
        "known": float(known.sum() / near.sum()),
        "known_even": float((known & even).sum() / (near & even).sum()),
        "median_mm": 1e3 * float(np.median(np.abs(error))),
        "p95_mm": 1e3 * float(np.percentile(np.abs(error), 95)),
        "too_high": float((found > highest + MISTAKE)[known].mean()),
        "too_low": float((found < lowest - MISTAKE)[known].mean()),
        "normalised": float(np.median(error**2 / source.variance()[known & even]) / MEDIAN_SQUARE),
        "drift_mm": 1e3 * float(np.linalg.norm((estimate - true_base)[:3, 3])),
    }


def around(heights: np.ndarray, extreme: np.ufunc) -> np.ndarray:
    """(nx, ny) the extreme of each cell and its eight neighbours."""
    for axis in (0, 1):
        heights = extreme(heights, extreme(np.roll(heights, 1, axis=axis), np.roll(heights, -1, axis=axis)))
    return heights


def carried(name: str, seed: int) -> Iterator[tuple[CameraMap, np.ndarray, np.ndarray, ElevationMap]]:
    """The map, true and estimated placements of the base and the ground, look by look."""
    robot, ground = load_robot(), make_walk_course(name, seed).ground
    joints = np.concatenate([robot.description.stance[leg] for leg in LEGS])
    make, drift = camera_sight(seed)
    source = None
    with Simulation(ground, robot, standing(ground, 0.0), joints) as simulation:
        for k in range(int(WAY / (SPEED * PERIOD)) + 1):
            if source is None:
                source = make(simulation)
            simulation.reset(standing(ground, k * SPEED * PERIOD), joints)
            simulation.time = k * PERIOD
            state = drift.estimate(simulation.state())
            source.update(state.time, state.base, state.joints)
            yield source, simulation.state().base, state.base, ground


def standing(ground: ElevationMap, x: float) -> np.ndarray:
    """(4, 4) placement of the base over the plane through the ground under it, holes left out."""
    along, across = np.meshgrid(np.arange(-0.4, 0.41, 0.04), np.arange(-0.3, 0.31, 0.04), indexing="ij")
    heights = ground.sample(np.stack([along + x, across], axis=-1)).ravel().astype(np.float64)
    solid = heights > np.quantile(heights, 0.9) - 0.3
    design = np.column_stack([along.ravel(), np.ones(along.size)])[solid]
    (slope, middle), *_ = np.linalg.lstsq(design, heights[solid], rcond=None)
    pitch = np.arctan(slope)
    placement = np.eye(4)
    placement[:3, :3] = [[np.cos(pitch), 0, -np.sin(pitch)], [0, 1, 0], [np.sin(pitch), 0, np.cos(pitch)]]
    placement[:3, 3] = x, 0, middle + load_robot().layout.standing_height
    return placement


def compared(
    found: ElevationMap, true_base: np.ndarray, estimate: np.ndarray, ground: ElevationMap
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Heights of the map's cells where they truly are, those of the ground there, and places ahead of the base."""
    x, y = np.meshgrid(found.x(), found.y(), indexing="ij")
    # The ground's height where a cell lies does not depend much on how high the cell is said to be.
    level = np.where(found.known, found.elevation, estimate[2, 3] - 0.45)
    points = np.stack([x, y, level, np.ones_like(x)], axis=-1) @ (true_base @ np.linalg.inv(estimate)).T
    expected = ground.sample(points[..., :2])
    return np.where(found.known, points[..., 2], np.nan), expected, (x - estimate[0, 3], y - estimate[1, 3])


def times() -> dict[str, float]:
    """Medians of processor time, in [ms], for an image of 424x240."""
    sensor, rng, taken = D435(), np.random.default_rng(0), {"render": [], "read": [], "bodies": [], "integrate": []}
    robot, mapping = load_robot(), ElevationMapping()
    joints = np.concatenate([robot.description.stance[leg] for leg in LEGS])
    ground, own = make_walk_course("blocks", 0).ground, OwnBodies(robot)

    def timed(what: str, call: Callable[..., Any], *arguments: Any) -> Any:
        began = time.process_time()
        made = call(*arguments)
        taken[what].append(1e3 * (time.process_time() - began))
        return made

    with Simulation(ground, robot, standing(ground, 0.0), joints) as simulation:
        for k in range(40):
            base = standing(ground, 0.02 * k)
            eye = base @ FRONT
            mapping.move(base)
            depth = timed("render", true_depth, simulation.client, sensor.camera, eye)
            image = timed("read", sensor.read, depth, rng)
            bodies = timed("bodies", own.capsules, base, joints)
            timed("integrate", mapping.integrate, image, sensor.camera, eye, bodies)
    return {what: statistics.median(values) for what, values in taken.items()}


def draw(name: str, seed: int) -> None:
    """True terrain, map and standard deviation around the robot, which walks upwards."""
    source, base, estimate, ground = list(carried(name, seed))[-1]
    found, variance = source.elevation_map(), source.variance()
    _, expected, (x, y) = compared(found, base, estimate, ground)
    rows = np.flatnonzero((x[:, 0] > -1.0) & (x[:, 0] < 1.8))
    columns = np.flatnonzero(np.abs(y[0]) < 1.2)
    window = np.ix_(rows, columns)
    extent = (-y[0, columns[0]], -y[0, columns[-1]], x[rows[0], 0], x[rows[-1], 0])
    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    FigureCanvasAgg(figure)
    low, high = np.nanpercentile(expected[window], [1, 99])
    for axes, title, layer, colours, limits in zip(
        figure.subplots(1, 3),
        ("true terrain [m]", "map [m]", "standard deviation [mm]"),
        (expected, found.elevation, 1e3 * np.sqrt(variance)),
        ("cividis", "cividis", "magma_r"),
        ((low, high), (low, high), (3, 12)),
        strict=True,
    ):
        axes.set_facecolor(UNKNOWN)
        drawn = axes.imshow(
            layer[window][:, ::-1],
            origin="lower",
            extent=(extent[1], extent[0], *extent[2:]),
            cmap=colours,
            vmin=limits[0],
            vmax=limits[1],
            interpolation="nearest",
        )
        axes.set_title(title, fontsize=9)
        axes.tick_params(labelsize=7)
        figure.colorbar(drawn, ax=axes, shrink=0.8).ax.tick_params(labelsize=7)
    path = DOCS / "figures" / "mapping.png"
    figure.savefig(path, dpi=DPI)
    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


if __name__ == "__main__":
    main()
