"""A map made of simulated depth images, against the terrain that they show."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel.errors import InputError
from footsel.mapping import D435, CameraModel, Capsule, ElevationMapping, FittedNoise, MappingConfig

SENSOR = D435(212, 120)
CAMERA = SENSOR.camera
#: As the default but for the lower bound of the variance, which hides what the filter makes of it.
UNBOUNDED = MappingConfig(variance=(1e-9, 0.01))
STEPS = (((0.9, -2, -1), (1.2, 2, 0.12)), ((1.2, -2, -1), (3, 2, 0.24)))
BLOCKS = (((0.7, -0.5, -1), (0.95, -0.2, 0.15)), ((0.8, 0.1, -1), (1.1, 0.4, 0.08)), ((1.4, -0.3, -1), (1.6, 0.3, 0.2)))


def look(mapping, scene, eye, seed, bodies=()):
    mapping.integrate(SENSOR.read(scene.depth(CAMERA, eye), np.random.default_rng(seed)), CAMERA, eye, bodies)


def truth(mapping, scene):
    grid = mapping.elevation_map()
    return scene.heights(grid.x(), grid.y())


def away_from_edges(heights, cells=3):
    """Where the terrain is even for some cells around."""
    even = np.ones_like(heights, dtype=bool)
    for i in range(-cells, cells + 1):
        for j in range(-cells, cells + 1):
            even &= np.abs(np.roll(heights, (i, j), axis=(0, 1)) - heights) < 0.015 * cells
    return even


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.3, 0.0), (-0.2, 0.15)])
def test_even_ground_has_no_bias_and_the_error_that_its_variance_says(worlds, slope):
    scene = worlds.Scene(slope=slope)
    errors, normalised = [], []
    for seed in range(6):
        mapping = ElevationMapping(UNBOUNDED)
        mapping.move(worlds.base_at(0, 0))
        for k in range(3):
            look(mapping, scene, worlds.placement(0, 0, 0.5), 100 * seed + k)
        error = mapping.elevation_map().elevation - truth(mapping, scene)
        known = np.isfinite(error)
        assert known.sum() > 5000
        errors.append(np.mean(error[known]))
        normalised.append(np.mean(error[known] ** 2 / mapping.variance[known]))
    # On a slope a reading that is too near or too far lands in another cell; there are more of one kind.
    assert abs(np.mean(errors)) < (1e-3 if any(slope) else 0.3e-3)
    # Slopes of 0.2 are reckoned with: what is less steep is known better than is said.
    assert 0.2 < np.mean(normalised) < 1.5


def test_terrain_is_known_to_millimetres_and_almost_all_of_what_is_in_view(worlds):
    scene = worlds.Scene(BLOCKS)
    mapping = ElevationMapping()
    for k in range(10):
        base = worlds.base_at(0.03 * k, 0.0)
        mapping.move(base)
        look(mapping, scene, worlds.placement(*base[:3, 3]), k)
    heights, found = truth(mapping, scene), mapping.elevation_map()
    even, known = away_from_edges(heights), found.known
    error = np.abs(found.elevation - heights)[even & known]
    assert error.mean() < 3e-3 and np.percentile(error, 95) < 8e-3
    # In view from 0.8 to 1.9 m ahead, within 40 degrees to the sides, if nothing hides it.
    x, y = np.meshgrid(found.x(), found.y(), indexing="ij")
    view = (x > 0.95) & (x < 1.9) & (np.abs(y) < 0.7 * x)
    assert known[view].mean() > 0.8
    assert known[view & even & (heights > 0)].mean() > 0.98


def test_stairs_keep_their_edges(worlds):
    scene = worlds.Scene(STEPS)
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(0, 0))
    for k in range(6):
        look(mapping, scene, worlds.placement(0, 0, 0.5), k)
    heights = truth(mapping, scene)
    error = (mapping.elevation_map().elevation - heights)[:, 120:180]
    known = np.isfinite(error)
    # The cells on the tread beside an edge belong to the tread, whatever is seen of the riser below.
    edge = np.flatnonzero(np.diff(heights[:, 150]) > 0.1) + 1
    assert len(edge) == 2
    assert np.median(np.abs(error[edge][known[edge]])) < 0.02
    assert np.abs(error[known]).mean() < 0.01


def test_what_was_removed_goes_and_what_stands_stays(worlds):
    box = ((1.0, -0.2, -1), (1.2, 0.2, 0.3))
    eye = worlds.placement(0, 0, 0.6)
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(0, 0))
    for k in range(4):
        look(mapping, worlds.Scene((box,)), eye, k)
    x, y = (mapping.elevation_map().x(), mapping.elevation_map().y())
    inside = np.ix_((x > 1.02) & (x < 1.18), np.abs(y) < 0.18)
    assert np.nanmedian(mapping.elevation_map().elevation[inside]) > 0.28
    for k in range(4):
        look(mapping, worlds.Scene((box,)), eye, 10 + k)
    assert np.nanmedian(mapping.elevation_map().elevation[inside]) > 0.28
    look(mapping, worlds.Scene(), eye, 20)
    after = mapping.elevation_map().elevation[inside]
    assert np.nanmax(after) < 0.03 and np.isfinite(after).mean() > 0.8


def test_votes_take_back_what_frays_beyond_an_edge_and_nothing_before_it(worlds):
    """A robot comes to an edge that goes down; the same images without votes leave a quarter more beyond it."""
    scene, edge = worlds.Scene((((-2, -2, -1), (1.5, 2, 0.15)),)), 1.5
    beyond = {}
    for doubt in (MappingConfig().doubt, 1e9):
        mapping = ElevationMapping(MappingConfig(doubt=doubt))
        for k in range(60):
            mapping.move(worlds.base_at(0.01 * k, 0.0))
            look(mapping, scene, worlds.placement(0.01 * k, 0.0, 0.6), k)
        found = mapping.elevation_map()
        upper = found.elevation[:, np.abs(found.y()) < 0.4] > 0.1
        beyond[doubt] = int(upper[(found.x() > edge + 0.02) & (found.x() < edge + 0.3)].sum())
        assert upper[(found.x() > edge - 0.3) & (found.x() < edge - 0.02)].mean() > 0.99
    votes, none = beyond.values()
    assert none > 30 and votes < 0.85 * none


def test_nothing_uncertain_stands_for_long_where_images_show_lower_ground(worlds):
    """A post that has gone, so uncertain that no image looks through all that it might be."""
    mapping, eye = ElevationMapping(), worlds.placement(0, 0, 0.6)
    mapping.move(worlds.base_at(0, 0))
    look(mapping, worlds.Scene((((1.0, -0.02, -1), (1.04, 0.02, 0.29)),)), eye, 0)
    post = np.isfinite(mapping.elevation_map().elevation) & (mapping.elevation_map().elevation > 0.26)
    assert 2 <= post.sum() < 40
    mapping.move(worlds.base_at(0, 0), np.diag([0, 0, 0.1**2, 0, 0, 0]))
    for k in range(1, 20):
        look(mapping, worlds.Scene(), eye, k)
    assert not (mapping.elevation_map().elevation[post] > 0.1).any()


def test_a_cell_behind_an_obstacle_is_not_forgotten(worlds):
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(0, 0))
    eye = worlds.placement(0, 0, 0.5)
    look(mapping, worlds.Scene(), eye, 0)
    known = mapping.elevation_map().known
    screen = ((0.8, -2, -1), (0.82, 2, 0.3))
    look(mapping, worlds.Scene((screen,)), eye, 1)
    hidden = mapping.elevation_map().x() > 1.0
    assert known[hidden].sum() > 5000
    assert (mapping.elevation_map().known & known)[hidden].sum() == known[hidden].sum()


def test_contradicted_cells_grow_uncertain_until_they_believe(worlds):
    mapping, lift = ElevationMapping(), 0.08
    mapping.move(worlds.base_at(0, 0))
    eye = worlds.placement(0, 0, 0.6)
    for k in range(3):
        look(mapping, worlds.Scene(), eye, k)
    before = mapping.variance
    platform = worlds.Scene((((0.5, -2, -1), (3, 2, lift)),))
    look(mapping, platform, eye, 4)
    x = mapping.elevation_map().x()
    seen = np.ix_((x > 0.9) & (x < 1.5), np.abs(x) < 0.3)
    grown = mapping.variance[seen] - before[seen]
    contradicted = grown > 0
    assert contradicted.mean() > 0.6
    assert np.allclose(grown[contradicted], mapping.config.multi_height_variance, rtol=1e-3)
    for k in range(40):
        look(mapping, platform, eye, 5 + k)
    assert (np.abs(mapping.elevation_map().elevation[seen] - lift) < 0.02).mean() > 0.95


def test_a_pose_that_drifts_is_admitted_in_the_variance(worlds):
    """The robot walks by the estimate; the error of cells seen before lies within what the map says of it."""
    scene = worlds.Scene(slope=(0.05, 0.0))
    normalised = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        mapping, drift, covariance = ElevationMapping(), 0.0, np.zeros((6, 6))
        step_variance = 0.002**2
        for k in range(12):
            estimated, true = worlds.base_at(0.05 * k, 0, 0.5 + drift), worlds.base_at(0.05 * k, 0)
            covariance[2, 2] = k * step_variance
            mapping.move(estimated, covariance)
            depth = scene.depth(CAMERA, worlds.placement(*true[:3, 3]))
            mapping.integrate(SENSOR.read(depth, rng), CAMERA, worlds.placement(*estimated[:3, 3]))
            if k < 11:
                drift += rng.normal(0, np.sqrt(step_variance))
        # What counts is the height of the terrain relative to the robot.
        error = mapping.elevation_map().elevation - drift - truth(mapping, scene)
        told = np.isfinite(error)
        normalised.append(np.mean(error[told] ** 2 / mapping.variance[told]))
    assert 0.2 < np.mean(normalised) < 1.8


def test_the_robots_own_legs_are_no_terrain(worlds):
    shank = ((0.85, -0.05, -1), (0.92, 0.05, 0.8))
    with_leg, eye = worlds.Scene((shank,)), worlds.placement(0, 0, 0.5)
    body = Capsule(np.array([0.885, 0.0, 0.0]), np.array([0.885, 0.0, 0.8]), 0.07)
    careless, careful = ElevationMapping(), ElevationMapping()
    for mapping, bodies in ((careless, ()), (careful, (body,))):
        mapping.move(worlds.base_at(0, 0))
        for k in range(3):
            look(mapping, with_leg, eye, k, bodies)
    assert np.nanmax(careless.elevation_map().elevation) > 0.2
    assert np.nanmax(careful.elevation_map().elevation) < 0.08


@given(st.tuples(st.integers(-40, 40), st.integers(-40, 40)), st.floats(-0.49, 0.49), st.floats(-0.49, 0.49))
@settings(max_examples=25, deadline=None)
def test_the_map_moves_by_whole_cells_and_forgets_nothing_on_the_way(cells, dx, dy):
    mapping = _seen_once()
    before = mapping.elevation_map()
    base = np.eye(4)
    base[:2, 3] = (cells[0] + dx) * 0.05, (cells[1] + dy) * 0.05
    mapping.move(base)
    after = mapping.elevation_map()
    assert np.allclose(after.position, np.array(cells) * 0.05)
    # Every cell centre that is on both maps: the same bits.
    for here, there in ((before, after), (after, before)):
        xy = np.stack(np.meshgrid(here.x(), here.y(), indexing="ij"), axis=-1)
        on_both = there.contains(xy)
        index = np.rint(there.fractional_index(xy[on_both])).astype(int)
        assert np.array_equal(here.elevation[on_both], there.elevation[tuple(index.T)], equal_nan=True)
    assert not after.known[~before.contains(np.stack(np.meshgrid(after.x(), after.y(), indexing="ij"), axis=-1))].any()


def _seen_once():
    camera = CameraModel(30, 30, 12.0, 12.0, 14.5, 14.5, FittedNoise())
    mapping = ElevationMapping(MappingConfig(cells=30, resolution=0.05))
    mapping.move(np.eye(4))
    down = np.diag([1.0, -1, -1, 1])
    down[2, 3] = 0.8
    mapping.integrate(np.random.default_rng(0).uniform(0.3, 0.8, (30, 30)), camera, down)
    assert mapping.elevation_map().known.mean() > 0.3
    return mapping


@pytest.mark.parametrize("nothing", [np.nan, 0.0, np.inf, -1.0, 5.0])
def test_an_image_without_a_reading_changes_nothing(worlds, nothing):
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(0, 0))
    mapping.integrate(np.full((120, 212), nothing), CAMERA, worlds.placement(0, 0, 0.5))
    assert not mapping.elevation_map().known.any()
    look(mapping, worlds.Scene(), worlds.placement(0, 0, 0.5), 0)
    before = mapping.elevation_map().elevation, mapping.variance
    mapping.integrate(np.full((120, 212), nothing), CAMERA, worlds.placement(0, 0, 0.5))
    assert np.array_equal(before[0], mapping.elevation_map().elevation, equal_nan=True)
    assert np.array_equal(before[1], mapping.variance, equal_nan=True)


def test_readings_off_the_map_are_dropped(worlds):
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(50, 0))
    look(mapping, worlds.Scene(), worlds.placement(0, 0, 0.5), 0)
    assert not mapping.elevation_map().known.any()


def test_far_from_the_origin_the_map_is_as_exact(worlds):
    """Single precision is used beside the camera only."""
    near, far = ElevationMapping(), ElevationMapping()
    depth = SENSOR.read(worlds.Scene(BLOCKS).depth(CAMERA, worlds.placement(0, 0, 0.5)), np.random.default_rng(0))
    for mapping, x in ((near, 0.0), (far, 8192.0)):
        mapping.move(worlds.base_at(x, 0))
        mapping.integrate(depth, CAMERA, worlds.placement(x, 0, 0.5))
    assert np.array_equal(near.elevation_map().elevation, far.elevation_map().elevation, equal_nan=True)


def test_variances_stay_within_their_bounds(worlds):
    config = MappingConfig(variance=(1e-5, 2e-4), horizontal_variance=(1e-4, 1e-3))
    mapping = ElevationMapping(config)
    for k in range(6):
        mapping.move(worlds.base_at(0.02 * k, 0), np.eye(6) * 0.01 * k)
        look(mapping, worlds.Scene(BLOCKS), worlds.placement(0.02 * k, 0, 0.5), k)
    mapping.move(worlds.base_at(0.2, 0), np.eye(6))
    known = mapping.elevation_map().known
    for layer, bounds in ((mapping.variance, config.variance), (mapping.horizontal_variance, (1e-4, 1e-3))):
        assert np.nanmin(layer) >= np.float32(bounds[0]) and np.nanmax(layer) <= np.float32(bounds[1])
    assert (np.isfinite(mapping.variance) == known).all()
    assert (np.isfinite(mapping.horizontal_variance) == known[..., None]).all()


def test_on_a_slope_an_uncertain_place_makes_an_uncertain_height(worlds):
    slope = (0.4, 0.0)
    mapping = ElevationMapping(UNBOUNDED)
    mapping.move(worlds.base_at(0, 0))
    mapping.lay_plane([[1, 1, 0.4], [1, -1, 0.4], [-1, 1, -0.4], [-1, -1, -0.4]], 0.0, 1e-6)
    drift = np.zeros((6, 6))
    drift[0, 0] = drift[1, 1] = 0.01**2
    mapping.move(worlds.base_at(0, 0), drift)
    known = mapping.elevation_map().known
    expected = np.sqrt(1e-6 + slope[0] ** 2 * (1e-4 + 0.01**2))
    assert np.allclose(mapping.uncertainty()[known], expected, rtol=1e-4)
    assert np.isnan(mapping.uncertainty()[~known]).all()


def test_ground_laid_under_the_feet_is_a_plane_through_them_and_leaves_what_is_known(worlds):
    mapping = ElevationMapping()
    mapping.move(worlds.base_at(0, 0))
    look(mapping, worlds.Scene((((0.6, -1, -1), (1, 1, 0.2)),)), worlds.placement(0, 0, 0.6), 0)
    before = mapping.elevation_map()
    feet = np.array([[0.36, 0.25], [0.36, -0.25], [-0.36, 0.25], [-0.36, -0.25]])
    heights = 0.1 * feet[:, 0] - 0.05 * feet[:, 1] + 0.01
    mapping.lay_plane(np.column_stack([feet, heights]), 0.4, 1e-4)
    after = mapping.elevation_map()
    assert np.array_equal(after.elevation[before.known], before.elevation[before.known])
    laid = after.known & ~before.known
    x, y = np.meshgrid(after.x(), after.y(), indexing="ij")
    assert np.allclose(after.elevation[laid], (0.1 * x - 0.05 * y + 0.01)[laid], atol=1e-6)
    assert (laid | before.known)[(np.abs(x) < 0.75) & (np.abs(y) < 0.64)].all()
    assert not laid[(np.abs(x) > 0.77) | (np.abs(y) > 0.66)].any()
    assert np.allclose(mapping.variance[laid], 1e-4)


def test_feet_in_a_line_still_lay_ground():
    mapping = ElevationMapping()
    mapping.lay_plane([[0, 0, 0.1], [0.1, 0, 0.1], [0.2, 0, 0.1]], 0.1, 1e-4)
    assert np.allclose(mapping.elevation_map().elevation[mapping.elevation_map().known], 0.1)


def drifted(rise, worlds):
    """A map of one plane laid at the start and one laid after a drift up and down again, in [m], and where they lie."""
    mapping = ElevationMapping(UNBOUNDED)
    corners = np.array([[-1, -1], [-1, 1], [0, -1], [0, 1]])
    ahead = np.array([1, 0])
    uncertain = np.zeros((6, 6))
    mapping.move(worlds.base_at(0, 0))
    mapping.lay_plane(np.column_stack([corners, np.zeros(4)]), 0.0, 1e-6)
    uncertain[2, 2] = 0.02**2
    mapping.move(worlds.base_at(0, 0), uncertain)
    mapping.lay_plane(np.column_stack([corners + ahead, np.full(4, rise)]), 0.0, 1e-6)
    x, y = np.meshgrid(mapping.elevation_map().x(), mapping.elevation_map().y(), indexing="ij")
    inside = np.abs(y) < 0.9
    return mapping, inside & (x > -0.9) & (x < -0.1), inside & (x > 0.1) & (x < 0.9)


def test_a_foot_brings_back_what_has_drifted_and_leaves_what_was_seen_since(worlds):
    mapping, old, new = drifted(0.02, worlds)
    before = mapping.variance
    mapping.touch([[-0.5, 0.2, 0.02]], 1e-6)
    found = mapping.elevation_map().elevation
    assert np.allclose(found[old], 0.02, atol=2e-4)
    assert np.allclose(found[new], 0.02, atol=1e-6)
    assert (mapping.variance[old] < 0.05 * before[old]).all() and np.allclose(mapping.variance[new], before[new])


def test_a_foot_on_what_was_just_seen_moves_nothing(worlds):
    mapping, _, _ = drifted(0.02, worlds)
    before = mapping.elevation_map().elevation
    mapping.touch([[0.5, 0.2, 0.021]], 1e-6)
    assert np.array_equal(before, mapping.elevation_map().elevation, equal_nan=True)


def test_what_has_drifted_for_longer_comes_back_by_the_drift_that_it_shares(worlds):
    mapping, old, new = drifted(0.0, worlds)
    more = np.zeros((6, 6))
    more[2, 2] = 2 * 0.02**2
    mapping.move(worlds.base_at(0, 0), more)
    mapping.touch([[0.5, 0.2, 0.02]], 1e-9)
    found = mapping.elevation_map().elevation
    # Of its drift of twice that variance the older plane shares the later half with the one under the foot.
    assert np.allclose(found[new], 0.02, atol=1e-3) and np.allclose(found[old], found[new].mean(), atol=1e-6)
    assert (mapping.variance[old] > 0.9 * 0.02**2).all() and (mapping.variance[new] < 0.1 * 0.02**2).all()


@pytest.mark.parametrize("point", [[-0.5, 0.2, 0.15], [-2.0, 0.0, 0.02], [50.0, 0.0, 0.02]])
def test_a_foot_on_other_or_unknown_ground_tells_nothing(worlds, point):
    mapping, _, _ = drifted(0.02, worlds)
    before = mapping.elevation_map().elevation
    mapping.touch([point], 1e-6)
    mapping.touch(np.empty((0, 3)), 1e-6)
    assert np.array_equal(before, mapping.elevation_map().elevation, equal_nan=True)


@pytest.mark.parametrize(
    "call",
    [
        lambda m: m.move(np.eye(3)),
        lambda m: m.move(np.full((4, 4), np.nan)),
        lambda m: m.move(2 * np.eye(4)),
        lambda m: m.move(np.diag([1.0, 1, -1, 1])),
        lambda m: m.move(np.eye(4), np.eye(3)),
        lambda m: m.move(np.eye(4), -np.eye(6)),
        lambda m: m.integrate(np.ones((4, 4)), CAMERA, np.eye(4)),
        lambda m: m.integrate(np.ones((120, 212)), CAMERA, np.zeros((4, 4))),
        lambda m: m.lay_plane([[0, 0, 0], [1, 0, 0]], 0.1, 1e-4),
        lambda m: m.lay_plane([[0, 0, 0], [1, 0, 0], [0, 1, 0]], 0.1, -1e-4),
        lambda m: m.lay_plane([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.nan, 1e-4),
        lambda m: m.lay_plane([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], 0.1, 1e-4),
        lambda m: m.touch([0, 0, 0], 1e-4),
        lambda m: m.touch([[0, 0, np.nan]], 1e-4),
        lambda m: m.touch([[0, 0, 0]], 0.0),
    ],
)
def test_what_makes_no_sense_is_refused_and_changes_nothing(call):
    mapping = _seen_once()
    before = mapping.elevation_map()
    with pytest.raises(InputError, match="expected"):
        call(mapping)
    assert np.array_equal(before.elevation, mapping.elevation_map().elevation, equal_nan=True)


@pytest.mark.parametrize(
    "changes",
    [
        {"cells": 1},
        {"resolution": 0.0},
        {"resolution": np.nan},
        {"gate": -1.0},
        {"sight": np.inf},
        {"variance": (0.0, 1.0)},
        {"variance": (1e-3, 1e-4)},
        {"horizontal_variance": (1e-4, np.inf)},
    ],
)
def test_settings_that_make_no_sense_are_refused(changes):
    with pytest.raises(InputError, match="expected"):
        MappingConfig(**changes)
