"""The slip trial obeys Coulomb's law on planes, stands on the map as it is, and no foot knows of another."""

import numpy as np
import pytest

from footsel.terrain import ElevationMap
from footsel.walking.slip import trial
from footsel.walking.slip.trial import GRAVITY, PUSH_SECONDS, SLIP_CAP, slip_trials, slip_world

RADIUS, CELL = 0.031, 0.02
#: Places on a plane, none of them special to the grid.
PLACES = np.random.default_rng(0).uniform(-0.15, 0.15, (8, 2))


def plane(slope: float, uphill: float = 0.0, cells: int = 61) -> ElevationMap:
    along = (np.arange(cells) - (cells - 1) / 2) * CELL
    x, y = np.meshgrid(along, along, indexing="ij")
    return ElevationMap((slope * (np.cos(uphill) * x + np.sin(uphill) * y)).astype(np.float32), CELL)


def push_ratio(slope: float, uphill: float, share: float, friction: float, direction: float) -> tuple[float, float]:
    """Tangential and normal part of load and push on the plane, per mass, in [m/s^2]."""
    normal = np.array([-slope * np.cos(uphill), -slope * np.sin(uphill), 1]) / np.hypot(1, slope)
    push = share * friction * GRAVITY
    force = np.array([push * np.cos(direction), push * np.sin(direction), -GRAVITY])
    pressing = -force @ normal
    return float(np.linalg.norm(force + pressing * normal)), float(pressing)


@pytest.fixture(scope="module")
def rough() -> ElevationMap:
    """Unlike in x and y, not square, away from the origin: whatever is turned over or misplaced shows."""
    heights = np.random.default_rng(1).normal(0, 0.015, (60, 44))
    heights[30:] += 0.1
    return ElevationMap(heights.astype(np.float32), CELL, np.array([3.0, -1.0]))


class TestFrictionLaw:
    """Cases are on both sides of the cone, along the axes and oblique: a friction pyramid would hold the latter."""

    @pytest.mark.parametrize("friction", [0.5, 0.8])
    @pytest.mark.parametrize("uphill", [0.0, 0.6])
    @pytest.mark.parametrize("slope", [0.0, 0.15, 0.3])
    def test_a_foot_slips_beyond_the_cone_and_holds_within(self, monkeypatch, slope, uphill, friction):
        held = slipped = 0
        with slip_world(plane(slope, uphill), RADIUS, len(PLACES)) as world:
            for share in (0.3, 0.6, 0.9, 1.1, 1.4):
                monkeypatch.setattr(trial, "PUSH_SHARES", (share, share))
                for direction in np.deg2rad([0, 22.5, 45, 100, 180, 225]):
                    along, pressing = push_ratio(slope, uphill, share, friction, direction)
                    slip = world.slip(PLACES, friction, direction)
                    if along < 0.97 * friction * pressing:
                        assert slip.max() < 1e-3, (share, np.rad2deg(direction))
                        held += 1
                    elif along > 1.08 * friction * pressing:
                        # From the distance in the time of the push: the acceleration, and so the friction that was.
                        friction_found = (along - 2 * slip[slip < SLIP_CAP] / PUSH_SECONDS**2) / pressing
                        np.testing.assert_allclose(friction_found, friction, rtol=0.06)
                        assert slip.min() > 1e-3
                        slipped += 1
        assert held >= 3 and slipped >= 6

    def test_a_slope_beyond_the_friction_angle_is_slid_down_before_any_push(self):
        with slip_world(plane(0.7), RADIUS, len(PLACES)) as world:
            assert (world.slip(PLACES, 0.5, np.pi) == SLIP_CAP).all()
            # Even with the push against it.
            assert world.slip(PLACES, 0.5, 0.0).min() > 0.5e-3

    def test_level_ground_holds_every_push_up_to_the_limit_of_friction(self):
        with slip_world(plane(0.0), RADIUS, len(PLACES)) as world:
            slips = [world.slip(PLACES, friction, turn) for friction in (0.5, 0.8) for turn in np.linspace(0, 6, 7)]
        assert np.max(slips) < 1e-3

    def test_a_foot_does_not_roll(self, monkeypatch):
        """A free ball would roll 3 cm down this slope; friction holds a foot."""
        monkeypatch.setattr(trial, "PUSH_SHARES", (0.0, 0.0))
        with slip_world(plane(0.1), RADIUS, len(PLACES)) as world:
            assert world.slip(PLACES, 0.8, 0.0).max() < 1e-3


