"""Fixed layers: differences of heights to float32 rounding, whatever the arithmetic around them; from them the label's
terrain features."""

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import InputEncoding
from footsel.learning.footing import Footing, FootSurface, Neighbours
from footsel.learning.grid import STEPS, on_grid
from footsel.oracle import terrain_cost
from footsel.oracle.terrain_cost import foot_surface, terrain_costs, terrain_features
from footsel.robot import load_robot

ROBOT = load_robot("anymal_b")
RANGE = ROBOT.layout.height_range
WEIGHTS = terrain_cost.STENCIL[:, 2]
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
        found = Neighbours(RANGE, WEIGHTS)(*inputs(heights))
    assert found.dtype == torch.float32 and found.shape == (2, Neighbours.CHANNELS, 40, 40)
    for index, (i, j) in enumerate(NEIGHBOURS):
        drop = np.nan_to_num((heights - neighbour(heights, i, j)) / terrain_cost.LARGEST_DROP, nan=1)
        # 1e-4 of 5 cm: 5 micrometres. In bfloat16 heights alone would be 2 mm off.
        np.testing.assert_allclose(found[:, index].numpy(), np.clip(drop, -1, 1), atol=1e-4)


def test_drops_of_depths_on_the_grid_are_exact():
    """In float32 as in float64, so in any order of sums: engines cannot disagree."""
    depth, known = inputs(rough(4, 0.1))
    layer, depth = Neighbours(RANGE, WEIGHTS), on_grid(depth)
    exact = Neighbours(RANGE, WEIGHTS).double()
    planes = torch.cat([depth * known, known], dim=1).double()
    sums = torch.nn.functional.conv2d(planes, exact.weight, exact.bias, padding=2).clamp(-1, 1)
    assert torch.equal(layer(depth, known)[:, :-1].double(), sums[:, :-1])
    assert torch.equal(on_grid(depth), depth)


@pytest.mark.parametrize("holes", [0.0, 0.1, 0.6])
def test_it_is_the_terrain_cost_of_the_label(arithmetic, holes):
    """On slopes, at edges and among holes, at the map's border too."""
    heights = rough(1, holes)
    with arithmetic:
        found = Footing(ROBOT.layout)(*inputs(heights)).numpy()
    assert found.dtype == np.float32 and found.shape == (2, Footing.CHANNELS, 1600)
    for planes, there in zip(found, heights, strict=True):
        k1, k2, share = terrain_features(there, 0.02)
        cells = ~np.isnan(there)
        expected = np.stack([k1, k2, k1 * share, k2 * share, share, terrain_costs(there, 0.02)])
        np.testing.assert_allclose(planes.reshape(-1, 40, 40)[:, cells], expected[:, cells], atol=2e-4)
        assert holes > 0.5 or np.ptp(expected[5, cells]) > 0.5


def test_a_cell_alone_is_as_bad_as_can_be():
    heights = np.full((1, 40, 40), np.nan, dtype=np.float32)
    heights[0, 20, 20] = -0.5
    found = Footing(ROBOT.layout)(*inputs(heights))[0, :, 20 * 40 + 20]
    # What unknown neighbours add to the sums is taken off again but for rounding, and divided by the least share.
    torch.testing.assert_close(found, torch.tensor([0.0, 0, 0, 0, 0, 1]), atol=1e-4, rtol=0)


def test_the_foot_s_surface_is_that_of_the_label(arithmetic):
    """Unknown and outer cells hold no foot; above the depth where the image ends."""
    heights = rough(2)
    depth, known = inputs(heights)
    with arithmetic:
        found = FootSurface(ROBOT.layout)(depth, known)[:, 0].numpy()
    for index in range(2):
        expected = -foot_surface(heights[index], 0.02) / RANGE
        cells = ~np.isnan(expected)
        # Half a step of the grid, for what the foot sinks in is on it.
        np.testing.assert_allclose(found[index][cells], expected[cells], atol=0.51 / STEPS)


def test_unknown_cells_and_the_border_are_as_deep_as_a_drop_can_be_and_not_in_the_share():
    heights = np.full((1, 40, 40), -0.5, dtype=np.float32)
    heights[0, 10, 10] = np.nan
    unknown = np.isnan(np.stack([neighbour(heights, i, j) for i, j in NEIGHBOURS], axis=1))
    # On the grid, where sums are exact: off it level ground is level but for rounding, of which cores differ.
    depth, known = inputs(heights)
    found = Neighbours(RANGE, WEIGHTS)(on_grid(depth), known).numpy()
    here = ~np.isnan(heights[0])
    np.testing.assert_array_equal(found[:, :-1, here], unknown[:, :, here])
    share = np.tensordot(1 - unknown, WEIGHTS, axes=(1, 0)) / WEIGHTS.sum()
    np.testing.assert_allclose(found[:, -1][:, here], share[:, here], atol=1e-6)


def test_sums_are_as_if_unknown_neighbours_were_on_a_level():
    """Neither lower nor higher, whatever else lies around; of an unknown cell they are 0."""
    heights = np.full((1, 40, 40), -0.5, dtype=np.float32)
    heights[0, 10, 10], heights[0, 20, 20] = np.nan, -0.47
    drops = Footing(ROBOT.layout)(*inputs(heights))[0, 2:4].reshape(2, 40, 40)
    far = np.ones((40, 40), dtype=bool)
    far[17:24, 17:24] = False
    assert drops[:, far].abs().max() < 1e-5
    assert drops[1, 20, 20] > 0.1
