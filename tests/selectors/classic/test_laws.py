"""What holds for every classic scorer, whoever wrote its source."""

import subprocess
import sys

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.footholds.request import prepare
from footsel.legs import LEGS
from footsel.selectors import SELECTORS
from footsel.selectors.classic import SCORERS
from footsel.selectors.registry import CLASSIC
from footsel.terrain import ElevationMap
from footsel.terrain.courses import make_course

STANDING = BasePose(0.003, 0.004, 0.47)
MIDDLE = (20, 20)


def holed_course(seed: int, cells: int = 40) -> np.ndarray:
    """A cut-out of rubble with unknown cells, heights in [m]."""
    rng = np.random.default_rng(seed)
    heights = make_course("rubble", seed).elevation[100 : 100 + cells, 120 : 120 + cells].astype(np.float64)
    return np.where(rng.random(heights.shape) < 0.1, np.nan, heights)


def test_flat_ground_gives_the_nominal_cell(scorer):
    flat = ElevationMap(np.full((200, 200), 0.1), 0.02)
    for foothold in scorer.select(flat, STANDING).values():
        assert foothold.status == "ok" and foothold.cost == pytest.approx(0.0, abs=1e-6)
        assert foothold.distance_to_nominal <= 0.01 * np.sqrt(2) + 1e-9


def test_edges_of_stairs_are_worse_than_the_middle_of_a_tread(scorer, ground):
    """Treads of 32 cm: one from x = -16 to 16 cm, a rise of 15 cm beyond, a fall of 15 cm before it."""
    stairs = ground.sample(lambda x, _: 0.15 * np.floor((x + 0.16) / 0.32 + 1e-9))
    judgement = scorer.judge(stairs, 0.02)
    badness = ground.effective(judgement)
    assert judgement.acceptable[MIDDLE]
    for beside_an_edge in (12, 27):
        assert badness[beside_an_edge, 20] > badness[MIDDLE] + 0.25


@pytest.mark.parametrize("direction", [0.0, 90.0, 30.0, -135.0])
def test_a_steeper_slope_is_never_cheaper(scorer, ground, direction):
    slopes = np.deg2rad(np.arange(0.0, 66.0, 3.0))
    badness = [
        ground.effective(scorer.judge(ground.sample(ground.plane(slope, np.deg2rad(direction))), 0.02))[MIDDLE]
        for slope in slopes
    ]
    assert (np.diff(badness) >= -1e-9).all()
    assert badness[-1] > badness[0] + 0.25


def test_mirrored_and_turned_ground_is_judged_alike(scorer, ground):
    heights = holed_course(1)
    judged = ground.effective(scorer.judge(heights, 0.02))
    assert judged[~np.isnan(heights)].std() > 0.05
    for turn in (np.fliplr, np.flipud, np.transpose, np.rot90):
        turned = ground.effective(scorer.judge(np.ascontiguousarray(turn(heights)), 0.02))
        np.testing.assert_allclose(turned, turn(judged), atol=1e-9)


def test_how_deep_the_ground_lies_is_not_judged(scorer, ground):
    """Kinematics is not a scorer's business."""
    heights = holed_course(2)
    here, there = (ground.effective(scorer.judge(heights - depth, 0.02)) for depth in (0.0, 2.5))
    np.testing.assert_allclose(here, there, atol=1e-6)


def test_doubled_heights_are_never_better(scorer, ground):
    rng = np.random.default_rng(3)
    rough = ground.sample(ground.bumps) + 0.003 * rng.standard_normal((40, 40))
    once, twice, thrice = (ground.effective(scorer.judge(factor * rough, 0.02)) for factor in (1.0, 2.0, 4.0))
    assert (twice >= once - 1e-9).all() and (thrice >= twice - 1e-9).all()
    assert thrice.mean() > once.mean() + 0.1


def test_windows_are_fixed_in_metres(scorer, ground):
    """The same waves in cells of 1, 2 and 4 cm are judged alike; cells taken for others of another size are not."""

    def waves(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 1.5 * ground.bumps(x, y)

    def means(side: float, pretended: float) -> np.ndarray:
        """Badness by squares of 4 cm, without the map's border, of cells that the scorer is told are `pretended`."""
        judged = ground.effective(scorer.judge(ground.sample(waves, side), pretended))
        cells = round(0.04 / side)
        return judged.reshape(20, cells, 20, cells).mean(axis=(1, 3))[4:-4, 4:-4]

    fine, middle, coarse = (means(side, side) for side in (0.01, 0.02, 0.04))
    off = np.abs(fine - coarse).mean()
    assert np.abs(fine - middle).mean() < 0.06 and off < 0.09
    wrong = max(np.abs(fine - means(*sides)).mean() for sides in ((0.04, 0.01), (0.01, 0.04)))
    assert wrong > max(3 * off, 0.08)


def test_an_island_among_unknown_cells_is_refused(scorer):
    heights = np.full((40, 40), np.nan)
    heights[3::8, 3::8] = 0.0
    # Wider windows reach the next island; the one under the foot does not.
    assert not scorer.judge(heights, 0.02).acceptable.any()


def test_unknown_cells_are_refused_and_costs_are_costs(scorer):
    for seed in range(4):
        heights = holed_course(seed)
        elevation = np.full((200, 200), np.nan)
        elevation[80:120, 80:120] = heights
        elevation_map = ElevationMap(elevation, 0.02)
        for request in prepare(scorer.layout, elevation_map, STANDING, LEGS):
            scores = scorer.score(request)
            assert not (scores.feasible & ~request.local_map.known).any()
            assert np.isfinite(scores.cost).all() and scores.cost.min() >= 0 and scores.cost.max() <= 254


def test_none_is_said_with_what_was_refused(scorer):
    elevation = np.full((200, 200), np.nan)
    elevation[::8, ::8] = 0.0
    for foothold in scorer.select(ElevationMap(elevation, 0.02), BasePose(0.0, 0.0, 0.47)).values():
        assert foothold.status == "none" and foothold.position is None
        assert foothold.reason.startswith("no known cell is acceptable: ")
        assert any(character.isdigit() for character in foothold.reason)


def test_names_are_those_of_the_registry():
    assert tuple(SCORERS) == CLASSIC
    assert set(CLASSIC) < set(SELECTORS)


def test_the_room_of_selectors_loads_no_scorer():
    """Their names are known without scipy, which the bare installation does not have; the scorers do load it."""
    code = "import sys, footsel.selectors{}; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code.format("")], check=False).returncode == 0
    assert subprocess.run([sys.executable, "-c", code.format(".classic")], check=False).returncode == 1
