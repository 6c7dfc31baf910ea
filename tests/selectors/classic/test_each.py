"""What is particular to each classic scorer."""

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.footholds.request import prepare
from footsel.selectors.classic import barasuol, chen_kumar, kolter, krotkov, roennau, traversability
from footsel.terrain import ElevationMap
from footsel.terrain.courses import make_course

MIDDLE = (20, 20)


def pit(depth: float, radius: float = 0.05):
    return lambda x, y: np.where(np.hypot(x - 0.01, y - 0.01) < radius, -depth, 0.0)


# Rebula


def test_rebula_names_what_it_rejects(make_scorer, ground):
    scorer = make_scorer("rebula")

    def refused(surface) -> dict[str, np.ndarray]:
        return scorer.judge(ground.sample(surface), 0.02).rejected

    step = refused(lambda x, _: np.where(x > 0, 0.15, 0.0))
    assert step["on an edge"][20, 20] and not step["on an edge"][19, 20]
    assert step["at the base of a cliff"][19, 20] and not step["at the base of a cliff"][20, 20]
    assert step["at the base of a cliff"][16, 20] and not step["on an edge"][16, 20]
    assert refused(pit(0.05))["inside a hole"][MIDDLE]
    assert not refused(pit(-0.05))["inside a hole"].any()
    assert not step["inside a hole"].any()


@pytest.mark.parametrize("direction", np.deg2rad([0.0, 22.5, 45.0, 70.0]))
def test_rebula_takes_no_even_slope_for_anything_else(make_scorer, ground, direction):
    scorer = make_scorer("rebula")
    gentle = scorer.judge(ground.sample(ground.plane(np.deg2rad(29.5), direction)), 0.02)
    assert gentle.acceptable.all()
    steep = scorer.judge(ground.sample(ground.plane(np.deg2rad(30.5), direction)), 0.02)
    assert steep.rejected["on too steep a slope"].all() and not steep.rejected["inside a hole"].any()


# Krotkov


def test_krotkov_weighs_inclination_roughness_and_curvature(make_scorer, ground):
    """Each alone brings the unit half way, all three together further."""
    scorer = make_scorer("krotkov")

    def badness(surface) -> float:
        return scorer.judge(ground.sample(surface), 0.02).badness[MIDDLE]

    def bowl(x, y, curvature=krotkov.CURVATURE):
        return curvature / 2 * ((x - 0.01) ** 2 + (y - 0.01) ** 2)

    assert badness(ground.plane(krotkov.INCLINATION)) == pytest.approx(0.5, abs=0.01)
    # Of a bowl, the curvature and the little roughness that goes with it; a dome counts as much.
    assert 0.5 < badness(bowl) < 0.95
    assert badness(bowl) == pytest.approx(badness(lambda x, y: -bowl(x, y)))
    # A saddle of the same curvatures, one up and one down, has none in the mean: roughness is left.
    saddle = badness(lambda x, y: krotkov.CURVATURE / 2 * ((x - 0.01) ** 2 - (y - 0.01) ** 2))
    assert 0.0 < saddle < badness(bowl) - 0.2
    assert badness(lambda x, y: bowl(x, y) + 0.5 * x) > badness(bowl)


def test_krotkov_ranks_all_ground_and_refuses_none(make_scorer):
    heights = np.random.default_rng(0).normal(0.0, 1.0, (40, 40))
    assert make_scorer("krotkov").judge(heights, 0.02).acceptable.all()


# Kolter


def test_kolter_sums_twenty_features(make_scorer):
    rng = np.random.default_rng(1)
    heights = np.where(rng.random((40, 40)) < 0.2, np.nan, rng.normal(0.0, 0.03, (40, 40)) - 0.5)
    cells = [(0, 39), (3, 17), (20, 20), (38, 1), (25, 9)]
    heights[tuple(np.transpose(cells))] = -0.47
    badness = make_scorer("kolter").judge(heights, 0.02).badness
    for i, j in cells:
        features = []
        for reach in (2, 3, 5, 10):
            rows, columns = slice(max(i - reach, 0), i + reach + 1), slice(max(j - reach, 0), j + reach + 1)
            z = heights[rows, columns]
            a, b = np.nonzero(~np.isnan(z))
            known = z[a, b]
            _, slope_x, slope_y = np.linalg.lstsq(
                np.stack([np.ones(len(a)), a * 0.02, b * 0.02], axis=1), known, rcond=None
            )[0]
            full = np.tile(np.arange(2 * reach + 1) * 0.02, (2 * reach + 1, 1)).std()
            rise, depth = (known.max() - heights[i, j]), (heights[i, j] - known.min())
            width = reach * 0.02
            features += [abs(slope_x), abs(slope_y), rise / width, depth / width, known.std() / full]
        assert badness[i, j] == pytest.approx(np.minimum(features, 1.0).mean(), abs=1e-9)


