"""A body's line and widths are those of the box around it, by coal."""

import coal
import numpy as np
import pytest

from footsel.robot.medial_axis import medial_axis

SHAPES = {
    "sphere": coal.Sphere(0.03),
    "cylinder": coal.Cylinder(0.02, 0.3),
    "disc": coal.Cylinder(0.06, 0.04),
    "capsule": coal.Capsule(0.02, 0.3),
    "box": coal.Box(0.1, 0.4, 0.2),
    "another": coal.Ellipsoid(0.1, 0.3, 0.2),
}


@pytest.mark.parametrize("name", SHAPES)
def test_it_is_that_of_the_box_around(name):
    shape = SHAPES[name]
    shape.computeLocalAABB()
    half = np.asarray(shape.aabb_local.max_ - shape.aabb_local.min_) / 2
    axis, length, widths = medial_axis(shape)
    np.testing.assert_allclose([length, *widths], [half[axis], *np.delete(half, axis)])
    # A disc too has its line along z, where all that is round has it.
    assert axis == (2 if name == "disc" else np.argmax(half) if name != "sphere" else 2)
