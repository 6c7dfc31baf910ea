"""How close the ground comes to the hip: as the oracle's geometry has it, and only with what rises above the hip."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.footholds import Reason
from footsel.footholds.encoding import InputEncoding
from footsel.footholds.pose import tilt_rotation
from footsel.learning.clearance import LegClearance
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.oracle.convex import CENTRE, support
from footsel.oracle.labeler import Oracle
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.terrain_collision import Terrain, TerrainCollision
from footsel.terrain import LocalMap

PLANES = ("height", "above", "unknown", "roll", "pitch")


def clearance(robot, leg, heights, roll=0.0, pitch=0.0, skeleton=None):
    """(n, 40, 40) of the layer, in [m]."""
    skeleton = skeleton or LegSkeleton.of(robot, leg)
    encode = InputEncoding(PLANES, False, robot.layout.height_range).encode
    maps = torch.from_numpy(encode(np.asarray(heights, dtype=np.float32), roll, pitch))
    tilt = Tilt(PLANES)(maps)
    depth, above, unknown = maps[:, :1], maps[:, 1:2], maps[:, 2:3]
    posture = Posture(robot.layout, skeleton)(depth.flatten(2), tilt)
    layer = LegClearance(robot.layout, skeleton, hip=True)
    return layer(posture, tilt, depth, 1 - unknown, above)[:, -1].reshape(-1, 40, 40).numpy() * layer.unit


def test_anymals_hip_is_its_drive(robot):
    assert [body.name for body in robot.bodies["LF"].trimmed if "THIGH_2" in body.name] == ["LF_THIGH_2"]
    rows = LegSkeleton.of(robot, "LF").hip
    bodies = SwingBodies.of(robot, "LF", [b for b in robot.bodies["LF"].trimmed if b.name == "LF_THIGH_2"])
    np.testing.assert_allclose(np.delete(rows, CENTRE + 1, axis=1), np.delete(bodies.rows, CENTRE + 1, axis=1))


@pytest.mark.parametrize("leg", ["LF", "LH"])
@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.2, -0.15)])
def test_over_level_ground_it_is_the_height_of_the_lowest_point(robot, leg, roll, pitch):
    """Ground so high that the hip nearly touches, and feet in pits, one after another: to four millimetres."""
    oracle = Oracle(robot)
    level = -0.09
    bodies = SwingBodies.of(robot, leg, [b for b in robot.bodies[leg].trimmed if b.name == f"{leg}_THIGH_2"])
    tilt = tilt_rotation(roll, pitch)
    compared = 0
    for i, j in [(20, 20), (26, 24), (12, 15), (30, 20), (20, 30)]:
        heights = np.full((40, 40), level)
        heights[i, j] = -0.45
        label = oracle.label(LocalMap(heights, robot.layout.resolution, np.zeros(3), 0.0), leg, roll, pitch)
        angles = label.joint_angles[i, j]
        if np.isnan(angles).any():
            continue
        (placement,) = bodies.placements(angles)
        down = tilt @ placement.getRotation()
        # Lowest along the vertical: the support point of the shape itself, at the origin.
        shape = LegSkeleton.of(robot, leg).hip[0].copy()
        shape[CENTRE : CENTRE + 3], shape[CENTRE + 3 :] = 0, np.eye(3).ravel()
        lowest = (tilt @ placement.getTranslation())[2] + down[2] @ support(shape, *(-down[2]))
        expected = np.clip(lowest - level, -0.1, 0.1)
        assert clearance(robot, leg, heights[None], roll, pitch)[0, i, j] == pytest.approx(expected, abs=0.004)
        compared += 1
    assert compared >= 3


def test_it_tells_what_the_oracle_finds(robot, obstacles):
    """Cells whose hip touches the terrain, by the oracle's own check of that body: nearly all, on either side."""
    some = obstacles.take(slice(0, 60))
    heights, oracle = some.heights(), Oracle(robot)
    bodies = [body for body in robot.bodies["LF"].trimmed if body.name == "LF_THIGH_2"]
    check = TerrainCollision(SwingBodies.of(robot, "LF", bodies)).check
    found = clearance(robot, "LF", heights, some.roll, some.pitch)
    touching, free = [], []
    for height, tilt, clear in zip(heights, zip(some.roll, some.pitch, strict=True), found, strict=True):
        roll, pitch = map(float, tilt)
        label = oracle.label(LocalMap(height, robot.layout.resolution, np.zeros(3), 0.0), "LF", roll, pitch)
        cells = (label.reason == Reason.FEASIBLE) | (label.reason == Reason.TERRAIN_COLLISION)
        if cells.any():
            terrain = Terrain(height.astype(float), robot.layout.resolution)
            touches = check(terrain, tilt_rotation(roll, pitch), label.joint_angles[cells])
            touching += (clear[cells][touches] < 0.01).tolist()
            free += (clear[cells][~touches] < 0.01).tolist()
    assert len(touching) > 300
    assert np.mean(touching) > 0.99
    assert np.mean(free) < 0.02


def test_how_high_a_wall_is_counts_above_the_hip(robot):
    """A wall beside the hip: the drive is widest at its axis, so one that ends below it is further away."""
    found = []
    for top in (-0.03, 0.0, 0.03, 0.06):
        heights = np.full((1, 40, 40), -0.45)
        heights[:, :, 19:21] = top
        found.append(clearance(robot, "LF", heights)[0, 20, 28])
    assert found == sorted(found, reverse=True)
    assert len(set(found)) == len(found)


def test_unknown_cells_are_as_deep_as_the_image(robot):
    known = np.full((1, 40, 40), -0.45)
    hole = known.copy()
    hole[:, 17:22, 17:22] = np.nan
    deep = known.copy()
    deep[:, 17:22, 17:22] = -2.0
    feet = np.s_[:, 26:30, 18:22]
    np.testing.assert_array_equal(clearance(robot, "LF", hole)[feet], clearance(robot, "LF", deep)[feet])


def test_a_leg_without_a_thick_hip_has_its_axis(robot):
    skeleton = replace(LegSkeleton.of(robot, "LF"), hip=np.empty((0, 16)))
    heights = np.full((1, 40, 40), -0.45)
    np.testing.assert_allclose(clearance(robot, "LF", heights, skeleton=skeleton), 0.1, rtol=1e-6)
