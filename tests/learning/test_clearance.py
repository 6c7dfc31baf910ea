"""The leg over the terrain: its balls are where its bodies are, and clear what they clear."""

import numpy as np
import pytest
import torch

from footsel.footholds import Reason
from footsel.footholds.encoding import InputEncoding
from footsel.footholds.pose import BasePose, tilt_rotation
from footsel.learning.clearance import BEYOND, FALL, LARGEST_CLEARANCE, LegClearance
from footsel.learning.look_up import ORIGIN
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.oracle.swing_bodies import SwingBodies
from footsel.terrain.courses import make_course
from footsel.terrain.local_map import cell_offsets

#: Of clearances, in [m].
UNIT = LARGEST_CLEARANCE * 0.02

PLANES = ("height", "unknown", "roll", "pitch")
TILTS = [(0.0, 0.0), (0.2, -0.1), (-0.15, 0.25)]


def clearances(robot, leg, heights, roll=0.0, pitch=0.0, skeleton=None):
    """(balls, 40, 40) in [m], and the layer that made them."""
    skeleton = skeleton or LegSkeleton.of(robot, leg)
    layer = LegClearance(robot.layout, skeleton)
    encode = InputEncoding(PLANES, False, robot.layout.height_range).encode
    maps = torch.from_numpy(encode(heights[None], roll, pitch))
    depth, known, tilt = maps[:, :1], 1 - maps[:, 1:2], Tilt(PLANES)(maps)
    posture = Posture(robot.layout, skeleton)(depth.flatten(2), tilt)
    found = layer(posture, tilt, depth, known)[0].reshape(-1, 40, 40).numpy()
    return found * LARGEST_CLEARANCE * robot.layout.resolution, (layer, posture, tilt)


