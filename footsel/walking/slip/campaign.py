"""Slip trials on courses of every family: one job per course, each kept in a file of its own until all are there."""

import zipfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path

import joblib
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from footsel.claim import claim_folder
from footsel.files import replace_file
from footsel.oracle.terrain_cost import terrain_features
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.terrain.courses import FAMILIES, make_course
from footsel.walking.slip.shapes import SHAPES, shape_course
from footsel.walking.slip.trial import slip_trials, slip_world

#: Between foot and ground: worn rubber on smooth stone, and rubber on concrete.
FRICTIONS = (0.5, 0.8)
#: Side of a course, and how far inside of it feet are placed, in [m].
COURSE_SIZE, MARGIN = 3.0, 0.3
PLACEMENTS_PER_COURSE = 200
#: Side of a cell, in [m], and of the neighbourhood that is kept of each placement, in cells.
COURSE_RESOLUTION, PATCH = 0.02, 9
#: Cells are drawn with a probability that grows with K2 up to this; level ones keep the least. [slope]
ROUGH_K2, LEAST_WEIGHT = 0.8, 0.02
#: Course seeds of a campaign: those to fit from the first on, those held out from the second on.
SEEDS_PER_CAMPAIGN, HELD_OUT_SEED = 2_000_000, 1_000_000


@dataclass(frozen=True)
class CampaignConfig:
    """What is tried: with the versions of footsel and Bullet it fixes every figure.

    placements: on the courses to fit, over all families. held_out: as many again, on courses of other seeds.
    """

    robot: str = "anymal_b"
    placements: int = 24_000
    held_out: int = 4_800
    seed: int = 0

    def jobs(self) -> Iterator[tuple[str, int]]:
        """Family and course seed of every job."""
        for first, placements in ((0, self.placements), (HELD_OUT_SEED, self.held_out)):
            for number in range(-(-placements // (PLACEMENTS_PER_COURSE * (len(FAMILIES) + 1)))):
                for family in (*FAMILIES, SHAPES):
                    yield family, self.seed * SEEDS_PER_CAMPAIGN + first + number


@dataclass(frozen=True, eq=False)
class Trials:
    """n placements.

    patch: (n, PATCH, PATCH) heights of the cells around, relative to the cell, in [m]. slip: (n, frictions, directions)
    in [m]. uniform: (n,) drawn evenly over the course, not for its roughness. family: (n,) names. course: (n,) seeds.
    """

    patch: NDArray[np.float32]
    slip: NDArray[np.float64]
    uniform: NDArray[np.bool_]
    family: NDArray[np.str_]
    course: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.slip)

    @cached_property
    def features(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """K1 and K2 (n,) of every cell."""
        middle = PATCH // 2
        found = [terrain_features(patch, COURSE_RESOLUTION) for patch in self.patch]
        k1, k2 = np.array([(k1[middle, middle], k2[middle, middle]) for k1, k2, _ in found]).reshape(-1, 2).T
        return k1, k2

    @property
    def held_out(self) -> NDArray[np.bool_]:
        """(n,) which lie on courses that are not fitted."""
        return np.asarray(self.course % SEEDS_PER_CAMPAIGN >= HELD_OUT_SEED)

    def take(self, which: NDArray[np.bool_]) -> "Trials":
        """Those selected by a mask."""
        return Trials(**{field.name: getattr(self, field.name)[which] for field in fields(self)})


def run_campaign(config: CampaignConfig, out: Path, jobs: int = -1) -> Trials:
    """Run, or finish, the campaign; its parts are kept in `out`/trials and used again.

    Raises InputError if `out` holds the trials of another configuration.
    """
    folder = out / "trials"
    claim_folder(out, "campaign of slip trials", asdict(config))
    folder.mkdir(exist_ok=True)
    work = list(config.jobs())
    paths = [folder / f"{family}_{seed}.npz" for family, seed in work]
    missing = [(item, path) for item, path in zip(work, paths, strict=True) if _read(path) is None]
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")
    done = parallel(joblib.delayed(_run_job)(config, *item, path) for item, path in missing)
    for _ in tqdm(done, total=len(work), initial=len(work) - len(missing), desc="slip trials", unit="course"):
        pass
    parts = [part for path in paths if (part := _read(path)) is not None]
    return Trials(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Trials)})


def try_course(
    course: ElevationMap, foot_radius: float, placements: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.bool_], NDArray[np.float64]]:
    """Cells (n, 2), which of them were drawn evenly (n,), and their slip (n, frictions, directions) in [m]."""
    cells, uniform = draw_cells(course, placements, rng)
    xy = course.position + (cells - (np.array(course.elevation.shape) - 1) / 2) * course.resolution
    with slip_world(course, foot_radius, placements) as world:
        slips = [slip_trials(world, xy, friction, rng) for friction in FRICTIONS]
    return cells, uniform, np.stack(slips, axis=1)


def draw_cells(
    course: ElevationMap, placements: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Cells (n, 2) of a course: half of them evenly, half where it is rough, for level ground teaches little."""
    _, k2, share = terrain_features(course.elevation, course.resolution)
    edge = round(MARGIN / course.resolution)
    inside = np.zeros(k2.shape, dtype=np.bool_)
    inside[edge:-edge, edge:-edge] = True
    candidates = np.argwhere(inside & (share == 1.0))
    evenly = placements // 2
    weights = np.minimum(k2[tuple(candidates.T)], ROUGH_K2) + LEAST_WEIGHT
    chosen = np.concatenate(
        [
            rng.choice(len(candidates), evenly, replace=False),
            rng.choice(len(candidates), placements - evenly, replace=False, p=weights / weights.sum()),
        ]
    )
    return candidates[chosen], np.arange(placements) < evenly


def _run_job(config: CampaignConfig, family: str, seed: int, path: Path) -> None:
    rng = np.random.default_rng([seed, [*FAMILIES, SHAPES].index(family)])
    course = shape_course(seed, COURSE_SIZE) if family == SHAPES else make_course(family, seed, size=COURSE_SIZE)
    radius = load_robot(config.robot).description.foot_radius
    cells, uniform, slip = try_course(course, radius, PLACEMENTS_PER_COURSE, rng)
    windows = np.lib.stride_tricks.sliding_window_view(course.elevation, (PATCH, PATCH))
    patch = windows[tuple(cells.T - PATCH // 2)] - course.elevation[tuple(cells.T)][:, None, None]
    n = len(cells)
    part = Trials(patch, slip, uniform, np.full(n, family), np.full(n, seed, dtype=np.int64))
    arrays = {field.name: getattr(part, field.name) for field in fields(part)}
    replace_file(path, lambda temporary: np.savez_compressed(temporary, **arrays))


def _read(path: Path) -> Trials | None:
    """A finished part, None if there is none or it is damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return Trials(**{field.name: stored[field.name] for field in fields(Trials)})
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile):
        return None
