"""What a worker does: the samples of one shard, from (seed, pair, number of the shard) alone."""

from collections.abc import Iterator
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.dataset.config import DatasetConfig
from footsel.dataset.samples import Samples, decode_heights, encode_heights
from footsel.footholds.layout import LegLayout
from footsel.footholds.pose import BasePose
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.oracle import Oracle
from footsel.terrain import ElevationMap, LocalMap, extract_local_map_as_paper
from footsel.terrain.degradation import punch_holes

#: A Dask worker may run several threads; the oracle is not made for them, and they would wait for each other anyway.
_ONE_AT_A_TIME = Lock()


def prepare(config: DatasetConfig, pair: str) -> None:
    """Load what labelling a pair of legs needs; the first time, the oracle's tables are built (some 30 s)."""
    with _ONE_AT_A_TIME:
        oracle = Oracle.load(config.robot)
        ground = np.zeros((4, 4), dtype=np.float32)
        oracle.label(LocalMap(ground, oracle.robot.layout.resolution, np.zeros(3), 0.0), TRAINED_LEG[pair])


def make_samples(config: DatasetConfig, pair: str, number: int) -> Samples:
    """The samples of one shard."""
    with _ONE_AT_A_TIME:
        rows = list(_draw(config, pair, number))
    heights, costs, reasons, poses, families, courses = map(np.array, zip(*rows, strict=True))
    return Samples(heights, costs, reasons, poses, families, courses)


def _draw(config: DatasetConfig, pair: str, number: int) -> Iterator[tuple[Any, ...]]:
    """The fields of one sample after another."""
    rng = np.random.default_rng([config.seed, PAIRS.index(pair), number])
    sampling = config.sampling()
    oracle = Oracle.load(config.robot)
    layout = oracle.robot.layout
    leg = TRAINED_LEG[pair]
    for index in range(config.maps_in(number)):
        if index % config.maps_per_course == 0:
            family, seed, course = sampling.draw_course(rng)
        pose = sampling.draw_pose(rng, course, layout)
        local_map = _local_map(config, layout, course, pose, leg)
        cells = local_map.heights
        if rng.random() < sampling.holes:
            cells = punch_holes(cells, rng)
        yield *labelled(oracle, replace(local_map, heights=cells), leg, pose), family, seed


def labelled(oracle: Oracle, local_map: LocalMap, leg: str, pose: BasePose) -> tuple[NDArray[Any], ...]:
    """heights_tenth_mm, cost, reason and pose of a sample: one leg's local map of the base at a pose.

    The heights and the pose that are kept are what the label is made for, to the last bit.
    """
    steps = encode_heights(local_map.heights)
    kept = np.array(pose.as_list(), dtype=np.float32)
    label = oracle.label(replace(local_map, heights=decode_heights(steps)), leg, float(kept[3]), float(kept[4]))
    return steps, label.cost_image, label.reason, kept


def _local_map(config: DatasetConfig, layout: LegLayout, course: ElevationMap, pose: BasePose, leg: str) -> LocalMap:
    """The paper cuts, rotates and crops; otherwise the course is sampled at the rotated cell centres."""
    if config.recipe == "paper":
        return extract_local_map_as_paper(course, layout.hip_position(leg, pose), pose.yaw, layout.resolution)
    return layout.local_map(course, pose, leg)
