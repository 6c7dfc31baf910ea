"""The ground along a leg: looked up where it should be, in full precision, at points that can be learnt."""

import numpy as np
import pytest
import torch
from scipy import ndimage

from footsel.learning.along_leg import POINTS, STEP, AlongLeg
from footsel.learning.place import Place
from footsel.learning.relief import LARGEST_RISE


@pytest.fixture
def maps():
    """Depth and what is known of it, (2, 1, 40, 40)."""
    rng = np.random.default_rng(0)
    depth = ndimage.gaussian_filter(rng.uniform(0.2, 0.9, (2, 1, 40, 40)), (0, 0, 1, 1)).astype(np.float32)
    known = (rng.random(depth.shape) > 0.1).astype(np.float32)
    return torch.from_numpy(np.where(known > 0, depth, np.float32(1))), torch.from_numpy(known)


def places(layout, depth):
    level = torch.zeros(len(depth), 1, 1, 1)
    return Place(layout)(depth, level, level)


def expected(depth, known, rows, columns, index):
    """(40, 40) rise of the highest of 3x3 at cells (rows, columns), between cells too, over the ground of each cell."""
    height = ((1 - depth) * known)[index, 0].numpy()
    highest = ndimage.maximum_filter(height, 3, mode="constant", cval=0)
    ground = ndimage.map_coordinates(np.pad(highest, 1), [rows + 1, columns + 1], order=1, mode="constant")
    return (ground - height) * 0.85 / LARGEST_RISE


@pytest.mark.parametrize("bfloat16", [False, True])
def test_points_begin_on_the_line_from_foot_to_hip(layout, maps, bfloat16):
    depth, known = maps
    with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
        found = AlongLeg(layout)(places(layout, depth), depth, known)
    assert found.shape == (2, POINTS, 40, 40) and found.dtype == torch.float32
    i, j = np.meshgrid(np.arange(40) - 19.5, np.arange(40) - 19.5, indexing="ij")
    for point in range(POINTS):
        left = 1 - (point + 1) / (POINTS + 1)
        for index in range(2):
            wanted = expected(depth, known, 19.5 + left * i, 19.5 + left * j, index)
            np.testing.assert_allclose(found[index, point].detach().numpy(), wanted, atol=1e-4)


def test_an_output_of_one_moves_a_point_by_a_step_along_its_axis(layout, maps):
    """Columns first, as grid_sample counts."""
    depth, known = maps
    layer = AlongLeg(layout)
    with torch.no_grad():
        layer.points[-1].bias[0:2] = torch.tensor([0.5, -1.0])
        found = layer(places(layout, depth), depth, known)
    i, j = np.meshgrid(np.arange(40) - 19.5, np.arange(40) - 19.5, indexing="ij")
    left = 1 - 1 / (POINTS + 1)
    rows, columns = 19.5 + left * i - STEP * 20, 19.5 + left * j + 0.5 * STEP * 20
    np.testing.assert_allclose(found[0, 0].numpy(), expected(depth, known, rows, columns, 0), atol=1e-4)


def test_points_are_learnt(layout, maps):
    """An obstacle beside the line is found by going downhill on a loss."""
    depth, known = maps
    layer = AlongLeg(layout)
    layer(places(layout, depth), depth, known).square().sum().backward()
    assert layer.points[-1].bias.grad.abs().min() > 0
