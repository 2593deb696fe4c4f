"""The pressure slope over the contact: tilt for the servo, every tick.

A plane fitted to the taxels in contact, after the contact mask is eroded by the blur, so that no edge leaks in.
Where the eroded mask is thin the gradient is not known, and `gradient_sigma` says so (inf where untold).
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.contact_mask import repaired, touched, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.response import rubber
from primitives.arrays import Bools, Floats

ERODE = 1.5  # [response widths]


@dataclass(frozen=True)
class Slope:
    """Force and tilt of one frame; false where nothing is felt."""

    force: float  # [N]
    depth: float  # [mm] mean over the eroded mask (the whole mask where erosion leaves nothing)
    gradient: Floats  # (2,) d depth / dx, dy
    gradient_sigma: Floats  # (2,)
    centroid: Floats  # (2,) [mm] of the contact mask
    area: float  # [mm^2] of the contact mask
    mask: Bools  # (rows, columns) contact

    def __bool__(self) -> bool:
        return self.area > 0.0


def contact_slope(image: TactileImage) -> Slope:
    """Force, mean depth and slope of a frame."""
    if not usable(image):
        zero = np.zeros(2)
        return Slope(0.0, 0.0, zero, np.full(2, np.inf), zero, 0.0, np.zeros(image.array.shape, dtype=bool))
    px, py = image.array.pitch
    width = rubber(image.spread, image.array.pitch).mean_width
    values, mask = _slope(image.depth, image.sigma, px, py, width)
    for array in (values, mask):
        array.flags.writeable = False
    return Slope(
        image.stiffness * px * py * float(values[0]),
        float(values[1]),
        values[2:4],
        values[4:6],
        values[6:8],
        px * py * float(values[8]),
        mask,
    )


@numba.njit(cache=True, error_model="numpy")
def _slope(raw: Floats, sigma: Floats, px: float, py: float, width: float) -> tuple[Floats, Bools]:
    depth, alive = repaired(raw, sigma)
    rows, columns = depth.shape
    mask = touched(depth, sigma, px, py, width)
    out = np.zeros(9)
    out[0] = depth.sum()
    out[4], out[5] = np.inf, np.inf
    mean = 0.0
    for i in range(rows):
        for j in range(columns):
            if mask[i, j]:
                out[8] += 1.0
                out[6] += (j - (columns - 1) / 2) * px
                out[7] += (i - (rows - 1) / 2) * py
                mean += depth[i, j]
    if out[8] == 0.0:
        return out, mask
    out[6] /= out[8]
    out[7] /= out[8]
    out[1] = mean / out[8]
    reach_x, reach_y = int(np.round(ERODE * width / px)), int(np.round(ERODE * width / py))
    inner = np.zeros((rows, columns), dtype=np.bool_)
    w = wx = wy = wz = 0.0
    for i in range(rows):
        for j in range(columns):
            keep = mask[i, j] and alive[i, j]
            for a in range(max(0, i - reach_y), min(rows, i + reach_y + 1)):
                for b in range(max(0, j - reach_x), min(columns, j + reach_x + 1)):
                    if not mask[a, b]:
                        keep = False
            if keep:
                inner[i, j] = True
                s = 1.0 / sigma[i, j] ** 2
                w += s
                wx += s * (j - (columns - 1) / 2) * px
                wy += s * (i - (rows - 1) / 2) * py
                wz += s * depth[i, j]
    if w == 0.0:
        return out, mask
    mx, my, mz = wx / w, wy / w, wz / w
    out[1] = mz
    sxx = sxy = syy = sxz = syz = 0.0
    for i in range(rows):
        for j in range(columns):
            if inner[i, j]:
                s = 1.0 / sigma[i, j] ** 2
                dx, dy, dz = (
                    (j - (columns - 1) / 2) * px - mx,
                    (i - (rows - 1) / 2) * py - my,
                    depth[i, j] - mz,
                )
                sxx += s * dx * dx
                sxy += s * dx * dy
                syy += s * dy * dy
                sxz += s * dx * dz
                syz += s * dy * dz
    determinant = sxx * syy - sxy * sxy
    if determinant > 1e-9 * sxx * syy and sxx > 0.0 and syy > 0.0:
        out[2] = (syy * sxz - sxy * syz) / determinant
        out[3] = (sxx * syz - sxy * sxz) / determinant
        out[4] = np.sqrt(syy / determinant)
        out[5] = np.sqrt(sxx / determinant)
    elif sxx > 0.0 and syy <= 1e-9 * sxx:
        out[2], out[4] = sxz / sxx, np.sqrt(1.0 / sxx)
    elif syy > 0.0 and sxx <= 1e-9 * syy:
        out[3], out[5] = syz / syy, np.sqrt(1.0 / syy)
    return out, mask
