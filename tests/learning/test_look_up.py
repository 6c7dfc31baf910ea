"""The ground between cells is the oracle's: the surface of coal's height field."""

import coal
import numpy as np
import torch

from footsel.learning.look_up import MIDDLE, LookUp
from footsel.oracle.terrain_collision import Terrain

RESOLUTION, TINY = 0.02, 1e-4


def test_it_is_the_surface_that_the_oracle_holds_bodies_against():
    """A speck just above it touches nothing, just below it does, wherever in a cell."""
    rng = np.random.default_rng(0)
    heights = rng.uniform(-0.5, 0.1, (40, 40))
    places = rng.uniform(-0.38, 0.38, (200, 2))
    at = torch.from_numpy(places.T[None] / RESOLUTION + MIDDLE).float()
    found = LookUp(np.zeros(len(places), dtype=int))(torch.from_numpy(heights)[None, None].float(), at)[0, 0].numpy()
    field = Terrain(heights, RESOLUTION).field

    def touches(x, y, z):
        placement = coal.Transform3s(np.eye(3), np.array([x, y, z]))
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        return coal.collide(field, coal.Transform3s(), coal.Sphere(TINY), placement, request, result) > 0

    # Facets are steep: up to 30 to 1 or so, and a sphere reaches them from as far above.
    for (x, y), z in zip(places, found, strict=True):
        assert not touches(x, y, z + 100 * TINY)
        assert touches(x, y, z)


def test_beyond_the_map_is_its_border():
    heights = torch.arange(1600.0).reshape(1, 1, 40, 40)
    at = torch.tensor([[[-100.0, 100.0], [-100.0, 100.0]]])
    found = LookUp(np.zeros(2, dtype=int))(heights, at)[0, 0]
    torch.testing.assert_close(found, torch.tensor([0.0, 1599.0]), atol=0.01, rtol=0)
