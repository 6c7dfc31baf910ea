"""A small set of maps with a rule that a network can learn: no oracle needed, made in milliseconds."""

import numpy as np
import pytest
import torch

from footsel.dataset.config import DatasetConfig
from footsel.dataset.labelling import make_samples as labelled_samples
from footsel.dataset.samples import Samples, encode_heights
from footsel.footholds import LegLayout, Reason
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.train import TrainingData
from footsel.legs import LEGS
from footsel.robot import load_robot


def stepped_maps(count, seed):
    """Maps with one step each: cells near the edge of the step are dear, far cells and the high side are infeasible."""
    rng = np.random.default_rng(seed)
    i, j = np.meshgrid(np.arange(40), np.arange(40), indexing="ij")
    edge = rng.integers(8, 32, count)[:, None, None]
    high = i[None] >= edge
    heights = np.where(high, -0.3, -0.45) + rng.normal(0, 0.002, (count, 40, 40))
    unknown = rng.random((count, 40, 40)) < 0.02
    reason = np.full((count, 40, 40), Reason.FEASIBLE, dtype=np.uint8)
    reason[high & (j > 30)[None]] = Reason.TERRAIN_COLLISION
    reason[:, np.hypot(i - 19.5, j - 19.5) > 18] = Reason.KINEMATIC_RANGE
    reason[unknown] = Reason.UNKNOWN
    cost = np.clip(200 - 20 * np.abs(i[None] - edge), 0, 254)
    pose = np.zeros((count, 6), dtype=np.float32)
    pose[:, 3:5] = rng.uniform(-0.17, 0.17, (count, 2))
    return Samples(
        heights_tenth_mm=encode_heights(np.where(unknown, np.nan, heights)),
        cost=np.where(reason == Reason.FEASIBLE, cost, 255).astype(np.uint8),
        reason=reason,
        pose=pose,
        family=np.array(["steps", "blocks"])[np.arange(count) % 2],
        course=1000 * seed + np.arange(count, dtype=np.int64),
    )


@pytest.fixture(autouse=True)
def one_thread():
    """Tiny batches gain nothing from a second thread, and two would fight over a busy machine's cores."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def layout():
    sign = {"LF": (1, 1), "RF": (1, -1), "LH": (-1, 1), "RH": (-1, -1)}
    return LegLayout(
        hips={leg: np.array([0.32 * sign[leg][0], 0.22 * sign[leg][1], -0.02]) for leg in LEGS},
        nominal_feet={leg: np.array([0.36 * sign[leg][0], 0.25 * sign[leg][1], -0.46]) for leg in LEGS},
        resolution=0.02,
        height_range=0.85,
        foot_radius=0.031,
    )


@pytest.fixture(scope="session")
def robot():
    return load_robot("anymal_b")


@pytest.fixture(scope="session")
def obstacles():
    """Maps of terrain that legs collide with, labelled by the oracle."""
    families = ("pillars", "stones", "rubble")
    config = DatasetConfig("anymal_b", ("front",), 60, 3, "footsel", families, maps_per_shard=60)
    return labelled_samples(config, "front", 0)


@pytest.fixture(scope="session")
def skeleton():
    return LegSkeleton.of(load_robot("anymal_b"), "LF")


@pytest.fixture
def data(layout, skeleton):
    dataset = {"maps": 30}, "0" * 64
    return TrainingData("front", stepped_maps(24, 1), stepped_maps(6, 2), "anymal_b", layout, skeleton, *dataset)


@pytest.fixture(scope="session")
def make_samples():
    """(count, seed) -> Samples, for fixtures that outlive a test."""
    return stepped_maps


@pytest.fixture
def samples():
    return stepped_maps(10, 5)


@pytest.fixture(scope="session")
def flat():
    """{"cells.accuracy": ...}, of dictionaries and lists within dictionaries and lists."""

    def flatten(figures, name=""):
        if not isinstance(figures, dict | list):
            return {name: figures}
        parts = figures.items() if isinstance(figures, dict) else enumerate(figures)
        return {key: value for part, inner in parts for key, value in flatten(inner, f"{name}.{part}").items()}

    return flatten
