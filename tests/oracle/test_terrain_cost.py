"""The terrain cost obeys physics: steeper and nearer to an edge is never cheaper, and cell size does not matter."""

import numpy as np
import pytest

from footsel.oracle.terrain_cost import terrain_costs

CELL = 0.02


def plane(slope: float, direction: float, resolution: float = CELL) -> np.ndarray:
    along = (np.arange(9) - 4) * resolution
    x, y = np.meshgrid(along, along, indexing="ij")
    return slope * (x * np.cos(direction) + y * np.sin(direction))


def middle_cost(heights: np.ndarray, resolution: float = CELL) -> float:
    n = len(heights) // 2
    return float(terrain_costs(heights, resolution)[n, n])


def test_flat_ground_costs_nothing() -> None:
    assert middle_cost(np.zeros((9, 9))) == 0.0
    assert middle_cost(np.full((9, 9), -3.7)) == 0.0


@pytest.mark.parametrize("direction", np.linspace(0, np.pi, 7))
def test_cost_never_falls_with_slope(direction: float) -> None:
    costs = [middle_cost(plane(np.tan(angle), direction)) for angle in np.deg2rad(np.arange(0, 46))]
    assert (np.diff(costs) >= 0).all()
    assert costs[10] < 0.1
    assert costs[45] > 0.5


@pytest.mark.parametrize("resolution", [0.01, 0.04])
def test_a_plane_costs_the_same_at_any_cell_size(resolution: float) -> None:
    assert middle_cost(plane(0.4, 0.3, resolution), resolution) == pytest.approx(middle_cost(plane(0.4, 0.3)))


@pytest.mark.parametrize("rise", [0.03, 0.05, 0.08])
def test_the_upper_edge_of_a_step_is_worse_than_its_foot(rise: float) -> None:
    step = np.where(np.arange(9)[:, None] <= 4, rise, 0.0) * np.ones((1, 9))
    costs = terrain_costs(step, CELL)
    assert costs[4, 4] >= 0.5
    assert costs[4, 4] > costs[5, 4] > costs[7, 4] == 0.0


def test_missing_neighbours_raise_the_cost() -> None:
    heights = plane(0.1, 0.0)
    before = middle_cost(heights)
    costs = [before]
    for cell in ((3, 3), (3, 4), (3, 5), (4, 3), (4, 5), (5, 3), (5, 4), (5, 5)):
        heights[cell] = np.nan
        costs.append(middle_cost(heights))
    assert costs[-1] == 1.0
    assert min(costs[1:]) > before
    flat = np.zeros((9, 9))
    assert terrain_costs(flat, CELL)[0, 0] == pytest.approx(5 / 8)
    assert np.isnan(terrain_costs(np.full((9, 9), np.nan), CELL)).all()


def test_cost_is_symmetric_in_all_directions() -> None:
    rng = np.random.default_rng(0)
    heights = rng.normal(0, 0.02, (9, 9))
    cost = middle_cost(heights)
    for turned in (np.rot90(heights), heights[::-1], heights.T):
        assert middle_cost(turned) == pytest.approx(cost)


def test_costs_lie_in_zero_to_one() -> None:
    rng = np.random.default_rng(1)
    costs = terrain_costs(rng.normal(0, 1.0, (40, 40)), CELL)
    assert costs.min() >= 0 and costs.max() <= 1
