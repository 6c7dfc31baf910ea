"""ERFNet (Romera et al., IEEE T-ITS 2018), the paper's network (figure 3), for local maps of 40x40 cells.

Encoder 40x40 -> 5x5x128, decoder back to 40x40, no skip connections. Batch normalisation's eps, the biases and the
dropout, which the paper does not name, are those of ERFNet's authors.
"""

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.learning.constants import keep_constant
from footsel.learning.network import FootholdNetwork
from footsel.learning.precision import own_precision
from footsel.terrain import CELLS

BATCH_NORM_EPS = 1e-3
#: Dropout of ERFNet's residual layers, after the second and after the third downsampling.
EARLY_DROPOUT, LATE_DROPOUT = 0.03, 0.3
DILATIONS = (2, 4, 8, 16)


class Downsampler(nn.Module):
    """Half the side: a strided 3x3 convolution beside a max pooling, concatenated to `outputs` channels."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(inputs, outputs - inputs, 3, stride=2, padding=1)
        self.pooling = nn.MaxPool2d(2, stride=2)
        self.norm = nn.BatchNorm2d(outputs, eps=BATCH_NORM_EPS)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, inputs, h, w) -> (n, outputs, h / 2, w / 2)."""
        joined = torch.cat([self.convolution(maps), self.pooling(maps)], dim=1)
        return functional.relu(self.norm(joined))


class FirstDownsampler(Downsampler):
    """Of local maps of 40x40 cells, once trained in float64.

    It learns steps between neighbouring cells, so large heights cancel, and the normalisation makes much of what is
    left: what float32 rounds off here is worth more of a logit than what it does in all other layers together.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs)
        self.convolution = FirstConvolution(inputs, outputs - inputs)

    def forward(self, maps: Tensor) -> Tensor:
        """As Downsampler."""
        if self.training:
            return super().forward(maps)
        with own_precision():
            exact = maps.double()
            joined = torch.cat([self.convolution(exact), self.pooling(exact)], dim=1)
            norm = self.norm
            values = norm.running_mean, norm.running_var, norm.weight, norm.bias
            mean, variance, weight, bias = (value.double() for value in values)  # type: ignore[union-attr]
            normed = functional.batch_norm(joined, mean, variance, weight, bias, eps=norm.eps)
            return functional.relu(normed).to(maps.dtype)


class FirstConvolution(nn.Conv2d):
    """3x3 with stride 2 over local maps, once trained in float64.

    Then as matrix products, for engines know no other convolution in float64: of 0 and 1 that pick the cells which each
    tap sees, exact in any type and faster than an index for each, and of the weights.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs, 3, stride=2, padding=1)
        # (3 * 20, 40): tap after tap, the row that it sees for each row of outputs; nothing on the padding.
        seen = [np.eye(CELLS)[first::2] for first in (0, 1)]
        before = np.vstack([np.zeros(CELLS), seen[1][:-1]])
        keep_constant(self, "seen", np.concatenate([before, *seen]))

    def forward(self, maps: Tensor) -> Tensor:
        """As nn.Conv2d."""
        if self.training:
            return super().forward(maps)
        assert self.bias is not None
        with own_precision():
            side, weight = CELLS // 2, self.weight.double().flatten(1)
            seen = self.get_buffer("seen").to(maps.dtype)
            windows = (seen @ maps @ seen.T).reshape(-1, 3, side, 3, side).transpose(2, 3)
            taps = windows.reshape(-1, weight.shape[1], side**2).double()
            sums = (weight @ taps + self.bias.double().unsqueeze(1)).to(maps.dtype)
            return sums.reshape(-1, self.out_channels, side, side)


class NonBottleneck1d(nn.Module):
    """Residual layer with 3x3 convolutions factorised into 3x1 and 1x3; the second pair is dilated."""

    def __init__(self, channels: int, dropout: float = 0.0, dilation: int = 1) -> None:
        super().__init__()

        def along_rows(d: int) -> nn.Conv2d:
            return nn.Conv2d(channels, channels, (3, 1), padding=(d, 0), dilation=(d, 1))

        def along_columns(d: int) -> nn.Conv2d:
            return nn.Conv2d(channels, channels, (1, 3), padding=(0, d), dilation=(1, d))

        self.branch = nn.Sequential(
            along_rows(1),
            nn.ReLU(inplace=True),
            along_columns(1),
            nn.BatchNorm2d(channels, eps=BATCH_NORM_EPS),
            nn.ReLU(inplace=True),
            along_rows(dilation),
            nn.ReLU(inplace=True),
            along_columns(dilation),
            nn.BatchNorm2d(channels, eps=BATCH_NORM_EPS),
        )
        # Whole channels are dropped; a layer without dropout has no module, so the exported graph has none either.
        if dropout > 0:
            self.branch.append(nn.Dropout2d(dropout))

    def forward(self, maps: Tensor) -> Tensor:
        """(n, channels, h, w) -> the same shape."""
        return functional.relu(self.branch(maps) + maps)


class Upsampler(nn.Module):
    """Twice the side by a strided 3x3 transposed convolution."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.convolution = nn.ConvTranspose2d(inputs, outputs, 3, stride=2, padding=1, output_padding=1)
        self.norm = nn.BatchNorm2d(outputs, eps=BATCH_NORM_EPS)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, inputs, h, w) -> (n, outputs, 2 h, 2 w)."""
        return functional.relu(self.norm(self.convolution(maps)))


class ERFNet(FootholdNetwork):
    """The paper's network, with 2,063,652 parameters.

    in_channels: planes of the input encoding; 1 is the paper's.
    """

    class_bias = "decoder.6.bias"

    def __init__(self, in_channels: int = 1) -> None:
        super().__init__(in_channels)
        self.encoder = nn.Sequential(
            FirstDownsampler(in_channels, 16),
            Downsampler(16, 64),
            *(NonBottleneck1d(64, EARLY_DROPOUT) for _ in range(5)),
            Downsampler(64, 128),
            *(NonBottleneck1d(128, LATE_DROPOUT, dilation) for dilation in DILATIONS * 2),
        )
        self.decoder = nn.Sequential(
            Upsampler(128, 64),
            NonBottleneck1d(64),
            NonBottleneck1d(64),
            Upsampler(64, 16),
            NonBottleneck1d(16),
            NonBottleneck1d(16),
            nn.ConvTranspose2d(16, self.classes, 2, stride=2),
        )

    def forward(self, maps: Tensor) -> Tensor:
        """Logits of every cell."""
        logits: Tensor = self.decoder(self.encoder(maps))
        return logits