def test_kolter_calls_each_feature_one_at_45_degrees(make_scorer, ground):
    """All but the slope across it."""
    badness = make_scorer("kolter").judge(ground.sample(ground.plane(np.pi / 4)), 0.02).badness
    np.testing.assert_allclose(badness[10:-10, 10:-10], 0.8, atol=1e-9)


def test_kolter_looks_further_than_a_foot(make_scorer, ground):
    """A wall 15 cm away lies in the widest window alone."""
    wall = ground.sample(lambda x, _: np.where(x > 0.16, 0.2, 0.0))
    badness = make_scorer("kolter").judge(wall, 0.02).badness
    features = kolter._Sums(wall, 0.02)
    assert [features.features(half)[2][MIDDLE] for half in kolter.HALF_WIDTHS] == pytest.approx([0, 0, 0, 1])
    assert 0 < badness[MIDDLE] < 0.2


# Roennau


def test_roennau_pays_for_what_it_has_not_seen(make_scorer):
    scorer = make_scorer("roennau")
    heights = np.zeros((40, 40))
    rng = np.random.default_rng(2)
    order = rng.permutation([(i, j) for i in range(17, 24) for j in range(17, 24) if (i, j) != MIDDLE])
    costs = []
    for i, j in order:
        heights[i, j] = np.nan
        judgement = scorer.judge(heights, 0.02)
        share = 1.0 - judgement.badness[MIDDLE]
        costs.append(judgement.badness[MIDDLE])
        assert judgement.acceptable[MIDDLE] == (share >= 0.5)
    assert (np.diff(costs) >= 0).all() and costs[-1] == pytest.approx(1 - 1 / 29)


def test_roennau_tells_a_cell_off_the_mean_from_an_even_one(make_scorer, ground):
    """A slope and a dip of the same variance: on the slope the mean is the cell's own height."""
    scorer = make_scorer("roennau")
    dip = ground.sample(pit(0.03, radius=0.03))
    in_window = np.hypot(*(np.indices((40, 40)) - 20)) <= 3
    spread = dip[in_window].std() / ground.sample(lambda x, _: x)[in_window].std()
    slope = ground.sample(lambda x, _: spread * x)
    in_dip, on_slope = (scorer.judge(heights, 0.02).badness[MIDDLE] for heights in (dip, slope))
    assert in_dip - on_slope == pytest.approx((dip[in_window].mean() - dip[MIDDLE]) / roennau.FROM_MEAN / 2)


# Chen and Kumar


def test_chen_kumar_holds_with_the_probability_that_errors_give():
    rng = np.random.default_rng(3)
    for rise in (0.0, 0.02, 0.04, -0.05, 0.1):
        true = rise + chen_kumar.HEIGHT_ERROR * (rng.standard_normal(200_000) - rng.standard_normal(200_000))
        drawn = (np.abs(true) < chen_kumar.BAND).mean()
        assert chen_kumar._within_band(np.array([rise]))[0] == pytest.approx(drawn, abs=5e-3)


def test_chen_kumar_wants_support_on_all_four_sides(make_scorer, ground):
    """A ledge as wide as three cells, a pole, and unknown ground on one side."""
    scorer = make_scorer("chen_kumar")
    for surface in (lambda x, _: np.where(np.abs(x) < 0.02, 0.0, -0.5), lambda x, y: np.where(x + y < 0.01, 0.0, 0.5)):
        assert not scorer.judge(ground.sample(surface), 0.02).acceptable[MIDDLE]
    half_seen = ground.sample(lambda x, _: np.where(x > 0.02, np.nan, 0.0))
    judgement = scorer.judge(half_seen, 0.02)
    assert judgement.rejected["unlikely to support a foot"][MIDDLE] and judgement.acceptable[15, 20]


