"""Simplification changes no output, and removes what it should."""

import copy

import numpy as np
import pytest
import torch
from torch import nn

from footsel.exporting.onnx_file import to_onnx
from footsel.exporting.parity import graph_logits
from footsel.exporting.simplify import FoldedDownsampler, simplified, trim_padding_taps
from footsel.learning.erfnet import Downsampler, FirstDownsampler


def parameters(network):
    return sum(parameter.numel() for parameter in network.parameters())


@pytest.mark.parametrize("recipe", ["paper", "footsel"])
def test_every_logit_stays(makers, anymal_layout, recipe):
    network = makers.uneven_network(0, anymal_layout, recipe)
    maps = torch.rand(20, network.in_channels, 40, 40)
    with torch.no_grad():
        expected, found = network(maps), simplified(network, network.in_channels)(maps)
    assert expected.std() > 0.1  # A thousand times what is allowed below.
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-4)


def test_what_was_for_training_alone_is_gone(makers, anymal_layout):
    network = makers.uneven_network(0, anymal_layout)
    assert "reason_head.weight" in network.state_dict()
    assert "reason_head.weight" not in simplified(network, network.in_channels).state_dict()


def test_the_network_itself_is_untouched(makers, anymal_layout):
    network = makers.uneven_network(0, anymal_layout)
    before = copy.deepcopy(network.state_dict())
    simplified(network, network.in_channels)
    assert before.keys() == network.state_dict().keys()
    assert all(torch.equal(value, before[name]) for name, value in network.state_dict().items())


def test_erfnet_loses_the_outer_taps_of_dilations_8_and_16(makers, anymal_layout):
    network = makers.uneven_network(0, anymal_layout, "paper")
    maps = torch.rand(5, 1, 40, 40)
    with torch.no_grad():
        expected = network(maps)
        assert trim_padding_taps(network, maps[:1]) == 262_144
        # Nothing but products with zero is left out.
        torch.testing.assert_close(network(maps), expected, rtol=1e-5, atol=1e-5)
        assert trim_padding_taps(network, maps[:1]) == 0


@pytest.mark.parametrize("kernel", [1, 3, 5])
@pytest.mark.parametrize("dilation", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("size", [3, 5, 8])
@pytest.mark.parametrize("stride", [1, 2])
def test_trimming_any_convolution(kernel, dilation, size, stride):
    torch.manual_seed(0)
    padding = dilation * (kernel - 1) // 2
    network = nn.Sequential(
        nn.Conv2d(2, 3, (kernel, 3), padding=(padding, 1), dilation=(dilation, 1), stride=(stride, 1))
    )
    maps = torch.rand(2, 2, size, 7)
    with torch.no_grad():
        expected = network(maps)
        weight = network[0].weight.clone()
        removed = trim_padding_taps(network, maps[:1])
        torch.testing.assert_close(network(maps), expected)
    # A tap is of use exactly if the output changes with it.
    useful = 0
    for tap in range(kernel):
        without = weight.clone()
        without[:, :, tap] = 0
        out = nn.functional.conv2d(
            maps, without, network[0].bias, (stride, 1), padding=(padding, 1), dilation=(dilation, 1)
        )
        useful += not torch.allclose(out, expected)
    assert removed == (kernel - useful) * 2 * 3 * 3


def test_taps_that_see_the_map_stay():
    network = nn.Sequential(nn.Conv2d(1, 1, 3, padding=4, dilation=4))
    assert trim_padding_taps(network, torch.zeros(1, 1, 5, 5)) == 0


def test_a_folded_downsampler_is_the_downsampler(makers, anymal_layout):
    network = makers.uneven_network(1, anymal_layout, "paper")
    source = next(m for m in network.encoder[1:] if isinstance(m, Downsampler))
    folded = FoldedDownsampler(source)
    maps = torch.randn(3, 16, 10, 10)
    with torch.no_grad():
        torch.testing.assert_close(folded(maps), source(maps), rtol=1e-5, atol=1e-5)
    assert not any(isinstance(m, nn.BatchNorm2d) for m in folded.modules())
    # Among the pooled channels is a negative scale, where scaling before the pooling would be wrong.
    assert folded.affine.weight.min() < 0


def test_the_first_layer_stays_exact():
    """What is folded into it is not rounded to float32 again: small steps on high ground are told as in float64."""
    torch.manual_seed(0)
    first = FirstDownsampler(1, 7).eval()
    maps = 0.7 + 0.003 * torch.rand(20, 1, 40, 40)
    with torch.no_grad():
        first.convolution.weight -= first.convolution.weight.mean(dim=(2, 3), keepdim=True)
        first.norm.running_var[:-1], first.norm.eps = 1e-6, 1e-9
        first.norm.running_mean[:-1] = first.convolution(maps)[:, :, 1:, 1:].mean(dim=(0, 2, 3))
        expected = copy.deepcopy(first).double()(maps.double())
        folded = simplified(nn.Sequential(first), 1)
        exported = torch.from_numpy(graph_logits(to_onnx(folded, 1))(maps.numpy()))
    # The convolved channels, but not at the map's border, where steps are as high as the ground.
    steps = np.s_[:, :-1, 1:, 1:]
    for found in (folded(maps), exported):
        assert (found - expected)[steps].abs().max() < 2e-7 * expected[steps].max()
