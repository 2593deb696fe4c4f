"""Zero and noise, from frames in free air.

The zero of a taxel is its mean; its sigma is noise / sqrt(n).  Noise comes from differences between successive
frames, (c_{t+1} - c_t) / sqrt(2), so that a zero that creeps during the recording does not count as noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.sensing.frame import TaxelFrame
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError

LEAST_FRAMES = 8
_QUANTIZATION = 1.0 / 12.0  # [counts^2] variance of rounding
RESTLESS = 6.0  # times the median taxel's noise, beyond which a taxel is not to be trusted


@dataclass(frozen=True)
class Rest:
    """The array untouched."""

    zero: Floats  # (rows, columns) [counts]
    zero_sigma: float  # [counts]
    noise: float  # [counts] 1 sigma of a reading, of the median taxel
    restless: Bools  # (rows, columns) taxels far noisier than the others


def rest(frames: Sequence[TaxelFrame]) -> Rest:
    """What frames in free air say."""
    if len(frames) < LEAST_FRAMES:
        raise PalpateError(f"{len(frames)} frames in free air are too few; record {LEAST_FRAMES} or more")
    counts = np.array([frame.counts for frame in frames])
    variance = np.mean(np.diff(counts, axis=0) ** 2, axis=0) / 2.0
    typical = float(np.median(variance))
    noise = float(np.sqrt(max(typical, _QUANTIZATION)))
    return Rest(
        frozen(counts.mean(axis=0)),
        noise / float(np.sqrt(len(frames))),
        noise,
        frozen(variance > RESTLESS**2 * max(typical, _QUANTIZATION), np.bool_),
    )


def mean_frame(frames: Sequence[TaxelFrame]) -> TaxelFrame:
    """The mean of frames of one place."""
    if not frames:
        raise PalpateError("a press without frames; record at least one")
    return TaxelFrame(frozen(np.mean([f.counts for f in frames], axis=0)), frames[0].time, frames[0].index)
