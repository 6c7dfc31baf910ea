"""The leg's bend in closed form against the oracle's joint angles."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import TILT_RANGE
from footsel.footholds.pose import tilt_rotation
from footsel.learning.posture import LEAST_SLACK, Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.terrain.local_map import cell_offsets

ROBOT = load_robot("anymal_b")
TILT = (0.2, -0.1)


def postures(leg, heights):
    """(10, 1600) planes, (1600, 3) angles by the oracle and whether it finds any."""
    layout = ROBOT.layout
    depth = torch.from_numpy(-heights / layout.height_range).reshape(1, 1, -1)
    tilt = Tilt(("roll", "pitch"))(torch.tensor(TILT).reshape(1, 2, 1, 1) / TILT_RANGE)
    found = Posture(layout, LegSkeleton.of(ROBOT, leg))(depth, tilt)[0].numpy()
    feet = np.concatenate([cell_offsets(40, 0.02), (heights + layout.foot_radius)[..., None]], axis=-1)
    angles, reachable = ROBOT.kinematics[leg].inverse(feet @ tilt_rotation(*TILT))
    return found, angles, reachable


@pytest.mark.parametrize("leg", LEGS)
def test_it_is_the_bend_of_the_oracle_s_joints(leg):
    heights = np.random.default_rng(0).uniform(-0.6, -0.3, (40, 40)).astype(np.float32)
    found, angles, reachable = postures(leg, heights)
    angles, found = angles[reachable], found[:, reachable]
    kinematics, skeleton = ROBOT.kinematics[leg], LegSkeleton.of(ROBOT, leg)
    abduction, foot, along, across = found[:8].reshape(4, 2, -1)
    knee = along + np.stack([-across[1], across[0]])
    np.testing.assert_allclose(abduction, [np.cos(angles[:, 0]), np.sin(angles[:, 0])], atol=1e-4)

    def in_plane(kinematics):
        """(2, n) the leg's end from the HFE axis along u and w, as shares of its length."""
        level = np.column_stack([np.zeros(len(angles)), angles[:, 1:]])
        ends = (kinematics.forward(level) - skeleton.haa) @ skeleton.basis.T
        return (ends[:, [0, 2]] - skeleton.hfe_offset).T / skeleton.length

    np.testing.assert_allclose(foot, in_plane(kinematics), atol=1e-4)
    np.testing.assert_allclose(knee, in_plane(replace(kinematics, shank=np.zeros(2))), atol=1e-4)
    np.testing.assert_allclose(found[8], (foot**2).sum(axis=0), atol=1e-5)
    slack = (knee**2).sum(axis=0) / found[8] - ((knee * foot).sum(axis=0) / found[8]) ** 2
    np.testing.assert_allclose(found[9], np.clip(slack, -1, 1), atol=1e-3)
    assert reachable.sum() > 200


def test_out_of_reach_the_leg_is_all_but_stretched_and_finite():
    heights = np.full((40, 40), -0.84, dtype=np.float32)
    found, _, reachable = postures("LF", heights)
    foot, across = (np.linalg.norm(found[2 * part : 2 * part + 2], axis=0) for part in (1, 3))
    assert not reachable.any() and np.isfinite(found).all()
    assert (found[9] < 0).all()
    np.testing.assert_allclose(across / foot, np.sqrt(LEAST_SLACK), rtol=1e-5)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_nothing_grows_without_bound(leg):
    """Wherever a foot is put, also where no leg reaches: a tenth of a millimetre moves no plane by much more than in
    reach. Else engines that round differently would disagree there."""
    heights = np.random.default_rng(1).uniform(-0.85, 0.4, (40, 40)).astype(np.float32)
    moved = (heights + np.float32(1e-4)).astype(np.float32)
    (before, _, reachable), (after, _, _) = postures(leg, heights), postures(leg, moved)
    change = np.abs(after - before).max(axis=0) / 1e-4
    assert reachable.sum() > 100 and change.max() < 10 * change[reachable].max()


def test_nothing_is_learnt_and_nothing_is_rounded():
    layer = Posture(ROBOT.layout, LegSkeleton.of(ROBOT, "LF"))
    depth, tilt = torch.rand(1, 1, 1600), torch.eye(3)[None].double()
    with torch.autocast("cpu", torch.bfloat16):
        found = layer(depth.clone().requires_grad_(), tilt)
    assert torch.equal(found, layer(depth, tilt)) and not found.requires_grad
    assert not list(layer.parameters()) and not layer.state_dict()


def test_the_tilt_is_that_of_the_base():
    rolls, pitches = torch.tensor([0.3, -0.8]), torch.tensor([0.0, 0.9])
    matrices = Tilt(("pitch", "height", "roll"))(torch.stack([pitches, rolls, rolls], dim=1)[..., None, None])
    for matrix, roll, pitch in zip(matrices, rolls, pitches, strict=True):
        expected = tilt_rotation(float(roll) * TILT_RANGE, float(pitch) * TILT_RANGE)
        np.testing.assert_allclose(matrix, expected, atol=1e-6)
    torch.testing.assert_close(Tilt(("height",))(torch.rand(2, 1, 40, 40)), torch.eye(3).double().expand(2, 3, 3))
