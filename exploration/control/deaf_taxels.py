"""Taxels that answer nothing while a tracked edge's face lies under them: dead, and nobody has told.

One frame can only suspect a taxel (`sensing.suspects`), least of all beside an edge, where it moves the line most.
Over a whole track each taxel has its share g of what it should read, by least squares over the frames,

    g = sum(D E) / sum(E^2),    E what the edge that was fitted to the frame makes it read, D what it read,

known to sigma / sqrt(sum E^2).  A living taxel has g near 1, whatever its gain; a dead one 0 (our derivation).

What little a taxel should read just outside the edge depends on where exactly the edge runs.  So those deep in
the face are judged first; where some are deaf, the edge is followed again without them, and the others are judged.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numba
import numpy as np

from exploration.control.edge_ticks import EdgeTick
from exploration.sensing.lines.bent_edge import inside
from exploration.sensing.response import Response, look_up
from primitives.arrays import Bools, Floats, frozen


@dataclass(frozen=True)
class DeafConfig:
    """When a taxel counts as deaf."""

    every: int = 2  # ticks, of which one is looked at
    least: int = 15  # of them
    along: float = 10.0  # [mm] along the edge from the pad's center, either way
    clear: float = 2.0  # [mm] kept from where the face ends
    share: float = 0.2  # of what it should read
    loud: tuple[float, ...] = (0.3, 0.06, 0.06)  # of the face's depth, that it should read at least, in turn
    sure: float = 0.1  # to which its share is known


def hearing(
    ticks: Sequence[EdgeTick],
    response: Response,
    again: Callable[[Sequence[EdgeTick]], list[EdgeTick]],
    config: DeafConfig = DeafConfig(),
) -> list[EdgeTick]:
    """The ticks, deaf taxels left out of their images and their edge followed `again`; as they are without any."""
    out = list(ticks)
    for loud in config.loud:
        deaf = _deaf(out, response, loud, config)
        if deaf is None:
            break
        out = again(
            [
                replace(t, image=replace(t.image, sigma=frozen(np.where(deaf, np.inf, t.image.sigma))))
                for t in out
            ]
        )
    return out


def _deaf(ticks: Sequence[EdgeTick], response: Response, least: float, config: DeafConfig) -> Bools | None:
    """(rows, columns) whether a taxel that should read `least` of the face's depth is deaf; None if nobody is."""
    looked = ticks[:: config.every]
    if len(looked) < config.least:
        return None
    sums = np.zeros((*looked[0].image.array.shape, 4))
    for tick in looked:
        edge = tick.edge
        ends = (
            max(-config.along, config.clear - edge.behind),
            min(config.along, min(edge.ahead, edge.opens) - config.clear),
            edge.width - config.clear,
        )
        image = tick.image
        _add(
            image.depth,
            image.sigma,
            image.array.pitch,
            edge.parameters,
            float(edge.side),
            ends,
            response.table,
            response.variance,
            sums,
        )
    count, square, product, variance = np.moveaxis(sums, 2, 0)
    seen = count >= config.least
    square = np.maximum(square, 1e-12)
    loud = square > least**2 * count
    sure = variance / np.maximum(count, 1.0) < config.sure**2 * square
    deaf = seen & loud & sure & (product < config.share * square)
    return deaf if deaf.any() else None


@numba.njit(cache=True, error_model="numpy")
def _add(
    depth: Floats,
    sigma: Floats,
    pitch: tuple[float, float],
    p: Floats,
    side: float,
    ends: tuple[float, float, float],
    table: Floats,
    variance: Floats,
    sums: Floats,
) -> None:
    """Add one frame to each taxel's count, E^2, D E and variance, with depths over the face's."""
    rows, columns = depth.shape
    ca, sa = np.cos(p[0]), np.sin(p[0])
    width = np.sqrt(variance[0] * sa * sa + variance[1] * ca * ca)
    for i in range(rows):
        y = (i - (rows - 1) / 2) * pitch[1]
        for j in range(columns):
            x = (j - (columns - 1) / 2) * pitch[0]
            v = ca * x + sa * y
            if sigma[i, j] == np.inf or not ends[0] < v < ends[1]:
                continue
            t = inside(side * (ca * y - sa * x - p[1]), v, p[5])[0]
            if t > ends[2]:
                continue
            _, edge, ramp = look_up(table, t / width, 0)
            wanted = (p[2] + p[4] * v) * edge + p[3] * width * ramp
            sums[i, j, 0] += 1.0
            sums[i, j, 1] += (wanted / p[2]) ** 2
            sums[i, j, 2] += wanted * depth[i, j] / p[2] ** 2
            sums[i, j, 3] += (sigma[i, j] / p[2]) ** 2
