"""The shipped terrain cost obeys physics: steeper is never cheaper, edges are dear, and cell size does not matter."""

import json
from importlib import resources

import numpy as np
import pytest

from footsel.oracle.brute_force_terrain import terrain_cost as reference_cost
from footsel.oracle.terrain_cost import FOOT_RADIUS, TerrainCostModel, foot_surface, terrain_costs, terrain_features
from footsel.terrain import LocalMap
from footsel.walking.slip.touchdown import touchdown_heights

CELL = 0.02


def surface(height, resolution: float = CELL, half: float = 0.16) -> np.ndarray:
    """height(x, y) at the cells of a square whose middle cell is the origin."""
    n = round(half / resolution)
    along = np.arange(-n, n + 1) * resolution
    x, y = np.meshgrid(along, along, indexing="ij")
    return np.asarray(height(x, y), dtype=np.float64) + np.zeros(x.shape)


def middle_cost(height, resolution: float = CELL) -> float:
    heights = surface(height, resolution)
    n = len(heights) // 2
    return float(terrain_costs(heights, resolution)[n, n])


def plane(degrees: float, direction: float = 0.0):
    slope = np.tan(np.deg2rad(degrees))
    return lambda x, y: slope * (x * np.cos(direction) + y * np.sin(direction))


def test_flat_ground_costs_next_to_nothing() -> None:
    assert middle_cost(lambda x, y: 0 * x) < 0.05
    assert middle_cost(lambda x, y: 0 * x - 3.7) == middle_cost(lambda x, y: 0 * x)


@pytest.mark.parametrize("direction", np.linspace(0, np.pi, 9))
def test_cost_never_falls_with_slope(direction: float) -> None:
    costs = [middle_cost(plane(degrees, direction)) for degrees in np.arange(0, 45.5, 0.5)]
    assert (np.diff(costs) >= -1e-9).all()
    assert costs[10] < 0.1 and costs[-1] > 0.9


@pytest.mark.parametrize("rise", [0.03, 0.04, 0.05, 0.08, 0.15, 0.3])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_upper_edge_of_a_step_is_dear(rise: float, axis: int) -> None:
    assert middle_cost(lambda x, y: np.where((x, y)[axis] > 0.01, -rise, 0.0)) >= 0.5


@pytest.mark.parametrize("rise", [0.03, 0.1])
def test_an_edge_matters_no_further_than_the_foot_may_land(rise: float) -> None:
    edge = surface(lambda x, y: np.where(x > 0.01, -rise, 0.0))
    costs = terrain_costs(edge, CELL)[:, 8]
    assert costs[8] > costs[7] > costs[6] == pytest.approx(costs[4])
    assert costs[4] < 0.05


SURFACES = {
    "plane of 10 degrees": plane(10, 0.4),
    "plane of 20 degrees": plane(20, 1.1),
    "plane of 35 degrees": plane(35, 2.0),
    "gentle wave": lambda x, y: 0.02 * np.sin(x / 0.08) * np.cos(y / 0.1),
    "top of a bump": lambda x, y: 0.06 * np.exp(-(x**2 + y**2) / 0.02),
    "bowl": lambda x, y: 0.8 * (x**2 + y**2),
    "side of a bump": lambda x, y: 0.08 * np.exp(-((x - 0.08) ** 2 + y**2) / 0.02),
    "edge 6 cm away": lambda x, y: np.where(x > 0.061, -0.1, 0.0),
}


@pytest.mark.parametrize("resolution", [0.01, 0.04])
@pytest.mark.parametrize("name", SURFACES)
def test_cell_size_does_not_matter(name: str, resolution: float) -> None:
    assert middle_cost(SURFACES[name], resolution) == pytest.approx(middle_cost(SURFACES[name]), abs=0.1)


def test_a_plane_has_its_slope_for_k2_and_no_k1() -> None:
    for resolution in (0.01, 0.015, 0.02, 0.04):
        heights = surface(lambda x, y: 0.3 * x, resolution)
        n = len(heights) // 2
        k1, k2, share = (values[n, n] for values in terrain_features(heights, resolution))
        assert (k1, k2, share) == pytest.approx((0.0, 0.3, 1.0))


