"""The network is the paper's: size, shape, order of its layers, receptive field."""

import pytest
import torch
from torch import nn

from footsel.learning.erfnet import Downsampler, ERFNet, NonBottleneck1d, Upsampler


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
        Downsampler,
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
