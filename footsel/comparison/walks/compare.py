"""The comparison of walks: every selector on the same courses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footsel.comparison.contestants import unique
from footsel.comparison.walks import figures as walk_figures
from footsel.comparison.walks.report import shown
from footsel.walking.course import WalkCourse
from footsel.walking.result import WalkResult
from footsel.walking.runs.campaign import walk_all
from footsel.walking.runs.job import WalkJob
from footsel.walking.runs.trace import Trace


@dataclass(frozen=True, eq=False)
class WalkComparison:
    """jobs and walks: in the same order, terrain by terrain, selector by selector, seed by seed."""

    jobs: Sequence[WalkJob]
    walks: Sequence[tuple[WalkResult, Trace]]

    def figures(self) -> dict[str, Any]:
        """The content of `walks.json` but for how it was run."""
        seeds = [job.seed for job in self.jobs]
        return {
            "robot": self.jobs[0].robot,
            "map": self.jobs[0].map,
            "watch_limbs": self.jobs[0].watch_limbs,
            "seed": min(seeds),
            "seeds": len(set(seeds)),
            **walk_figures.figures([result for result, _ in self.walks]),
        }

    def drawn_courses(self) -> dict[tuple[str, int], WalkCourse]:
        """The courses of the walks that the report draws, by terrain and seed."""
        wanted = {(result.terrain, result.seed) for result, _ in shown(self.walks)}
        jobs = {(job.terrain, job.seed): job for job in self.jobs}
        return {key: jobs[key].course() for key in wanted}


def compare_walks(
    terrains: Sequence[str],
    selectors: Sequence[str],
    out: Path,
    seeds: int = 10,
    seed: int = 0,
    map_name: str = "exact",
    robot: str = "anymal_b",
    model: Path | None = None,
    map_options: Mapping[str, Any] | None = None,
    jobs: int = -1,
    scheduler: str | None = None,
    watch_limbs: bool = True,
) -> WalkComparison:
    """Walk every terrain with every selector and `seeds` seeds from `seed` on; all but the times is the same each time.

    out: folder that keeps finished walks. jobs, scheduler: as of `walk_all`, whose errors it raises too.
    watch_limbs: as of WalkJob.
    Raises UnknownNameError for a terrain, selector or map that does not exist, before anything walks.
    """
    walks = [
        WalkJob(terrain, name, number, map_name, robot, model, dict(map_options or {}), watch_limbs=watch_limbs)
        for terrain in unique(terrains)
        for name in unique(selectors)
        for number in range(seed, seed + seeds)
    ]
    for job in {job.terrain: job for job in walks}.values():
        job.course()
    return WalkComparison(walks, walk_all(walks, out, jobs, scheduler))