def test_ridges_have_positive_k1_and_pits_negative() -> None:
    ridge = terrain_features(surface(lambda x, y: -np.abs(x)), CELL)
    pit = terrain_features(surface(lambda x, y: np.abs(x)), CELL)
    assert ridge[0][8, 8] == pytest.approx(ridge[1][8, 8]) and ridge[0][8, 8] > 0
    assert pit[0][8, 8] == pytest.approx(-pit[1][8, 8])


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("rise", [0.005, 0.01, 0.02, 0.03, 0.05])
def test_the_upper_edge_costs_the_same_in_cells_of_any_size(rise: float, axis: int) -> None:
    edge = lambda x, y: np.where((x, y)[axis] > 0.01, -rise, 0.0)  # noqa: E731
    for resolution in (0.01, 0.04):
        assert middle_cost(edge, resolution) == pytest.approx(middle_cost(edge), abs=0.1)


def test_a_narrow_pit_holds_a_foot_and_a_spike_does_not() -> None:
    """Simulated slip: 0.14 in a pit of one cell, 0.9 on a spike, 0.9 at the foot of a step."""
    spot = lambda height: lambda x, y: np.where(np.hypot(x, y) < 0.01, height, 0.0)  # noqa: E731
    foot_of_step = middle_cost(lambda x, y: np.where(x > 0.01, 0.03, 0.0))
    for depth in (0.01, 0.02, 0.03, 0.1):
        assert middle_cost(spot(-depth)) < min(0.5, foot_of_step - 0.4)
    assert middle_cost(spot(0.02)) > 0.8


def test_sensor_noise_on_level_ground_costs_little() -> None:
    """Simulated slip costs 0.01 to 0.04 on noise of 1 mm, up to 0.14 of 2 mm."""
    rng = np.random.default_rng(0)
    for noise, most in ((0.001, 0.06), (0.002, 0.15)):
        costs = terrain_costs(rng.normal(0, noise, (60, 60)), CELL)[3:-3, 3:-3]
        assert costs.mean() < most


def test_the_foot_s_surface_is_where_a_ball_comes_to_rest() -> None:
    """Never above a lowered ball's lowest point, and equal to it where only the centres of cells can touch."""
    spikes = np.zeros((21, 21))
    spikes[5, 5], spikes[12, 14], spikes[13, 14], spikes[3, 16] = 0.005, 0.006, 0.004, -0.05
    rough = np.random.default_rng(1).normal(0, 0.02, (21, 21))
    inside = np.arange(3, 18)
    i, j = (axis.ravel() for axis in np.meshgrid(inside, inside, indexing="ij"))
    for heights in (spikes, rough):
        ball = touchdown_heights(heights, CELL, FOOT_RADIUS, (np.column_stack([i, j]) - 10) * CELL) - FOOT_RADIUS
        surface = foot_surface(heights, CELL)[i, j]
        assert (surface <= ball + 1e-12).all()
        assert np.median(ball - surface) < 0.002
    lone = np.full((9, 9), -1.0)
    lone[4, 4] = 0.0
    expected = touchdown_heights(lone, CELL, FOOT_RADIUS, np.zeros((1, 2)))[0] - FOOT_RADIUS
    assert foot_surface(lone, CELL)[4, 4] == pytest.approx(expected)


def test_unknown_ground_holds_no_foot() -> None:
    heights = np.zeros((9, 9))
    heights[4, 4], heights[4, 5] = -0.1, np.nan
    surface = foot_surface(heights, CELL)
    assert np.isnan(surface[4, 5]) and not np.isnan(surface[4, 4])
    heights[3:6, 3:6] = np.nan
    heights[4, 4] = -0.1
    assert foot_surface(heights, CELL)[4, 4] == -0.1


def test_the_unknown_is_dearer_than_the_known() -> None:
    """On ground of every kind, whatever is hidden; docs/terrain_cost.md says how much an edge can lose."""
    rng = np.random.default_rng(5)
    rises = []
    for spread in (0.0, 0.003, 0.01, 0.05):
        for _ in range(100):
            seen = rng.normal(0, spread, (9, 9)) + np.tensordot(rng.uniform(-0.5, 0.5, 2), surface_axes(), 1)
            hidden = rng.random((9, 9)) < rng.uniform(0.05, 0.4)
            hidden[4, 4] = False
            rises.append(terrain_costs(np.where(hidden, np.nan, seen), CELL)[4, 4] - terrain_costs(seen, CELL)[4, 4])
    assert np.percentile(rises, 2) > -0.03 and min(rises) > -0.15
    assert np.mean(np.greater(rises, 0)) > 0.85 and np.mean(rises) > 0.1


