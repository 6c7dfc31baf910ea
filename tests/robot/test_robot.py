"""The description of ANYmal B, its errors, and the robot made from it."""

import subprocess
import sys

import numpy as np
import pytest

from footsel.errors import InputError, UnknownNameError
from footsel.footholds import LegLayout
from footsel.legs import LEGS
from footsel.robot import description as description_module
from footsel.robot import load_robot, read_description, robot_names
from footsel.robot.robot import stance_configuration


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal_b")


def test_unknown_names_list_those_that_exist():
    assert "anymal_b" in robot_names()
    with pytest.raises(UnknownNameError, match=r"unknown robot 'anymal'; choose from: .*anymal_b"):
        read_description("anymal")
    with pytest.raises(UnknownNameError, match="limit set of anymal_b 'urdf'; choose from: nominal_branch, anymal_c"):
        read_description("anymal_b", limits="urdf")


def test_reversed_limits_are_refused():
    with pytest.raises(InputError, match="lower limit comes first"):
        description_module._limit_of([1.0, -1.0], "LF")


@pytest.mark.parametrize("limits", [None, "nominal_branch", "anymal_c_abduction"])
def test_description_is_consistent(limits):
    description = read_description("anymal_b", limits)
    assert description.limits_name == (limits or "nominal_branch")
    for leg in LEGS:
        low, high = np.array(description.limits[leg]).T
        stance = np.array(description.stance[leg])
        assert ((low < stance) & (stance < high)).all()
        assert description.joints[leg] == (f"{leg}_HAA", f"{leg}_HFE", f"{leg}_KFE")
    for left, right in (("LF", "RF"), ("LH", "RH")):
        mirrored = np.array(description.limits[left]) * [[-1], [1], [1]]
        np.testing.assert_allclose(np.sort(mirrored, axis=1), description.limits[right])
        np.testing.assert_allclose(np.array(description.stance[left]) * [-1, 1, 1], description.stance[right])


def test_a_named_limit_set_reaches_the_kinematics():
    narrow, wide = (load_robot("anymal_b", limits=name) for name in ("anymal_c_abduction", None))
    outwards = wide.kinematics["LF"].forward([0.9, 0.7, -1.0])
    assert wide.kinematics["LF"].inverse(outwards)[1].all()
    assert not narrow.kinematics["LF"].inverse(outwards)[1].any()
    assert load_robot("anymal_b") is load_robot("anymal_b")


def test_layout_of_anymal_b(robot):
    """Link lengths of the URDF; stance, foot radius and symmetry."""
    layout = robot.layout
    assert (layout.resolution, layout.height_range, layout.foot_radius) == (0.02, 0.85, 0.031)
    np.testing.assert_allclose(layout.hips["LF"], [0.3405, 0.246, 0.0], atol=1e-9)
    for leg in LEGS:
        kinematics = robot.kinematics[leg]
        assert np.linalg.norm(kinematics.thigh) == pytest.approx(0.25, abs=1e-9)
        assert np.linalg.norm(kinematics.shank) == pytest.approx(0.3143, abs=1e-4)
        assert abs(kinematics.plane_offset) == pytest.approx(0.13, abs=1e-9)
        front, left = (1 if leg[1] == "F" else -1), (1 if leg[0] == "L" else -1)
        np.testing.assert_allclose(layout.hips[leg], layout.hips["LF"] * [front, left, 1], atol=1e-9)
        np.testing.assert_allclose(layout.nominal_feet[leg], layout.nominal_feet["LF"] * [front, left, 1], atol=1e-9)
        contact = layout.hips[leg] + kinematics.forward(robot.description.stance[leg]) - [0, 0, 0.031]
        np.testing.assert_allclose(layout.nominal_feet[leg], contact)
    assert layout.standing_height == pytest.approx(0.488, abs=1e-3)
    restored = LegLayout.from_dict(layout.to_dict())
    np.testing.assert_array_equal(restored.hips["RH"], layout.hips["RH"])


def test_joints_are_addressed_by_name(robot):
    """Pinocchio orders the legs LF LH RF RH, footsel LF RF LH RH."""
    assert [name for name in robot.model.names if name.endswith("HAA")] == ["LF_HAA", "LH_HAA", "RF_HAA", "RH_HAA"]
    stance = stance_configuration(robot.description, robot.model)
    for leg in LEGS:
        for name, angle in zip(robot.description.joints[leg], robot.description.stance[leg], strict=True):
            assert stance[robot.model.joints[robot.model.getJointId(name)].idx_q] == angle


def test_margins_of_right_legs_fall_back_to_the_left_ones(robot):
    for left, right in (("LF", "RF"), ("LH", "RH")):
        assert robot.margin_max(right) == robot.margin_max(left) > 0


def test_names_of_robots_are_listed_without_loading_a_model():
    code = (
        "import sys; from footsel.robot import read_description, robot_names; read_description(robot_names()[0]);"
        "print(sorted({'coal', 'numba', 'pinocchio'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
