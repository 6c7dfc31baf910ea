"""Labelled pairs in parallel. A shard's bytes depend on the seed, the pair and the shard's number alone."""

import json
import os
import platform
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from tqdm import tqdm

import footsel
from footsel.dataset.samples import Samples, decode_heights, encode_heights
from footsel.dataset.sampling import SamplingRecipe
from footsel.dataset.store import MANIFEST, shard_path, summarise, write_json, write_shard
from footsel.errors import InputError
from footsel.footholds.layout import LegLayout
from footsel.legs import PAIRS, TRAINED_LEG, check_pair
from footsel.oracle import Oracle
from footsel.robot import load_robot
from footsel.terrain import LocalMap, extract_local_map_as_paper
from footsel.terrain.degradation import punch_holes

CONFIG = "config.json"
SAMPLES_PER_SHARD = 250
SAMPLES_PER_COURSE = 25


@dataclass(frozen=True)
class DatasetConfig:
    """What a dataset is made of; with the versions of the libraries it fixes every byte."""

    robot: str
    pairs: tuple[str, ...]
    maps: int
    seed: int
    recipe: str
    families: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()


def generate(config: DatasetConfig, out: Path, jobs: int = -1) -> Path:
    """Make or finish the dataset in folder `out`; shards that are already there are kept. Returns the manifest's path.

    Runs on joblib's current backend, so `joblib.parallel_config("dask", ...)` around it moves it to a cluster.
    Raises InputError if the folder holds a dataset of another configuration.
    """
    for pair in config.pairs:
        check_pair(pair)
    if config.maps < 1:
        raise InputError(f"{config.maps} maps", "give a number of maps per pair, at least 1")
    _sampling(config)
    _claim(config, out)
    # Tables are built once here, not by every worker at once.
    robot = load_robot(config.robot)
    for pair in config.pairs:
        flat = LocalMap(np.zeros((4, 4), dtype=np.float32), robot.layout.resolution, np.zeros(3), 0.0)
        Oracle.load(config.robot).label(flat, TRAINED_LEG[pair])

    shards = -(-config.maps // SAMPLES_PER_SHARD)
    missing = [
        (pair, number)
        for pair in config.pairs
        for number in range(shards)
        if not shard_path(out, pair, number).exists()
    ]
    done = len(config.pairs) * shards - len(missing)
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")
    work = parallel(joblib.delayed(_make_shard)(config, out, pair, number) for pair, number in missing)
    for _ in tqdm(work, total=done + len(missing), initial=done, desc="shards", unit="shard"):
        pass

    manifest: dict[str, Any] = {
        "config": asdict(config),
        "versions": _versions(),
        "pairs": {pair: summarise(out, pair, shards) for pair in config.pairs},
    }
    write_json(out / MANIFEST, manifest)
    return out / MANIFEST


def make_samples(config: DatasetConfig, pair: str, number: int) -> Samples:
    """The samples of one shard."""
    rng = np.random.default_rng([config.seed, PAIRS.index(pair), number])
    sampling = _sampling(config)
    oracle = Oracle.load(config.robot)
    layout = oracle.robot.layout
    leg = TRAINED_LEG[pair]
    count = min(SAMPLES_PER_SHARD, config.maps - number * SAMPLES_PER_SHARD)
    heights, costs, reasons, poses, families, courses = [], [], [], [], [], []
    for index in range(count):
        if index % SAMPLES_PER_COURSE == 0:
            family, seed, course = sampling.draw_course(rng)
        pose = sampling.draw_pose(rng, course, layout)
        local_map = _local_map(config, layout, course, pose, leg)
        cells = local_map.heights
        if rng.random() < sampling.holes:
            cells = punch_holes(cells, rng)
        steps = encode_heights(cells)
        # The stored pose is what the label is made for, to the last bit.
        kept = np.array(pose.as_list(), dtype=np.float32)
        rounded = LocalMap(decode_heights(steps), local_map.resolution, local_map.hip, local_map.yaw)
        label = oracle.label(rounded, leg, float(kept[3]), float(kept[4]))
        heights.append(steps)
        costs.append(label.cost_image)
        reasons.append(label.reason)
        poses.append(kept)
        families.append(family)
        courses.append(seed)
    return Samples(
        np.array(heights), np.array(costs), np.array(reasons), np.array(poses), np.array(families), np.array(courses)
    )


def _sampling(config: DatasetConfig) -> SamplingRecipe:
    return SamplingRecipe.of(config.recipe, config.families, config.exclude, map_seed=config.seed)


def _local_map(config: DatasetConfig, layout: LegLayout, course: Any, pose: Any, leg: str) -> LocalMap:
    """The paper cuts, rotates and crops; otherwise the course is sampled at the rotated cell centres."""
    if config.recipe == "paper":
        return extract_local_map_as_paper(course, layout.hip_position(leg, pose), pose.yaw, layout.resolution)
    return layout.local_map(course, pose, leg)


def _make_shard(config: DatasetConfig, out: Path, pair: str, number: int) -> None:
    write_shard(shard_path(out, pair, number), make_samples(config, pair, number))


def _claim(config: DatasetConfig, out: Path) -> None:
    """Write the configuration into an empty folder, or check that it is the folder's."""
    path = out / CONFIG
    wanted = json.loads(json.dumps(asdict(config)))
    if path.exists():
        found = json.loads(path.read_text(encoding="utf-8"))
        if found != wanted:
            raise InputError(f"{out} holds a dataset of another configuration", "choose another folder or delete it")
        return
    out.mkdir(parents=True, exist_ok=True)
    if any(out.iterdir()):
        raise InputError(f"{out} is not empty and holds no dataset", "choose another folder")
    write_json(path, wanted)


def _versions() -> dict[str, str]:
    import coal
    import pinocchio

    return {
        "footsel": footsel.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "coal": coal.__version__,
        "pinocchio": pinocchio.__version__,
        "machine": f"{platform.machine()} {os.name}",
    }