# Barasuol


def test_barasuol_takes_the_nearest_acceptable_cell(make_scorer):
    scorer = make_scorer("barasuol")
    course = make_course("stones", 6)
    for x in (-1.0, 0.0, 1.0):
        pose = BasePose(x, 0.2, 0.5, 0.0, 0.0, 0.4 * x)
        footholds = scorer.select(course, pose)
        for request in prepare(scorer.layout, course, pose):
            scores, foothold = scorer.score(request), footholds[request.leg]
            distances = request.local_map.distances_to(request.nominal[:2])
            assert (foothold.status == "ok") == bool(scores.feasible.any())
            if foothold.cell is not None:
                assert foothold.cost == 0.0
                assert distances[foothold.cell] == pytest.approx(distances[scores.feasible].min())


def test_barasuol_forgives_one_direction_off_level(make_scorer, ground):
    """Opposite stones keep the plane level, so that each is one direction of the pattern."""
    scorer = make_scorer("barasuol")
    for stones, accepted in (((), True), ((22,), True), ((22, 18), False)):
        heights = ground.sample(ground.plane(0.0))
        heights[list(stones), 20] = 0.07
        uneven = scorer.judge(heights, 0.02).rejected["of uneven pattern"]
        assert bool(uneven[MIDDLE]) is not accepted


def test_barasuol_keeps_the_shin_from_a_wall(make_scorer, ground):
    wall = ground.sample(lambda x, _: np.where(x > 0.0, 0.2, 0.0))
    rejected = make_scorer("barasuol").judge(wall, 0.02).rejected["against the shin"]
    reach = round(barasuol.SHIN_RADIUS / 0.02)
    assert rejected[20 - reach : 20, 20].all() and not rejected[: 20 - reach].any() and not rejected[20:].any()


# Traversability


def test_traversability_is_a_third_of_the_slope_on_planes(make_scorer, ground):
    scorer = make_scorer("traversability")
    for slope in (0.2, 0.6):
        badness = scorer.judge(ground.sample(ground.plane(slope, 1.1)), 0.02).badness
        np.testing.assert_allclose(badness, slope / traversability.CRITICAL_SLOPE / 3, atol=1e-9)


def test_traversability_refuses_what_is_critical(make_scorer, ground):
    scorer = make_scorer("traversability")
    for slope, refused in ((0.98, False), (1.02, True)):
        critical = scorer.judge(ground.sample(ground.plane(slope)), 0.02).rejected["of critical slope"]
        assert (critical == refused).all()
    for height, refused in ((0.119, False), (0.121, True)):
        step = ground.sample(lambda x, _, height=height: np.where(x > 0.0, height, 0.0))
        assert scorer.judge(step, 0.02).rejected["at a critical step"][MIDDLE] == refused
    needles = np.where(np.indices((40, 40)).sum(axis=0) % 2 == 0, 0.0, 0.11)
    assert scorer.judge(needles, 0.02).rejected["of critical roughness"][MIDDLE]


def test_traversability_counts_a_lone_step_by_its_cells(ground):
    """A pin of 20 cm: its range fills a disc of 13 cells; a window that holds two of them counts half."""
    pin = ground.sample(ground.plane(0.0))
    pin[MIDDLE] = 0.2
    steps = traversability._steps(pin, 0.02)
    cells = {(i, j) for i in range(40) for j in range(40) if np.hypot(i - 20, j - 20) <= 2}
    for cell in [(20, 20), (20, 22), (20, 24), (22, 22), (21, 23), (23, 22), (20, 25)]:
        near = sum(np.hypot(i - cell[0], j - cell[1]) <= 2 for i, j in cells)
        assert steps[cell] == pytest.approx(0.2 * min(near / 4, 1.0))


def test_unknown_ground_beyond_the_map_makes_no_answer(make_scorer):
    """The whole way through a selector: a map that ends under the robot."""
    elevation_map = ElevationMap(np.zeros((60, 60)), 0.02)
    for foothold in make_scorer("traversability").select(elevation_map, BasePose(0.0, 0.0, 0.47)).values():
        assert foothold.status == "ok"
        assert max(abs(foothold.position[0]), abs(foothold.position[1])) <= 0.6
