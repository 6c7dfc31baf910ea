"""The triangles are the terrain that the oracle knows: same surface, walls without a hole."""

from collections import Counter

import coal
import numpy as np
import pytest

from footsel.oracle.brute_force import terrain_solid
from footsel.terrain import LocalMap
from footsel.walking.cross_check.terrain_mesh import DEPTH, TerrainMesh, triangle_model


@pytest.fixture(scope="module")
def local_map() -> LocalMap:
    heights = np.random.default_rng(0).uniform(-0.6, -0.3, (40, 40))
    heights[5:8, 30:] = np.nan
    return LocalMap(heights.astype(np.float32), 0.02, np.zeros(3), 0.3)


@pytest.fixture(scope="module")
def mesh(local_map: LocalMap) -> TerrainMesh:
    return TerrainMesh.of(local_map)


def test_the_surface_is_that_of_the_height_field(local_map: LocalMap, mesh: TerrainMesh) -> None:
    """A point is under the surface exactly if it is in coal's solid, on either side of every diagonal."""
    solid, still = terrain_solid(local_map), coal.Transform3s.Identity()
    points = np.random.default_rng(1).uniform([-0.42, -0.42, -0.7], [0.42, 0.42, -0.2], (3000, 3))
    points = points[np.abs(points[:, 2] - mesh.height(points)) > 1e-4]
    below = mesh.below(points)
    for point, under in zip(points, below.tolist(), strict=True):
        at, request = coal.Transform3s(np.eye(3), point), coal.CollisionRequest()
        assert bool(coal.collide(coal.Sphere(1e-6), at, solid, still, request, coal.CollisionResult())) == under
    assert 500 < below.sum() < len(points) - 500


def test_the_height_is_where_the_triangles_are(mesh: TerrainMesh) -> None:
    """A tiny ball on the surface touches a triangle, one half a millimetre off does not."""
    model, still = triangle_model(mesh.vertices, mesh.triangles), coal.Transform3s.Identity()
    points = np.random.default_rng(2).uniform(-0.385, 0.385, (400, 2))
    heights = mesh.height(points)
    for (x, y), z in zip(points, heights, strict=True):
        for offset, touches in ((0.0, True), (0.2, False)):
            at = coal.Transform3s(np.eye(3), np.array([x, y, max(z, heights.max() + 0.3 if offset else z) + offset]))
            result = coal.CollisionResult()
            assert bool(coal.collide(coal.Sphere(1e-5), at, model, still, coal.CollisionRequest(), result)) == touches


def test_walls_close_the_map(mesh: TerrainMesh) -> None:
    """Every edge belongs to two triangles, run in opposite directions, but for those on the floor."""
    directed = Counter((t[k], t[(k + 1) % 3]) for t in mesh.triangles.tolist() for k in range(3))
    assert max(directed.values()) == 1
    open_edges = [edge for edge in directed if edge[::-1] not in directed]
    assert len(open_edges) == 4 * 39
    floor = mesh.vertices[:, 2].min()
    assert (mesh.vertices[np.array(open_edges).ravel(), 2] == floor).all()


def test_the_ground_looks_up_and_the_walls_outwards(mesh: TerrainMesh) -> None:
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    ground = 2 * 39 * 39
    assert (normals[:ground, 2] > 0).all()
    outwards = (normals[ground:] * corners[ground:].mean(axis=1))[:, :2].sum(axis=1)
    # Beside unknown cells there is no wall above the floor.
    assert (outwards >= 0).all() and (outwards > 0).sum() > 300 - 2 * 4


def test_unknown_cells_are_deep_and_nothing_is_below_the_map(local_map: LocalMap, mesh: TerrainMesh) -> None:
    unknown = np.isnan(local_map.heights)
    np.testing.assert_allclose(mesh.heights[unknown], np.nanmin(local_map.heights) - DEPTH, atol=1e-6)
    np.testing.assert_array_equal(mesh.heights[~unknown], local_map.heights[~unknown].astype(np.float64))
    assert not mesh.below(np.array([[0.5, 0.0, -0.9], [0.0, -0.4, -0.9]])).any()
