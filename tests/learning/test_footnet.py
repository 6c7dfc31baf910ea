"""FootNet: its cells' places are the geometry's, its parts do what a recipe asks, its second output changes nothing."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import InputEncoding
from footsel.footholds.pose import tilt_rotation
from footsel.learning.build import build_network
from footsel.learning.erfnet import ERFNet
from footsel.learning.footnet import FootNet
from footsel.learning.place import Place
from footsel.learning.recipe import FEATURES, Recipe
from footsel.learning.tilt import tilt_matrix
from footsel.terrain.local_map import cell_offsets

PLANES = ("height", "unknown", "roll", "pitch")
WIDTHS, BLOCKS = (12, 8, 16, 24), (1, 1, 2)


@pytest.fixture
def network(layout, skeleton):
    def make(features=FEATURES, planes=PLANES, reasons=False):
        torch.manual_seed(0)
        return FootNet(planes, layout, WIDTHS, BLOCKS, features, reasons, skeleton).eval()

    return make


@pytest.mark.parametrize("bfloat16", [False, True])
def test_places_are_foot_centres_in_base_axes(layout, bfloat16):
    rng = np.random.default_rng(0)
    heights = rng.uniform(-0.8, -0.1, (3, 40, 40)).astype(np.float32)
    roll, pitch = np.array([0.0, 0.17, -0.11]), np.array([0.12, 0.0, -0.15])
    encoded = torch.from_numpy(InputEncoding(PLANES, False, 0.85).encode(heights, roll, pitch))
    with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
        place = Place(layout)(encoded[:, :1], tilt_matrix(encoded[:, 2:3, :1, :1], encoded[:, 3:4, :1, :1]))
    offsets = np.broadcast_to(cell_offsets(40, layout.resolution), (3, 40, 40, 2))
    centres = np.concatenate([offsets, (heights + layout.foot_radius)[..., None]], axis=-1)
    for index in range(3):
        expected = centres[index] @ tilt_rotation(roll[index], pitch[index])  # R^T p, for rows
        found = place[index, :3].permute(1, 2, 0).numpy() * layout.height_range
        np.testing.assert_allclose(found, expected, atol=1e-6)
        np.testing.assert_allclose(place[index, 3:].permute(1, 2, 0).numpy() * 0.85, offsets[index], atol=1e-6)


@pytest.mark.parametrize("features", [(), ("drops",), ("rises", "place"), ("place", "clearance"), FEATURES])
@pytest.mark.parametrize("planes", [("height",), PLANES])
def test_every_cell_gets_fourteen_logits(network, features, planes):
    net = network(features, planes)
    maps = torch.rand(3, len(planes), 40, 40)
    logits = net(maps)
    assert logits.shape == (3, 14, 40, 40) and net.in_channels == len(planes)
    torch.testing.assert_close(net(maps[1:2]), logits[1:2], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_that_is_left_out_is_gone(network, feature):
    builds_on_it = {"place": {"clearance"}}.get(feature, set())
    without = network([name for name in FEATURES if name not in {feature, *builds_on_it}])
    whole = network()
    assert getattr(whole, feature) is not None and getattr(without, feature) is None
    count = [sum(p.numel() for p in net.parameters()) for net in (whole, without)]
    assert count[1] < count[0]


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
        cells = [net._cells(image) for image in maps]
    assert (cells[0] - cells[1])[0, :, 18:22].abs().max() > 1e-3


def test_reasons_are_learnt_beside_and_can_go(network):
    net = network(reasons=True)
    maps = torch.rand(2, 4, 40, 40)
    logits, reasons = net.with_reasons(maps)
    assert reasons.shape == (2, 5, 40, 40)
    assert torch.equal(net(maps), logits)
    without = copy.deepcopy(net)
    without.drop_training_parts()
    assert torch.equal(without(maps), logits)
    assert set(net.state_dict()) - set(without.state_dict()) == {"reason_head.weight", "reason_head.bias"}


def test_no_constant_is_stored_with_the_weights(network):
    """They follow from the layout, so a file is small and cannot contradict it."""
    buffers = {name for name, _ in network().named_buffers()} - set(network().state_dict())
    assert {"drops.weight", "drops.bias", "place.xy", "known_shares.weight", "clearance.leg_axes"} <= buffers


@pytest.mark.parametrize("architecture", ["erfnet", "footnet"])
def test_the_named_bias_is_added_to_the_logits(layout, skeleton, architecture):
    recipe = Recipe.load("paper" if architecture == "erfnet" else "footsel")
    net = build_network(recipe, layout, skeleton).eval()
    assert isinstance(net, ERFNet if architecture == "erfnet" else FootNet)
    maps = torch.rand(1, net.in_channels, 40, 40)
    with torch.no_grad():
        before = net(maps)
        net.get_parameter(net.class_bias).add_(torch.arange(14.0))
        torch.testing.assert_close(net(maps) - before, torch.arange(14.0)[None, :, None, None].expand_as(before))


def test_a_recipe_sets_widths_and_blocks(layout, skeleton):
    recipe = replace(Recipe.load("footsel"), widths=(16, 8, 16, 24), blocks=(0, 1, 3))
    net = build_network(recipe, layout, skeleton)
    assert net.head.in_channels == 8 and [len(stage) for stage in (net.fine, net.middle, net.coarse)] == [0, 1, 3]
