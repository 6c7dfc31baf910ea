"""The comparison on maps: poses, judgement in parallel, figures per map, per leg and in all."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from tqdm import tqdm

from footsel.comparison.contestants import Contestants, load_contestants, unique
from footsel.comparison.judge import Verdict, judge
from footsel.comparison.maps import NamedMap
from footsel.comparison.poses import draw_poses
from footsel.comparison.tally import total
from footsel.errors import InputError, MapError
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.terrain import ElevationMap

#: Poses per job: few enough to share the work out evenly, many enough to hide a job's overhead.
POSES_PER_JOB = 20


@dataclass(frozen=True, eq=False)
class Comparison:
    """maps and verdicts: in the same order. poses: per map."""

    contestants: Contestants
    poses: int
    seed: int
    maps: Sequence[NamedMap]
    verdicts: Sequence[Verdict]

    def figures(self) -> dict[str, Any]:
        """The content of `compare.json` but for how it was run; None where there was nothing to average over."""
        names = tuple(self.contestants.selectors)
        judges_cells = self.contestants.network is not None
        everything = total(
            (tally for verdict in self.verdicts for tally in verdict.legs.values()), names, judges_cells
        ).result()
        per_map = {}
        for named, verdict in zip(self.maps, self.verdicts, strict=True):
            figures = total(verdict.legs.values(), names, judges_cells).result()
            _add_times(figures, [verdict])
            figures["legs"] = {leg: tally.result() for leg, tally in verdict.legs.items()}
            per_map[named.name] = figures
        per_leg = {leg: total((v.legs[leg] for v in self.verdicts), names, judges_cells).result() for leg in LEGS}
        _add_times(everything, self.verdicts)
        return {
            "robot": self.contestants.robot,
            "poses": self.poses,
            "seed": self.seed,
            "maps": [named.name for named in self.maps],
            **everything,
            "per_leg": per_leg,
            "per_map": per_map,
        }


def compare(
    maps: Sequence[NamedMap],
    selectors: Sequence[str],
    robot: str = "anymal_b",
    poses: int = 200,
    seed: int = 0,
    jobs: int = 1,
    model: Path | None = None,
) -> Comparison:
    """Compare selectors on maps; all figures but the times are the same for the same seed, whatever `jobs`.

    poses: base poses per map; those of a map come from (seed, index of the map). jobs: processes, as joblib counts.
    model: model folder of the network (default: the robot's released one).
    Raises InputError for two maps of one name, MapError for a map without known ground, ModelError, UnknownNameError.
    """
    _check_names([named.name for named in maps])
    names = unique(selectors)
    contestants = load_contestants(robot, names, model)
    work: list[tuple[int, list[BasePose]]] = []
    for index, named in enumerate(maps):
        try:
            drawn = draw_poses(np.random.default_rng([seed, index]), named.elevation_map, contestants.layout, poses)
        except MapError as error:
            raise MapError(f"{named.name}: {error.what}", error.remedy) from None
        work += [(index, drawn[first : first + POSES_PER_JOB]) for first in range(0, poses, POSES_PER_JOB)]

    verdicts = [Verdict.empty(contestants) for _ in maps]
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator")
    parts = parallel(
        joblib.delayed(_judge_part)(robot, names, model, maps[index].elevation_map, part) for index, part in work
    )
    with tqdm(total=len(maps) * poses, desc="poses", unit="pose", disable=None) as progress:
        for (index, part), verdict in zip(work, parts, strict=True):
            verdicts[index].merge(verdict)
            progress.update(len(part))
    return Comparison(contestants, poses, seed, maps, verdicts)


def _judge_part(
    robot: str, names: tuple[str, ...], model: Path | None, elevation_map: ElevationMap, poses: Sequence[BasePose]
) -> Verdict:
    return judge(load_contestants(robot, names, model), elevation_map, poses)


def _add_times(figures: dict[str, Any], verdicts: Sequence[Verdict]) -> None:
    """Median and 99th percentile of the wall time for four legs, in [ms]."""
    for name, values in figures["selectors"].items():
        times = np.concatenate([verdict.times_ms[name] for verdict in verdicts])
        p50, p99 = np.percentile(times, [50, 99]).tolist()
        values["time_ms"] = {"p50": p50, "p99": p99}


def _check_names(names: Sequence[str]) -> None:
    if not names:
        raise InputError("there is no map to compare on", "give at least one")
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"the map {name} is given twice", "give each map once")