def test_the_ground_is_the_elevation_map(rough):
    """A vertical ray onto every cell centre hits the height of that cell."""
    with slip_world(rough, RADIUS, 1) as world:
        world._client.setCollisionFilterGroupMask(world._ground, -1, 1, -1)  # Rays may meet it as well as feet.
        x, y = np.meshgrid(rough.x()[1:-1], rough.y()[1:-1], indexing="ij")
        # Off the very vertex, where a ray may pass between triangles.
        x, y = x.ravel() + 1e-5, y.ravel() + 1e-5
        rays = world._client.rayTestBatch(
            np.column_stack([x, y, np.full_like(x, 1.0)]).tolist(), np.column_stack([x, y, 0 * x - 1.0]).tolist()
        )
    found = np.array([hit[3][2] for hit in rays])
    np.testing.assert_allclose(found, rough.elevation[1:-1, 1:-1].ravel(), atol=2e-4)


def test_a_foot_set_down_just_touches_what_bullet_collides_with(rough):
    places = rough.position + np.random.default_rng(2).uniform([-0.5, -0.3], [0.5, 0.3], (40, 2))
    with slip_world(rough, RADIUS, 1) as world:
        heights = world._heights
        foot, ground = world._feet[0], world._ground
        centres = trial.touchdown_heights(heights, CELL, RADIUS, places - rough.position)
        for (x, y), z in zip(places.tolist(), centres.tolist(), strict=True):
            world._client.resetBasePositionAndOrientation(foot, (x, y, z), (0, 0, 0, 1))
            gaps = [point[8] for point in world._client.getClosestPoints(foot, ground, 0.01)]
            assert min(gaps) == pytest.approx(0.0, abs=5e-5)


def test_feet_do_not_know_of_each_other(rough):
    """Alone, in a crowd on the same spot, and the second time, a foot slips the same way."""
    places = rough.position + np.random.default_rng(3).uniform(-0.2, 0.2, (6, 2))
    with slip_world(rough, RADIUS, 12) as world:
        crowd = world.slip(np.concatenate([places, places]), 0.5, 1.0)
        again = world.slip(np.concatenate([places, places]), 0.5, 1.0)
        fewer = world.slip(places, 0.5, 1.0)
    with slip_world(rough, RADIUS, 1) as world:
        alone = np.concatenate([world.slip(place[None], 0.5, 1.0) for place in places])
    assert crowd.max() > 5e-3
    np.testing.assert_array_equal(crowd, again)
    np.testing.assert_array_equal(crowd[:6], crowd[6:])
    np.testing.assert_array_equal(crowd[:6], fewer)
    np.testing.assert_allclose(alone, crowd[:6], atol=1e-5)


def test_a_foot_slips_off_an_edge_and_not_a_hand_s_breadth_inside():
    step = ElevationMap(np.where(np.arange(61)[:, None] <= 30, 0.1, 0.0) * np.ones((1, 61)), CELL)
    edge, inside = np.array([[0.0, 0.0]]), np.array([[-0.1, 0.0]])
    with slip_world(step, RADIUS, 2) as world:
        outwards = slip_trials(world, np.repeat(edge, 2, axis=0), 0.5, np.random.default_rng(0))
        kept = slip_trials(world, np.repeat(inside, 2, axis=0), 0.5, np.random.default_rng(0))
    assert outwards.shape == (2, trial.DIRECTIONS)
    assert outwards.max() > 0.02 and kept.max() < 1e-3


def test_unknown_ground_is_a_hole():
    heights = np.zeros((61, 61))
    heights[31:] = np.nan
    with slip_world(ElevationMap(heights, CELL), RADIUS, 2) as world:
        slip = world.slip(np.array([[-0.2, 0.0], [0.03, 0.0]]), 0.8, 0.0)
    assert slip[0] < 1e-3 and slip[1] == SLIP_CAP
