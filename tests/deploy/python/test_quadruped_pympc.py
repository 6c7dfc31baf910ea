"""The socket of Quadruped-PyMPC: its call, what its helper reads from the answer, and the same foothold as ours."""

import numpy as np
import pytest

from footsel.errors import InputError
from footsel.footholds import BasePose
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import make_course

LEGS = {"FL": "LF", "FR": "RF", "RL": "LH", "RR": "RH"}


@pytest.fixture(scope="module")
def selector():
    return FootholdSelector.load("anymal_b")


def height_map(course, centre, yaw, points=40, distance=0.02):
    """(points, points, 3) world positions as gym_quadruped's sensor has them: rows toward -x of the heading."""
    along = ((points - 1) / 2 - np.arange(points)) * distance
    x, y = np.meshgrid(along, along, indexing="ij")
    c, s = np.cos(yaw), np.sin(yaw)
    xy = centre[:2] + np.stack([c * x - s * y, s * x + c * y], axis=-1)
    return np.concatenate([xy, course.sample(xy)[..., None]], axis=-1)


def call(vfa, heights, roll=0.0, pitch=0.0, yaw=0.0):
    """As the helper calls it."""
    return vfa(
        heightmap_data=heights,
        base_linear_velocity=np.array([0.3, 0.0, 0.0]),
        base_orientation=np.array([roll, pitch, yaw]),
        base_orientation_rate=np.zeros(3),
        gait_phase=0.0,
        return_info=True,
    )


def helper_cell(number, columns):
    """Row and column as the helper finds them from what `.item()` gives."""
    value = number.item()
    return min(round(value / columns), columns - 1), min(round(value % columns), columns - 1)


@pytest.mark.parametrize("leg", LEGS)
def test_the_foothold_is_the_selector_s(deployed, selector, leg):
    """Its height map around the hip point holds the very points of our local map."""
    vfa = deployed("quadruped_pympc").VFA(leg=leg, centre="hip")
    agree, asked = 0, 0
    for seed in range(6):
        course = make_course(("stones", "rubble", "stairs")[seed % 3], seed, size=4.0)
        roll, pitch, yaw = 0.08, -0.06, 0.4 + seed
        z = selector.layout.ground_height(course, 0.1, 0.0, yaw) + selector.layout.standing_height
        pose = BasePose(0.1, 0.0, z, roll, pitch, yaw)
        hip = selector.layout.hip_position(LEGS[leg], pose)
        points = height_map(course, hip, yaw)
        convex, nothing, safe, info = call(vfa, points[..., 2] - hip[2], roll, pitch, yaw)
        ours = selector.select(course, pose, (LEGS[leg],))[LEGS[leg]]
        assert nothing is None and safe.shape == (40, 40) and info["status"] == ours.status
        if ours.status == "none":
            assert convex == ([], [])
            continue
        row, column = helper_cell(convex[0][0], 40)
        assert safe[row, column]
        assert info["final_cost"] == pytest.approx(ours.final_cost, abs=0.02)
        agree += np.allclose(points[row, column], ours.position, atol=1e-4)
        asked += 1
        first, last = (helper_cell(number, 40) for number in (convex[1][0].x1, convex[1][0].y2))
        assert first[0] <= row <= last[0] and first[1] <= column <= last[1]
        assert safe[first[0] : last[0] + 1, first[1] : last[1] + 1].all()
    # Heights that went through one more sampling differ in their last digit, which may decide between two equals.
    assert asked >= 4 and agree >= asked - 1


@pytest.mark.parametrize(("points", "distance"), [(7, 0.04), (15, 0.02), (21, 0.03)])
def test_a_small_patch_around_the_nominal_foothold_will_do(deployed, selector, points, distance):
    vfa = deployed("quadruped_pympc").VFA(leg="FR", resolution=distance)
    course = make_course("steps", 4, size=4.0)
    z = selector.layout.ground_height(course, 0.0, 0.0, 0.0) + selector.layout.standing_height
    pose = BasePose(0.0, 0.0, z)
    patch = height_map(course, selector.layout.nominal_xy("RF", pose), 0.0, points, distance)
    convex, _, safe, _ = call(vfa, patch[..., 2] - selector.layout.hip_position("RF", pose)[2])
    assert safe.shape == (points, points)
    row, column = helper_cell(convex[0][0], points)
    assert safe[row, column]


def test_a_cell_s_number_gives_its_row_to_who_rounds(deployed):
    number = deployed("quadruped_pympc").CellNumber
    for row in range(9):
        for column in range(7):
            assert helper_cell(number(row * 7 + column), 7) == (min(row, 6), column)
    # The helper's own rounding gets these wrong.
    assert round((2 * 7 + 5) / 7) == 3


def test_no_safe_cell_is_no_foothold(deployed):
    vfa = deployed("quadruped_pympc").VFA(leg="RL")
    for heights in (np.full((40, 40), -2.0), np.full((40, 40), np.nan)):
        convex, _, safe, info = call(vfa, heights)
        assert convex == ([], []) and not safe.any() and info["status"] == "none" and info["reason"]
        with pytest.raises(IndexError):
            convex[0][0]


def test_wrong_use_is_told(deployed):
    module = deployed("quadruped_pympc")
    with pytest.raises(InputError, match="FL, FR, RL, RR"):
        module.VFA(leg="front left")
    with pytest.raises(InputError, match="nominal, hip"):
        module.VFA(leg="FL", centre="base")


def test_a_rectangle_grows_as_far_as_it_is_safe(deployed):
    safe = np.zeros((6, 8), dtype=bool)
    safe[1:4, 2:7] = True
    grown = deployed("quadruped_pympc").grown_rectangle
    assert grown(safe, (2, 3)) == ((1, 2), (3, 6))
    safe[3, 2] = False
    low, high = grown(safe, (2, 4))
    assert safe[low[0] : high[0] + 1, low[1] : high[1] + 1].all() and (low, high) != ((2, 4), (2, 4))