@pytest.mark.parametrize("leg", LEGS)
@pytest.mark.parametrize(("roll", "pitch"), TILTS)
def test_balls_are_in_the_bodies(robot, leg, roll, pitch):
    """Where the oracle's own kinematics put the bodies, the balls lie, the same in body axes for every foothold."""
    heights = np.random.default_rng(0).uniform(-0.6, -0.3, (40, 40)).astype(np.float32)
    _, (layer, posture, tilt) = clearances(robot, leg, heights, roll, pitch)
    where = layer.centres(posture, tilt)[0].reshape(3, -1, 40, 40).numpy()
    where[:2] = (where[:2] + ORIGIN - 19.5) * 0.02
    where[2] *= UNIT
    tilt = tilt_rotation(roll, pitch)
    feet = np.concatenate([cell_offsets(40, 0.02), (heights + 0.031)[..., None]], axis=-1) @ tilt
    angles, reachable = robot.kinematics[leg].inverse(feet)
    cells = np.flatnonzero(reachable)[:: max(reachable.sum() // 50, 1)]
    bodies, first = SwingBodies.of(robot, leg, robot.bodies[leg].trimmed), None
    skeleton = LegSkeleton.of(robot, leg)
    for cell in cells:
        placements = bodies.placements(angles[cell])
        balls = where.reshape(3, -1, 1600)[:, :, cell].T @ tilt  # In base axes.
        in_links = []
        for ball, link in zip(balls, skeleton.link, strict=True):
            # One body of the ball's link carries its axes.
            body = placements[int(np.flatnonzero(bodies.link == link)[0])]
            in_links.append(np.array(body.getRotation()).T @ (ball - np.array(body.getTranslation())))
        first = in_links if first is None else first
        np.testing.assert_allclose(in_links, first, atol=2e-5)
    assert len(cells) > 20 and len(skeleton.radius) > 10


def corners(a, b):
    """Cells at the corners of the triangle below a place, by how much of its height is theirs."""
    i, j = min(int(a), 38), min(int(b), 38)
    less, more = sorted((a - i, b - j))
    beside = (i + 1, j) if a - i > b - j else (i, j + 1)
    return {(i, j): 1 - more, beside: more - less, (i + 1, j + 1): less}


def test_a_ball_clears_the_terrain_by_its_height_over_it(robot):
    """Against a loop: the surface a ball rests on is that of the cells in square rings around, triangles between."""
    heights = np.random.default_rng(1).uniform(-0.6, -0.45, (40, 40)).astype(np.float32)
    heights[5:9, 20:30] = np.nan
    skeleton = LegSkeleton.of(robot, "LF")
    found, (layer, posture, tilt) = clearances(robot, "LF", heights, 0.1, 0.1, skeleton)
    centres = layer.centres(posture, tilt)
    row, column, z = centres[0].reshape(3, -1, 40, 40).numpy() * np.array([1, 1, UNIT])[:, None, None, None]
    row, column = row + ORIGIN, column + ORIGIN

    def touching(radius, a, b):
        highest = -np.inf
        for c in range(max(a - 6, 0), min(a + 7, 40)):
            for d in range(max(b - 6, 0), min(b + 7, 40)):
                aside = 0.02 * max(abs(c - a), abs(d - b))
                height = -0.85 if np.isnan(heights[c, d]) else heights[c, d]
                if aside < radius - 1e-9:
                    highest = max(highest, height + np.sqrt(radius**2 - aside**2))
                elif aside < radius + BEYOND * 0.02 - 1e-9:
                    highest = max(highest, height - FALL * (aside - radius))
        return highest

    for ball, i, j in np.random.default_rng(2).integers(0, (len(skeleton.radius), 40, 40), (300, 3)):
        a, b = (float(np.clip(index[ball, i, j], 0, 39)) for index in (row, column))
        below = sum(share * touching(skeleton.radius[ball], c, d) for (c, d), share in corners(a, b).items())
        assert found[ball, i, j] == pytest.approx(np.clip(z[ball, i, j] - below, -0.1, 0.1), abs=1e-5)


def test_rounding_decides_nothing(robot):
    """A thousandth of a millimetre moves no clearance by much more: no lookup falls from one cell into another."""
    heights = np.random.default_rng(3).uniform(-0.6, -0.4, (40, 40)).astype(np.float32)
    before, after = (clearances(robot, "LF", heights + shift)[0] for shift in (0, np.float32(1e-6)))
    assert np.abs(after - before).max() < 1e-4


def judged_maps(robot, leg, count):
    """Local maps of the courses with most obstacles: the oracle's reasons and the least clearance, (40, 40) each."""
    oracle = Oracle(robot)
    for seed in range(count):
        rng = np.random.default_rng(seed)
        course = make_course(("stones", "pillars", "rubble", "blocks")[seed % 4], seed, size=3.0)
        x, y, yaw = *rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi)
        roll, pitch = rng.uniform(-0.2, 0.2, 2)
        pose = BasePose(x, y, robot.layout.ground_height(course, x, y, yaw) + rng.uniform(0.4, 0.52), roll, pitch, yaw)
        local_map = robot.layout.local_map(course, pose, leg)
        reason = oracle.label(local_map, leg, roll, pitch).reason
        yield reason, clearances(robot, leg, local_map.heights, roll, pitch)[0].min(axis=0)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_it_tells_collisions_as_the_oracle_does(robot, leg):
    """In range, on the courses with most obstacles, the least clearance is wrong in one cell of fifteen at most."""
    agree = cells = collisions = 0
    for reason, least in judged_maps(robot, leg, 12):
        asked = (reason == Reason.FEASIBLE) | (reason == Reason.TERRAIN_COLLISION)
        collides = reason[asked] == Reason.TERRAIN_COLLISION
        agree += int(((least[asked] < 0.005) == collides).sum())
        cells, collisions = cells + int(asked.sum()), collisions + int(collides.sum())
    assert collisions > 0.1 * cells  # Who sees nothing is wrong in these.
    assert agree > (1 - 1 / 15) * cells


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_no_collision_comes_as_a_surprise(robot, leg):
    """Where the oracle finds one, some ball is near the terrain: walls show beside a body, past its rims.

    Without cells beyond a ball, one to three collisions in a hundred have every ball far from the ground.
    """
    collisions = surprises = 0
    for reason, least in judged_maps(robot, leg, 24):
        collides = reason == Reason.TERRAIN_COLLISION
        collisions, surprises = collisions + int(collides.sum()), surprises + int((least[collides] > 0.06).sum())
    assert surprises < 0.003 * collisions > 3


def test_unknown_cells_collide_with_nothing(robot):
    heights = np.full((40, 40), np.nan, dtype=np.float32)
    heights[20, 20] = -0.45
    found = clearances(robot, "LF", heights)[0][:, 20, 20]
    far = [ball for ball in range(len(found)) if LegSkeleton.of(robot, "LF").link[ball] == 0]
    np.testing.assert_allclose(found[far], 0.1, rtol=1e-6)


def test_nothing_is_learnt_and_nothing_is_rounded(robot):
    heights = np.full((40, 40), -0.45, dtype=np.float32)
    exact, (layer, posture, tilt) = clearances(robot, "LF", heights)
    assert not list(layer.parameters()) and not layer.state_dict()
    with torch.autocast("cpu", torch.bfloat16):
        maps = torch.from_numpy(InputEncoding(PLANES, False, 0.85).encode(heights[None]))
        found = layer(posture, tilt, maps[:, :1], 1 - maps[:, 1:2])
    assert found.dtype == torch.float32 and not found.requires_grad
    np.testing.assert_allclose(found[0].reshape(-1, 40, 40).numpy() * 0.1, exact, rtol=1e-6)


def test_a_skeleton_survives_json(robot):
    import json

    skeleton = LegSkeleton.of(robot, "LH")
    again = LegSkeleton.from_dict(json.loads(json.dumps(skeleton.to_dict())))
    assert again.to_dict() == skeleton.to_dict()
    np.testing.assert_array_equal(again.balls, skeleton.balls)
