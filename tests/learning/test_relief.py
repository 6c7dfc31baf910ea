"""Fixed layers: differences of heights to float32 rounding, whatever the arithmetic around them; from them the label's
terrain features."""

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import InputEncoding
from footsel.learning import relief
from footsel.learning.relief import LARGEST_RISE, RISE_BLOCKS, Drops, FootSurface, KnownShares, Rises
from footsel.oracle import terrain_cost
from footsel.oracle.terrain_cost import RING_WEIGHTS, foot_surface, terrain_features
from footsel.robot import load_robot

ROBOT = load_robot("anymal_b")
RANGE = ROBOT.layout.height_range
NEIGHBOURS = [(i, j) for i in range(-2, 3) for j in range(-2, 3) if (i, j) != (0, 0)]


def rough(seed, holes=0.1):
    """(2, 40, 40) heights with steps, slopes and holes, above the depth where the image ends, in [m]."""
    rng = np.random.default_rng(seed)
    i, j = np.meshgrid(np.arange(40), np.arange(40), indexing="ij")
    heights = -0.45 + 0.003 * i - 0.002 * j + 0.1 * (i > 17) + rng.normal(0, 0.008, (2, 40, 40))
    return np.where(rng.random(heights.shape) < holes, np.nan, heights).astype(np.float32)


def inputs(heights):
    encoded = torch.from_numpy(InputEncoding(("height", "unknown"), False, RANGE).encode(heights))
    return encoded[:, :1], 1 - encoded[:, 1:]


def neighbour(heights, i, j):
    """Height of the cell (i, j) away, NaN beyond the map."""
    padded = np.pad(heights.astype(np.float64), ((0, 0), (2, 2), (2, 2)), constant_values=np.nan)
    return padded[:, 2 + i : 42 + i, 2 + j : 42 + j]


@pytest.fixture(params=[False, True], ids=["plain", "autocast"])
def arithmetic(request):
    return torch.autocast("cpu", torch.bfloat16, enabled=request.param)


def test_drops_are_differences_of_heights(arithmetic):
    heights = rough(0)
    with arithmetic:
        found = Drops(RANGE)(*inputs(heights))
    assert found.dtype == torch.float32 and found.shape == (2, Drops.CHANNELS, 40, 40)
    for index, (i, j) in enumerate(NEIGHBOURS):
        drop = np.nan_to_num((heights - neighbour(heights, i, j)) / terrain_cost.LARGEST_DROP)
        # 1e-4 of 5 cm: 5 micrometres. In bfloat16 heights alone would be 2 mm off.
        np.testing.assert_allclose(found[:, index].numpy(), np.clip(drop, 0, 1), atol=1e-4)
        np.testing.assert_allclose(found[:, 24 + index].numpy(), np.clip(-drop, 0, 1), atol=1e-4)


def test_the_terrain_features_of_the_label_follow(arithmetic):
    heights = rough(1)
    depth, known = inputs(heights)
    with arithmetic:
        drops = Drops(RANGE)(FootSurface(ROBOT.layout)(depth, known), known)
        shares = KnownShares()(known)
    weight = torch.tensor([RING_WEIGHTS[max(abs(i), abs(j)) - 1] for i, j in NEIGHBOURS])[None, :, None, None]
    lower, higher = drops[:, :24], drops[:, 24:]
    counts = torch.tensor([8 * RING_WEIGHTS[0], 16 * RING_WEIGHTS[1]])
    share = (shares * counts[:, None, None]).sum(1) / counts.sum()
    slope_response = sum(RING_WEIGHTS[max(abs(i), abs(j)) - 1] * abs(i) * terrain_cost.SPACING for i, j in NEIGHBOURS)
    scale = terrain_cost.LARGEST_DROP / share / slope_response
    for index in range(2):
        k1, k2, known_share = terrain_features(heights[index], 0.02)
        cells = ~np.isnan(k1) & (known_share > 0)
        for expected, found in (
            (k1, ((lower - higher) * weight).sum(1) * scale),
            (k2, ((lower + higher) * weight).sum(1) * scale),
            (known_share, share),
        ):
            np.testing.assert_allclose(found[index].numpy()[cells], expected[cells], atol=1e-4)


def test_the_foot_s_surface_is_that_of_the_label(arithmetic):
    """Unknown and outer cells hold no foot; above the depth where the image ends."""
    heights = rough(2)
    depth, known = inputs(heights)
    with arithmetic:
        found = FootSurface(ROBOT.layout)(depth, known)[:, 0].numpy()
    for index in range(2):
        expected = -foot_surface(heights[index], 0.02) / RANGE
        cells = ~np.isnan(expected)
        np.testing.assert_allclose(found[index][cells], expected[cells], atol=1e-6)


def test_the_drop_ends_where_that_of_the_label_does():
    assert relief.LARGEST_DROP == terrain_cost.LARGEST_DROP
    assert terrain_cost.SPACING == 0.02 and len(RING_WEIGHTS) == 2


def test_unknown_cells_and_the_border_are_neither_lower_nor_higher():
    heights = np.full((1, 40, 40), -0.5, dtype=np.float32)
    heights[0, 10, 10] = np.nan
    drops = Drops(RANGE)(*inputs(heights))
    assert drops.abs().max() < 1e-4
    shares = KnownShares()(inputs(heights)[1])
    assert shares[0, :, 20, 20].tolist() == [1, 1]
    assert shares[0, :, 11, 11].tolist() == [7 / 8, 1]
    assert shares[0, :, 0, 0].tolist() == [3 / 8, 5 / 16]


def test_rises_are_how_far_blocks_stand_out(arithmetic):
    heights = rough(2)
    with arithmetic:
        found = Rises(RANGE)(*inputs(heights)).numpy()
    assert found.shape[1] == Rises.CHANNELS
    filled = np.where(np.isnan(heights), -RANGE, heights).astype(np.float64)
    rng, channel = np.random.default_rng(0), 0
    for block, rings in RISE_BLOCKS:
        steps = range(-rings, rings + 1)
        for away in [(a * block, b * block) for a in steps for b in steps if (a, b) != (0, 0)]:
            for i, j in rng.integers(0, 40, (20, 2)):
                if np.isnan(heights[0, i, j]):
                    continue
                rows, columns = (np.arange(-(block // 2), block // 2 + 1) + at for at in (i + away[0], j + away[1]))
                centre_inside = 0 <= i + away[0] < 40 and 0 <= j + away[1] < 40
                rows, columns = rows[(rows >= 0) & (rows < 40)], columns[(columns >= 0) & (columns < 40)]
                highest = filled[0][np.ix_(rows, columns)].max() if centre_inside else -RANGE
                expected = np.clip((highest - filled[0, i, j]) / LARGEST_RISE, 0, 1)
                assert found[0, channel, i, j] == pytest.approx(expected, abs=1e-4)
            channel += 1
    assert channel == Rises.CHANNELS