@pytest.mark.parametrize("rise", [0.03, 0.05, 0.1])
def test_an_edge_with_an_unknown_lower_side_is_no_cheaper_than_the_edge_seen(rise: float) -> None:
    seen = middle_cost(lambda x, y: np.where(x > 0.01, -rise, 0.0))
    assert middle_cost(lambda x, y: np.where(x > 0.01, np.nan, 0.0)) >= seen


def surface_axes() -> np.ndarray:
    """(2, 9, 9) x and y of a patch."""
    along = (np.arange(9) - 4) * CELL
    return np.stack(np.meshgrid(along, along, indexing="ij"))


def test_missing_neighbours_raise_the_cost() -> None:
    heights = surface(plane(5))
    costs = [terrain_costs(heights, CELL)[8, 8]]
    rings = [(i, j) for i in range(6, 11) for j in range(6, 11) if (i, j) != (8, 8)]
    # Opposite cells go together, so that what is left is still a plane's share.
    for i, j in rings[: len(rings) // 2]:
        heights[i, j] = heights[16 - i, 16 - j] = np.nan
        costs.append(terrain_costs(heights, CELL)[8, 8])
    assert costs[-1] == 1.0
    assert min(costs[1:]) > costs[0]
    flat = np.zeros((9, 9))
    assert terrain_costs(flat, CELL)[0, 0] > terrain_costs(flat, CELL)[0, 4] > terrain_costs(flat, CELL)[4, 4]
    assert np.isnan(terrain_costs(np.full((9, 9), np.nan), CELL)).all()


def test_cost_is_symmetric_in_all_directions() -> None:
    rng = np.random.default_rng(0)
    heights = rng.normal(0, 0.02, (9, 9))
    cost = terrain_costs(heights, CELL)[4, 4]
    for turned in (np.rot90(heights), heights[::-1], heights.T):
        assert terrain_costs(turned, CELL)[4, 4] == pytest.approx(cost)


@pytest.mark.parametrize("resolution", [0.01, 0.02, 0.03, 0.04])
def test_the_reference_agrees(resolution: float) -> None:
    rng = np.random.default_rng(3)
    for spread in (0.003, 0.02, 0.2):
        heights = rng.normal(0, spread, (12, 12)).astype(np.float32)
        heights[rng.random((12, 12)) < 0.15] = np.nan
        local_map = LocalMap(heights, resolution, np.zeros(3), 0.0)
        costs = terrain_costs(heights, resolution)
        assert costs[~np.isnan(heights)].min() >= 0 and costs[~np.isnan(heights)].max() <= 1
        for i, j in np.argwhere(~np.isnan(heights)).tolist():
            assert costs[i, j] == pytest.approx(reference_cost(local_map, (i, j)), abs=1e-9)


def test_the_model_and_the_map_agree() -> None:
    """The fit's own formula gives what a map gets."""
    rng = np.random.default_rng(4)
    heights = rng.normal(0, 0.01, (9, 9))
    k1, k2, _ = terrain_features(heights, CELL)
    assert TerrainCostModel.load().cost(k1[4, 4], k2[4, 4]) == pytest.approx(terrain_costs(heights, CELL)[4, 4])


def test_the_data_file_says_where_it_comes_from_and_how_good_it_is() -> None:
    values = json.loads((resources.files("footsel.oracle") / "terrain_cost.json").read_text(encoding="utf-8"))
    assert values["provenance"]["command"].startswith("footsel terrain-cost fit")
    figures = values["figures"]
    assert figures["fitted"]["placements"] + figures["held_out"]["placements"] >= 20_000
    assert figures["held_out"]["spearman_worst_quarter"] >= 0.8
    assert figures["held_out"]["spearman_mean_slip"] >= 0.8
