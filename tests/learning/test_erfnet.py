"""The network is the paper's: size, shape, order of its layers, receptive field."""

import copy

import numpy as np
import pytest
import torch
from torch import nn

from footsel.learning.erfnet import Downsampler, ERFNet, FirstDownsampler, NonBottleneck1d, Upsampler


def test_the_papers_network_has_the_published_number_of_parameters():
    assert sum(parameter.numel() for parameter in ERFNet().parameters()) == 2_063_652


@pytest.mark.parametrize("in_channels", [1, 4])
def test_every_cell_gets_fourteen_logits(in_channels):
    net = ERFNet(in_channels).eval()
    assert net(torch.zeros(2, in_channels, 40, 40)).shape == (2, 14, 40, 40)
    assert net.encoder(torch.zeros(2, in_channels, 40, 40)).shape == (2, 128, 5, 5)


def test_layers_stand_in_the_papers_order():
    net = ERFNet()
    assert [type(layer) for layer in net.encoder] == [
        FirstDownsampler,
        Downsampler,
        *[NonBottleneck1d] * 5,
        Downsampler,
        *[NonBottleneck1d] * 8,
    ]
    assert [type(layer) for layer in net.decoder] == [
        *[Upsampler, NonBottleneck1d, NonBottleneck1d] * 2,
        nn.ConvTranspose2d,
    ]
    dilations = [layer.branch[5].dilation[0] for layer in net.encoder if isinstance(layer, NonBottleneck1d)]
    assert dilations == [1] * 5 + [2, 4, 8, 16] * 2
    dropouts = [m.p for m in net.modules() if isinstance(m, nn.Dropout2d)]
    assert dropouts == [0.03] * 5 + [0.3] * 8
    assert {m.eps for m in net.modules() if isinstance(m, nn.BatchNorm2d)} == {1e-3}
    assert all(m.bias is not None for m in net.modules() if isinstance(m, nn.Conv2d | nn.ConvTranspose2d))


def test_a_residual_layer_is_3x1_1x3_twice_with_the_second_pair_dilated():
    layer = NonBottleneck1d(8, dropout=0.3, dilation=4)
    convolutions = [m for m in layer.branch if isinstance(m, nn.Conv2d)]
    assert [m.kernel_size for m in convolutions] == [(3, 1), (1, 3)] * 2
    assert [m.dilation for m in convolutions] == [(1, 1), (1, 1), (4, 1), (1, 4)]
    names = [type(m).__name__.replace("Conv2d", "conv").replace("BatchNorm2d", "norm") for m in layer.branch]
    assert names == ["conv", "ReLU", "conv", "norm", "ReLU", "conv", "ReLU", "conv", "norm", "Dropout2d"]


def steps_finder(kind, in_channels):
    """A downsampler that has learnt steps of millimetres between neighbouring cells of ground at any height."""
    torch.manual_seed(0)
    layer = kind(in_channels, in_channels + 6).eval()
    with torch.no_grad():
        layer.convolution.weight -= layer.convolution.weight.mean(dim=(2, 3), keepdim=True)
        layer.convolution.bias.zero_()
        layer.norm.running_var.fill_(1e-7)
        layer.norm.eps = 1e-9
    return layer


@pytest.mark.parametrize("in_channels", [1, 3])
def test_the_first_layer_is_exact_in_use(in_channels):
    maps = 0.7 + 0.003 * torch.rand(20, in_channels, 40, 40)
    usual, first = steps_finder(Downsampler, in_channels), steps_finder(FirstDownsampler, in_channels)
    first.load_state_dict(usual.state_dict())
    with torch.no_grad():
        expected = copy.deepcopy(usual).double()(maps.double())
        # Of the convolved channels, but at the map's border, where steps are high.
        steps = np.s_[:, :6, 1:, 1:]
        errors = [(layer(maps) - expected)[steps].abs().max() / expected[steps].max() for layer in (usual, first)]
        # Not told from the usual one while it is trained.
        torch.testing.assert_close(first.train()(maps), usual.train()(maps))
    assert errors[1] < 2e-7 < errors[0] / 10
