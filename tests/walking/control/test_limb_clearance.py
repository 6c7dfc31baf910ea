"""How clear limbs are is what collision geometry says, and its rates are those of the base's motion."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.walking.control.limb_clearance import DISTANCE, LimbClearance
from footsel.walking.gait.stance import places

ROBOT = load_robot("anymal_b")
LIMBS = LimbClearance(ROBOT)
FEET = np.column_stack([places(), np.full(4, ROBOT.description.foot_radius)])
POSE = np.array([0.02, -0.03, 0.42, 0.06, -0.12])


def ground(change=None):
    heights = np.zeros((121, 101), dtype=np.float32)
    x, y = np.meshgrid((np.arange(121) - 60) * 0.02, (np.arange(101) - 50) * 0.02, indexing="ij")
    if change is not None:
        heights = change(heights, x, y)
    return ElevationMap(heights, 0.02)


def at(values, elevation_map, feet=FEET):
    return LIMBS.at(elevation_map, BasePose(*values, 0.0), feet)


def lowest_of_thigh(values, leg):
    """Height of the lowest point of a leg's thigh, by the shapes that the URDF gives it."""
    base = BasePose(*values, 0.0)
    q = np.zeros(ROBOT.model.nq)
    for k, each in enumerate(LEGS):
        centre = (FEET[k] - base.position) @ base.rotation() - ROBOT.layout.hips[each]
        angles, _ = ROBOT.kinematics[each].inverse(centre)
        for name, angle in zip(ROBOT.description.joints[each], angles[0], strict=True):
            q[ROBOT.model.joints[ROBOT.model.getJointId(name)].idx_q] = angle
    data = ROBOT.model.createData()
    pin.forwardKinematics(ROBOT.model, data, q)
    plane = coal.Halfspace(base.rotation().T @ [0.0, 0.0, 1.0], -5.0 - base.z)
    distances = []
    for body in ROBOT.bodies[leg].swing:
        if body.joint == 2:
            joint = data.oMi[ROBOT.model.getJointId(ROBOT.description.joints[leg][1])]
            place = joint * pin.SE3(body.rotation, body.translation)
            result = coal.DistanceResult()
            here = coal.Transform3s(place.rotation, place.translation)
            coal.distance(body.shape, here, plane, coal.Transform3s.Identity(), coal.DistanceRequest(), result)
            distances.append(result.min_distance - 5.0)
    return min(distances)


@pytest.mark.parametrize("leg", LEGS)
def test_over_level_ground_a_thigh_is_as_clear_as_its_shapes_are(leg):
    least = at(POSE, ground()).least[LEGS.index(leg), 0]
    # Balls fill a body but for its edges.
    assert 0 <= least + DISTANCE - lowest_of_thigh(POSE, leg) < 0.012


def test_rates_are_those_of_the_clearance():
    slope = ground(lambda heights, x, y: (0.25 * x - 0.15 * y).astype(np.float32))
    found = at(POSE, slope)
    for axis in range(5):
        shift = 2e-4 * np.eye(5)[axis]
        change = (at(POSE + shift, slope).least - at(POSE - shift, slope).least) / 4e-4
        # Cells are a few centimetres apart: the nearest one may change.
        np.testing.assert_allclose(found.rates[:, :, axis], change, atol=0.06)


def test_left_and_right_are_alike():
    bumpy = ground(lambda heights, x, y: (0.1 * np.cos(9 * x) * np.cos(7 * y)).astype(np.float32))
    pose, mirrored = np.array([0.02, 0.03, 0.42, 0.06, -0.12]), np.array([0.02, -0.03, 0.42, -0.06, -0.12])
    left, right = at(pose, bumpy).least, at(mirrored, bumpy).least
    np.testing.assert_allclose(left, right[[1, 0, 3, 2]], atol=1e-6)


def test_a_knee_beside_a_step_feels_its_edge_before_it_is_over_it():
    """The hind knee is ahead of its foot: a step that comes nearer is felt at the wanted distance, not before."""
    knee = {}
    for front in np.arange(0.0, 0.3, 0.02):
        step = ground(lambda heights, x, y, front=front: np.where(x > -0.2 + front, 0.3, 0.0).astype(np.float32))
        knee[front] = at(POSE, step).least[LEGS.index("LH"), 0]
    clear = np.array(list(knee.values()))
    assert (np.diff(clear) >= -1e-9).all() and clear[0] < 0 < clear[-1]


def test_unknown_ground_holds_nothing_up():
    nothing = at(POSE, ground(lambda heights, x, y: np.full_like(heights, np.nan)))
    assert np.isinf(nothing.least).all() and nothing.worst == np.inf and not nothing.rates.any()


def test_feet_out_of_reach_leave_legs_stretched():
    far = at(POSE + np.array([0, 0, 0.4, 0, 0]), ground())
    assert np.isfinite(far.least).all() and far.worst > at(POSE, ground()).worst


def test_one_foot_at_many_places_is_that_leg_at_each():
    rng = np.random.default_rng(0)
    bumpy = ground(lambda heights, x, y: (0.1 * np.cos(9 * x) * np.cos(7 * y)).astype(np.float32))
    places_ = FEET[2] + rng.uniform(-0.1, 0.1, (8, 3))
    worst = LIMBS.of_foot(bumpy, BasePose(*POSE, 0.0), "LH", places_)
    for place, value in zip(places_, worst, strict=True):
        feet = FEET.copy()
        feet[2] = place
        assert value == pytest.approx(at(POSE, bumpy, feet).least[2].min())


def test_the_worst_limb_is_the_same_without_rates():
    rng = np.random.default_rng(1)
    bumpy = ground(lambda heights, x, y: (0.1 * np.cos(9 * x) * np.cos(7 * y)).astype(np.float32))
    for shift in rng.uniform(-0.05, 0.05, (5, 5)):
        assert LIMBS.worst(bumpy, BasePose(*(POSE + shift), 0.0), FEET) == at(POSE + shift, bumpy).worst


def test_unwatched_limbs_are_clear_of_everything():
    """Also with the ground up to the hips."""
    high = ground(lambda heights, x, y: heights + 0.4)
    pose, unwatched = BasePose(*POSE, 0.0), LimbClearance(ROBOT, watched=False)
    assert LIMBS.worst(high, pose, FEET) < 0
    assert unwatched.worst(high, pose, FEET) == np.inf == unwatched.of_foot(high, pose, "LF", FEET).min()
    assert not unwatched.at(high, pose, FEET).rates.any()
