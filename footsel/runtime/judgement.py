"""What the networks of a robot say of the cells around its legs."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.encoding import InputEncoding
from footsel.legs import PAIRS, pair_of
from footsel.runtime.leg_frames import LegFrames
from footsel.runtime.network import COSTS, Network


@dataclass(frozen=True, eq=False)
class Judgement:
    """What networks say of the maps of m legs, in the axes of LegFrames.

    heights: (m, 40, 40) relative to L_i, NaN = unknown, in [m].
    infeasible: (m, 40, 40) probability of the class "infeasible". cost: (m, 40, 40) mean cost over all classes.
    feasible_below: (m,) a cell may be chosen if `infeasible` is below this.
    """

    heights: NDArray[np.float32]
    infeasible: NDArray[np.float32]
    cost: NDArray[np.float32]
    feasible_below: NDArray[np.float32]


def judge(networks: Mapping[str, Network], heights: NDArray[np.float32], frames: LegFrames) -> Judgement:
    """Each network's view of its pair's legs, all of them in one batch.

    networks: by pair. frames: front legs first, as PAIRS has them. heights: as in Judgement.
    """
    pairs = [pair_of(leg) for leg in frames.legs]
    encoded: dict[InputEncoding, NDArray[np.float32]] = {}
    parts, thresholds = [], []
    start = 0
    for pair in PAIRS:
        if count := pairs.count(pair):
            network = networks[pair]
            # The networks of a robot see alike: what is encoded for one serves both.
            if (encoding := network.contract.encoding) not in encoded:
                encoded[encoding] = network.encode(heights, frames.roll, frames.pitch)
            parts.append(network.run_in_batches(encoded[encoding][start : start + count], *COSTS))
            thresholds += [network.contract.feasible_below] * count
            start += count
    infeasible, cost = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
    return Judgement(heights, infeasible, cost, np.array(thresholds, dtype=np.float32))
