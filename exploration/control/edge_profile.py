"""The mean profile of depth across a tracked edge: what no single frame tells, all frames of a track together do.

Every taxel of every tick lies some distance t inside the edge as the frames about that tick were fitted: of their
own frame alone, the fit would follow the very noise that is to be averaged.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from scipy.ndimage import uniform_filter1d

from exploration.control.edge_ticks import EdgeTick
from exploration.sensing.lines.bent_edge import inside
from exploration.sensing.response import Response
from primitives.arrays import Floats

OUTSIDE, INSIDE = -6.0, 8.0  # [mm] of the profile
BIN = 0.05  # [mm]
BESIDE = 12.0  # [mm] along the edge, either way, that a frame speaks for
CLEAR = 2.0  # [mm] kept from where the face ends
LEAST = 60  # ticks that a profile needs
SMOOTHED = 21  # ticks, over which the pad hardly moves across the edge
FILLED = 6  # bins that a profile needs


@dataclass(frozen=True)
class EdgeProfile:
    """Depth across an edge, averaged."""

    place: Floats  # (n,) [mm] inside the edge as it was fitted
    depth: Floats  # (n,) [mm]
    sigma: Floats  # (n,) [mm] of the mean
    width: float  # [mm] standard deviation of the response


def profile_of(ticks: Sequence[EdgeTick], response: Response) -> EdgeProfile | None:
    """The profile that some ticks saw; None where they are too few."""
    if len(ticks) < LEAST:
        return None
    lines = np.array([tick.edge.parameters for tick in ticks])
    lines[:, 0] = np.unwrap(lines[:, 0])
    lines = uniform_filter1d(lines, SMOOTHED, axis=0, mode="nearest")
    sums, wide = np.zeros((round((INSIDE - OUTSIDE) / BIN), 3)), np.zeros(2)
    shares = np.median(lines[:, 2]) / lines[:, 2]  # to one press
    for tick, line, share in zip(ticks, lines, shares, strict=True):
        edge, pitch = tick.edge, tick.image.array.pitch
        ends = (CLEAR - edge.behind, min(edge.ahead, edge.opens) - CLEAR, edge.width - CLEAR)
        _add(
            tick.image.depth,
            tick.image.sigma,
            pitch,
            share,
            line,
            float(edge.side),
            ends,
            response.variance,
            sums,
            wide,
        )
    seen = sums[:, 0] > 0.0
    if seen.sum() < FILLED:
        return None
    weight, placed, felt = sums[seen].T
    return EdgeProfile(
        placed / weight, felt / weight, 1.0 / np.sqrt(weight), float(np.sqrt(wide[1] / wide[0]))
    )


@numba.njit(cache=True, error_model="numpy")
def _add(
    depth: Floats,
    sigma: Floats,
    pitch: tuple[float, float],
    share: float,
    p: Floats,
    side: float,
    ends: tuple[float, float, float],
    variance: Floats,
    sums: Floats,
    wide: Floats,
) -> None:
    """Add one frame to the bins' weights, places and depths, and to the weight and variance of all."""
    rows, columns = depth.shape
    ca, sa = np.cos(p[0]), np.sin(p[0])
    across = variance[0] * sa * sa + variance[1] * ca * ca
    for i in range(rows):
        y = (i - (rows - 1) / 2) * pitch[1]
        for j in range(columns):
            x = (j - (columns - 1) / 2) * pitch[0]
            v = ca * x + sa * y
            if sigma[i, j] == np.inf or abs(v) > BESIDE or not ends[0] < v < ends[1]:
                continue
            t = inside(side * (ca * y - sa * x - p[1]), v, p[5])[0]
            k = int(np.floor((t - OUTSIDE) / BIN))
            if k < 0 or k >= len(sums) or t > ends[2]:
                continue
            weight = 1.0 / sigma[i, j] ** 2
            sums[k, 0] += weight
            sums[k, 1] += weight * t
            sums[k, 2] += weight * depth[i, j] * share
            wide[0] += weight
            wide[1] += weight * across
