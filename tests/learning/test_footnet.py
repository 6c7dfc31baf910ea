"""FootNet: its cells' places are the geometry's, its parts do what a recipe asks, its second output changes nothing."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.footholds.pose import tilt_rotation
from footsel.learning.build import build_network
from footsel.learning.erfnet import ERFNet
from footsel.learning.footnet import LARGEST_LOGIT, FootNet
from footsel.learning.place import Place
from footsel.learning.recipe import FEATURES, Recipe
from footsel.learning.tilt import Tilt
from footsel.terrain.local_map import cell_offsets

SHAPE = {"cells": (12, 8), "widths": (16, 24), "blocks": (1, 1, 2)}


@pytest.fixture
def network(layout, skeleton):
    def make(features=FEATURES, planes=PLANES, reasons=False):
        torch.manual_seed(0)
        return FootNet(planes, layout, skeleton, **SHAPE, features=features, reasons=reasons).eval()

    return make


@pytest.mark.parametrize("bfloat16", [False, True])
def test_places_are_foot_centres_in_base_axes(layout, bfloat16):
    rng = np.random.default_rng(0)
    heights = rng.uniform(-0.8, -0.1, (3, 40, 40)).astype(np.float32)
    roll, pitch = np.array([0.0, 0.17, -0.11]), np.array([0.12, 0.0, -0.15])
    encoded = torch.from_numpy(InputEncoding(PLANES, False, 0.85).encode(heights, roll, pitch))
    with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
        place = Place(layout)(encoded[:, :1].flatten(2), Tilt(PLANES)(encoded))
    offsets = np.broadcast_to(cell_offsets(40, layout.resolution), (3, 40, 40, 2))
    centres = np.concatenate([offsets, (heights + layout.foot_radius)[..., None]], axis=-1)
    for index in range(3):
        expected = centres[index] @ tilt_rotation(roll[index], pitch[index])  # R^T p, for rows
        found = place[index].T.reshape(40, 40, 3).numpy() * layout.height_range
        np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("features", [(), ("footing",), ("clearance",), ("place", "posture"), FEATURES])
@pytest.mark.parametrize("planes", [("height",), PLANES])
def test_every_cell_gets_fourteen_logits(network, features, planes):
    net = network(features, planes)
    maps = torch.rand(3, len(planes), 40, 40)
    logits = net(maps)
    assert logits.shape == (3, 14, 40, 40) and net.in_channels == len(planes)
    torch.testing.assert_close(net(maps[1:2]), logits[1:2], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_that_is_left_out_is_gone(network, feature):
    whole, without = network(), network([name for name in FEATURES if name != feature])
    # The hip is one of the channels of the clearance.
    channels = 1 if feature == "hip" else whole.geometry(torch.rand(1, len(PLANES), 40, 40))[feature].shape[1]
    assert whole.first.in_channels - without.first.in_channels == channels > 0


def test_the_hip_sees_the_ground_above_it_and_nothing_else_does(network):
    """A wall beside the drive of the hip, which the depth image shows as high as the hip, however high it is."""
    net, encode = network(), InputEncoding(PLANES, False, 0.85).encode
    seen = []
    for top in (0.0, 0.06):
        heights = np.full((1, 40, 40), -0.45, dtype=np.float32)
        heights[:, :, 19:21] = top
        seen.append(net.geometry(torch.from_numpy(encode(heights))))
    low, high = (each.pop("clearance") for each in seen)
    assert (high[:, -1] < low[:, -1] - 0.1).any()
    assert torch.equal(high[:, :-1], low[:, :-1])
    assert all(torch.equal(value, seen[1][name]) for name, value in seen[0].items())


def test_millimetres_are_seen_under_autocast(network):
    """A step of half a millimetre is below what bfloat16 tells apart in a height, and still seen."""
    net = network()
    flat = np.full((1, 40, 40), -0.448, dtype=np.float32)
    step = flat.copy()
    step[:, 20:] += 0.0005
    encode = InputEncoding(PLANES, False, 0.85).encode
    maps = torch.from_numpy(encode(flat)), torch.from_numpy(encode(step))
    assert torch.equal(*(image[:, 0].bfloat16() for image in maps))
    with torch.autocast("cpu", torch.bfloat16):
        cells = [net._first(image) for image in maps]
    assert (cells[0] - cells[1])[0, :, 18:22].abs().max() > 1e-3


def test_reasons_are_learnt_beside_and_can_go(network):
    net = network(reasons=True)
    maps = torch.rand(2, len(PLANES), 40, 40)
    logits, reasons = net.with_reasons(maps)
    assert reasons.shape == (2, 5, 40, 40)
    assert torch.equal(net(maps), logits)
    without = copy.deepcopy(net)
    without.drop_training_parts()
    assert torch.equal(without(maps), logits)
    assert set(net.state_dict()) - set(without.state_dict()) == {"reason_head.weight", "reason_head.bias"}


def test_no_logit_is_surer_than_anyone_needs(network):
    """However steep a network has become: where no leg reaches nothing holds it, and rounding grows with logits."""
    net = network(reasons=True)
    torch.nn.init.normal_(net.head.weight, 0, 1000.0)
    maps = torch.rand(2, len(PLANES), 40, 40)
    with torch.no_grad():
        for logits in (net(maps), net.with_reasons(maps)[0]):
            assert logits.abs().max() == LARGEST_LOGIT


def test_no_constant_is_stored_with_the_weights(network):
    """They follow from the layout, so a file is small and cannot contradict it."""
    buffers = {name for name, _ in network().named_buffers()} - set(network().state_dict())
    assert {"footing.neighbours.weight", "place.known", "posture.axes", "clearance.leg_axes"} <= buffers


@pytest.mark.parametrize("architecture", ["erfnet", "footnet"])
def test_the_named_bias_is_added_to_the_logits(layout, skeleton, architecture):
    recipe = Recipe.load("paper" if architecture == "erfnet" else "footsel")
    net = build_network(recipe, layout, skeleton).eval()
    assert isinstance(net, ERFNet if architecture == "erfnet" else FootNet)
    maps, added = torch.rand(1, net.in_channels, 40, 40), torch.arange(14.0) / 4  # Held logits are not reached.
    with torch.no_grad():
        before = net(maps)
        net.get_parameter(net.class_bias).add_(added)
        torch.testing.assert_close(net(maps) - before, added[None, :, None, None].expand_as(before))


def test_a_recipe_sets_widths_and_blocks(layout, skeleton):
    recipe = replace(Recipe.load("footsel"), cells=(16, 12, 8), widths=(16, 24), blocks=(0, 1, 3))
    net = build_network(recipe, layout, skeleton)
    assert net.first.out_channels == 16 and net.head.in_channels == 8 and len(net.cells) == 3
    assert [len(stage) for stage in net.stages] == [0, 1, 3]

    maps = torch.rand(1, len(recipe.planes), 40, 40)
    alone = build_network(replace(recipe, widths=(), blocks=(0,)), layout, skeleton).eval()
    changed = maps.clone()
    changed[:, 0, 0, 0] += 0.1
    far = torch.equal(alone(maps)[..., 30:, 30:], alone(changed)[..., 30:, 30:])
    assert far, "without context a cell sees no further than its leg"
