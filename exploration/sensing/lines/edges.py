"""Edge points between taxels: where depth crosses half of the plateau that stands beside it.

A pressed edge is seen as z(d) = z0/2 (1 - erf(d / (sqrt(2) sigma))) (see `response`), so the edge is the z0/2
crossing.  z0 is taken from the contact next to the crossing, not from a threshold: its local plateau (see
`contact_mask`).  A crossing between two neighboring taxels is interpolated linearly; noise sigma_z there moves it
by sigma_z / |gradient| along the normal.  Its weight is its sharpness: the gradient over that of a perfect edge,
z0 / (sqrt(2 pi) width), squared and at most 1.
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.contact_mask import LEAST_PLATEAU, noise_of, plateau_of, repaired
from exploration.sensing.frame import TactileImage
from exploration.sensing.response import Response, response_of
from primitives.arrays import Floats

LEAST_SHARPNESS = 0.3  # of a perfect edge's gradient
LEAST_ALIGNMENT = 0.3  # |cosine| between the gradient and the pair of taxels that is crossed


@dataclass(frozen=True)
class EdgePoints:
    """Sub-taxel edge points of one frame; false where there are none."""

    points: Floats  # (n, 2) [mm] from the pad's center
    directions: Floats  # (n, 2) unit gradients: into the material
    sigma: Floats  # (n,) [mm] standard deviation along the direction
    weight: Floats  # (n,) sharpness, 0 to 1

    def __len__(self) -> int:
        return len(self.points)


def edge_points(image: TactileImage, response: Response | None = None) -> EdgePoints:
    """The half-plateau crossings of a frame."""
    response = response_of(image, response)
    found = _crossings(image.depth, image.sigma, *image.array.pitch, response.mean_width)
    found.flags.writeable = False
    return EdgePoints(found[:, 0:2], found[:, 2:4], found[:, 4], found[:, 5])


@numba.njit(cache=True)
def _gradient(depth: Floats, i: int, j: int, px: float, py: float) -> tuple[float, float]:
    rows, columns = depth.shape
    left, right = max(0, j - 1), min(columns - 1, j + 1)
    low, high = max(0, i - 1), min(rows - 1, i + 1)
    gx = gy = 0.0
    for a in range(low, high + 1):
        gx += depth[a, right] - depth[a, left]
    for b in range(left, right + 1):
        gy += depth[high, b] - depth[low, b]
    gx /= max(1, right - left) * px * (high - low + 1)
    gy /= max(1, high - low) * py * (right - left + 1)
    return gx, gy


@numba.njit(cache=True)
def _crossings(raw: Floats, sigma: Floats, px: float, py: float, width: float) -> Floats:
    rows, columns = raw.shape
    depth, alive = repaired(raw, sigma)
    noise = noise_of(sigma)
    plateau = plateau_of(depth, px, py, width)
    out = np.empty((2 * rows * columns, 6))
    n = 0
    for i in range(rows):
        for j in range(columns):
            for axis in range(2):
                a, b = (i, j + 1) if axis == 0 else (i + 1, j)
                if a >= rows or b >= columns or not (alive[i, j] or alive[a, b]):
                    continue
                top = max(plateau[i, j], plateau[a, b])
                z0, z1 = depth[i, j] - top / 2, depth[a, b] - top / 2
                if top < LEAST_PLATEAU * noise or z0 * z1 >= 0.0:
                    continue
                f = z0 / (z0 - z1)
                gx0, gy0 = _gradient(depth, i, j, px, py)
                gx1, gy1 = _gradient(depth, a, b, px, py)
                gx, gy = gx0 + f * (gx1 - gx0), gy0 + f * (gy1 - gy0)
                size = np.hypot(gx, gy)
                sharpness = size * width * 2.5066282746310002 / top
                if sharpness < LEAST_SHARPNESS or abs(gx if axis == 0 else gy) < LEAST_ALIGNMENT * size:
                    continue
                out[n, 0] = (j - (columns - 1) / 2 + (f if axis == 0 else 0.0)) * px
                out[n, 1] = (i - (rows - 1) / 2 + (f if axis == 1 else 0.0)) * py
                out[n, 2] = gx / size
                out[n, 3] = gy / size
                out[n, 4] = noise * np.sqrt(f * f + (1 - f) * (1 - f)) / size
                out[n, 5] = min(1.0, sharpness * sharpness)
                if not (alive[i, j] and alive[a, b]):
                    out[n, 4] *= 2.0
                    out[n, 5] *= 0.25
                n += 1
    return out[:n].copy()
