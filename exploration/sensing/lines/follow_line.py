"""An edge that is expected, followed from one frame to the next: no search, one fit, one kernel.

The model is `line_fit`'s, bent to a curvature kappa (of the edge, in the pad's plane, positive where it bends
toward the material): with a the angle, rho the offset, s the material's side, (u, v) coordinates across and along
the line, and d = s (u - rho), the distance from a circle of curvature kappa is

    t = 2 (d - kappa (d^2 + v^2) / 2) / (1 + D),   D = sqrt((1 - kappa d)^2 + kappa^2 v^2),
    depth = (A + c v) edge(t/w) + b w ramp(t/w).

One frame tells kappa to some 0.005 /mm only; what is expected of it enters as one more reading, so that from
frame to frame it is filtered as Kalman would.

Blurring a bent edge moves its half-height crossing by kappa w^2 / 2 toward the hollow side (the heat flow that a
Gaussian blur is, to second order), which is taken off the offset.

What is not that edge is looked for first and left out: the profile of depth along the edge, just inside it, says
where the face ends ahead and behind (a corner, a rim); just outside it, where material begins (an inside corner);
the profile across it, where the face ends opposite (a thin wall).
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line_fit import HUBER
from exploration.sensing.response import Response, look_up
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats

STEPS = 8
INSIDE = (1.0, 5.0)  # [response widths] from the edge, of the strip whose end is the face's end
OUTSIDE = (-5.0, -2.0)  # the strip in which contact means that the material goes round a corner
CLEAR = 1.5  # [response widths] kept from such ends
LEAST = 12  # taxels that a fit needs


@dataclass(frozen=True)
class Expected:
    """Where an edge should be: the last fit, moved by what the pad has moved since."""

    angle: float  # [rad] of the direction of travel, any turn
    offset: float  # [mm] along (-sin, cos) of the angle
    side: int  # of the material
    bend: float = 0.0  # [1/mm] curvature of the edge, positive toward the material
    bend_sigma: float = 1e-6  # [1/mm]
    reach: float = np.inf  # [mm] along the edge, either way, that is fitted


@dataclass(frozen=True)
class Followed:
    """The edge in one frame, in the direction of travel; false where it was lost."""

    angle: float  # [rad]
    offset: float  # [mm]
    side: int
    plateau: float  # [mm] depth of the face at the edge, beside the pad's center
    slope: Floats  # (2,) of the face's depth, in the pad's axes
    bend: float  # [1/mm]
    covariance: Floats  # (6, 6) of angle, offset, plateau, slope inward, slope along, bend
    misfit: float  # chi2 per degree of freedom
    ahead: float  # [mm] from the pad's center, along the edge, to where the face ends; inf: not seen
    behind: float  # [mm] the same, backward
    opens: float  # [mm] ahead, to where material begins outside; inf: none
    width: float  # [mm] from the edge to where the face ends opposite; inf: not seen
    area: float  # [mm^2] in contact
    centroid: Floats  # (2,) [mm] of it
    found: bool

    def __bool__(self) -> bool:
        return self.found

    @property
    def direction(self) -> Floats:
        """(2,) unit vector of travel."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def inward(self) -> Floats:
        """(2,) unit vector into the material."""
        return self.side * np.array([-np.sin(self.angle), np.cos(self.angle)])

    @property
    def foot(self) -> Floats:
        """(2,) [mm] the point of the edge beside the pad's center."""
        return self.offset * np.array([-np.sin(self.angle), np.cos(self.angle)])


def follow_line(image: TactileImage, response: Response, expected: Expected) -> Followed:
    """Fit the expected edge to a frame; `image` as `softened` where the skin ends near the pad."""
    px, py = image.array.pitch
    p, covariance, chi2, count, ends, contact, found = _follow(
        image.depth,
        image.sigma,
        px,
        py,
        response.table,
        response.variance,
        (expected.angle, expected.offset, float(expected.side), expected.bend),
        expected.bend_sigma,
        expected.reach,
    )
    e = np.array([np.cos(p[0]), np.sin(p[0])])
    inward = expected.side * np.array([-e[1], e[0]])
    return Followed(
        angle=float(p[0]),
        offset=float(p[1]),
        side=expected.side,
        plateau=float(p[2]),
        slope=p[3] * inward + p[4] * e,
        bend=float(p[5]),
        covariance=covariance,
        misfit=chi2 / max(1, count - 5),
        ahead=float(ends[0]),
        behind=float(ends[1]),
        opens=float(ends[2]),
        width=float(ends[3]),
        area=float(contact[0]),
        centroid=contact[1:],
        found=found,
    )


@numba.njit(cache=True, inline="always")
def _inside(d: float, v: float, bend: float) -> tuple[float, float, float, float]:
    """Distance t inside a bent edge, and its derivatives by d, v and (to first order) the bend."""
    root = np.sqrt((1.0 - bend * d) ** 2 + (bend * v) ** 2)
    square = d * d + v * v
    share = 1.0 / (1.0 + root)
    return (2.0 * d - bend * square) * share, (1.0 - bend * d) / root, -bend * v / root, -square * share


@numba.njit(cache=True, error_model="numpy")
def _profile_end(total: Floats, count: Floats, start: int, step: int, level: float, falling: bool) -> float:
    """The bin, between bins, at which the mean passes `level` going from `start`; inf if it never does."""
    last = np.nan
    k = start
    while 0 <= k < len(total):
        if count[k] > 0:
            mean = total[k] / count[k]
            if (mean < level) == falling:
                if np.isnan(last):
                    return float(k)
                return float(k - step * (level - mean) / (last - mean))
            last = mean
        k += step
    return np.inf


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _ends(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    angle: float,
    offset: float,
    side: float,
    bend: float,
    width: float,
) -> tuple[Floats, Floats, float]:
    """Where the face ends ahead, behind, begins outside, ends opposite; area and centroid; its middle depth."""
    rows, columns = depth.shape
    ca, sa = np.cos(angle), np.sin(angle)
    pitch = max(px, py)
    reach = 0.5 * np.hypot(rows * py, columns * px)
    bins = 2 * int(np.ceil(reach / pitch)) + 1
    middle = bins // 2
    inner, n_inner = np.zeros(bins), np.zeros(bins)
    outer, n_outer = np.zeros(bins), np.zeros(bins)
    across, n_across = np.zeros(2 * bins), np.zeros(2 * bins)
    level, n_level = 0.0, 0
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            x = (j - (columns - 1) / 2) * px
            v = ca * x + sa * y
            t = _inside(side * (ca * y - sa * x - offset), v, bend)[0] / width
            k = middle + int(np.rint(v / pitch))
            if INSIDE[0] < t < INSIDE[1]:
                inner[k] += depth[i, j]
                n_inner[k] += 1.0
                if abs(v) < 2.0 * pitch:
                    level += depth[i, j]
                    n_level += 1
            elif OUTSIDE[0] < t < OUTSIDE[1]:
                outer[k] += depth[i, j]
                n_outer[k] += 1.0
    ends = np.full(4, np.inf)
    contact = np.zeros(3)
    if n_level < 2:
        return ends, contact, 0.0
    level /= n_level
    half = 0.5 * level
    ends[0] = (_profile_end(inner, n_inner, middle, 1, half, True) - middle) * pitch
    ends[1] = (middle - _profile_end(inner, n_inner, middle, -1, half, True)) * pitch
    if ends[1] == -np.inf:
        ends[1] = np.inf
    ends[2] = (_profile_end(outer, n_outer, middle, 1, half, False) - middle) * pitch
    low = max(-2.5 * pitch, -ends[1] + width)
    high = min(2.5 * pitch, min(ends[0], ends[2]) - width)
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            x = (j - (columns - 1) / 2) * px
            if depth[i, j] > half:
                contact[0] += 1.0
                contact[1] += x
                contact[2] += y
            v = ca * x + sa * y
            if low < v < high:
                t = _inside(side * (ca * y - sa * x - offset), v, bend)[0]
                k = int(t / pitch)
                if t > 0.0 and k < 2 * bins:
                    across[k] += depth[i, j]
                    n_across[k] += 1.0
    peak = 0.0
    for k in range(2 * bins):
        if n_across[k] > 1.0:
            peak = max(peak, across[k] / n_across[k])
    half = 0.5 * peak
    ends[3] = (_profile_end(across, n_across, int(np.ceil(width / pitch)), 1, half, True) + 0.5) * pitch
    if contact[0] > 0.0:
        contact[1] /= contact[0]
        contact[2] /= contact[0]
    contact[0] *= px * py
    return ends, contact, level


@numba.njit(cache=True, error_model="numpy")
def _chosen(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    line: tuple[float, float, float, float],
    window: tuple[float, float, float],
) -> Floats:
    """(n, 4) x, y, depth and 1/sigma of the taxels from `low` to `high` along the line and not beyond `far`."""
    angle, offset, side, bend = line
    low, high, far = window
    rows, columns = depth.shape
    ca, sa = np.cos(angle), np.sin(angle)
    out = np.empty((rows * columns, 4))
    n = 0
    for i in range(rows):
        y = (i - (rows - 1) / 2) * py
        for j in range(columns):
            x = (j - (columns - 1) / 2) * px
            v = ca * x + sa * y
            t = _inside(side * (ca * y - sa * x - offset), v, bend)[0]
            if sigma[i, j] < np.inf and low < v < high and t < far:
                out[n, 0], out[n, 1] = x, y
                out[n, 2], out[n, 3] = depth[i, j], 1.0 / sigma[i, j]
                n += 1
    return out[:n]


@numba.njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def _normal(
    taxels: Floats,
    table: Floats,
    width: float,
    p: Floats,
    side: float,
    prior: tuple[float, float],
    normal: Floats,
    rhs: Floats,
) -> float:
    """Fill the normal equations at p; the chi2 there (Huber's), the prior (bend, sigma) among it."""
    normal[:] = 0.0
    rhs[:] = 0.0
    ca, sa = np.cos(p[0]), np.sin(p[0])
    chi2 = 0.0
    j6 = np.empty(6)
    for k in range(len(taxels)):
        x, y, weight = taxels[k, 0], taxels[k, 1], taxels[k, 3]
        u, v = ca * y - sa * x, ca * x + sa * y
        t, by_d, by_v, by_bend = _inside(side * (u - p[1]), v, p[5])
        change, step, slant = look_up(table, t / width, 0)
        change, slant = change / width, slant * width
        r = (taxels[k, 2] - (p[2] + p[4] * v) * step - p[3] * slant) * weight
        size = abs(r)
        if size > HUBER:
            chi2 += HUBER * (2.0 * size - HUBER)
            share = np.sqrt(HUBER / size)
            weight *= share
            r *= share
        else:
            chi2 += r * r
        if step == 0.0:
            continue
        steep = (p[2] + p[4] * v) * change + p[3] * step
        j6[0] = ((by_v * u - by_d * side * v) * steep + p[4] * u * step) * weight
        j6[1] = -side * by_d * steep * weight
        j6[2] = step * weight
        j6[3] = slant * weight
        j6[4] = v * step * weight
        j6[5] = by_bend * steep * weight
        for a in range(6):
            rhs[a] += j6[a] * r
            for b in range(a + 1):
                normal[a, b] += j6[a] * j6[b]
    for a in range(6):
        for b in range(a):
            normal[b, a] = normal[a, b]
    surprise = (prior[0] - p[5]) / prior[1]
    normal[5, 5] += 1.0 / prior[1] ** 2
    rhs[5] += surprise / prior[1]
    return float(chi2 + surprise * surprise)


@numba.njit(cache=True, error_model="numpy")
def _follow(
    depth: Floats,
    sigma: Floats,
    px: float,
    py: float,
    table: Floats,
    variance: Floats,
    line: tuple[float, float, float, float],
    bend_sigma: float,
    reach: float,
) -> tuple[Floats, Floats, float, int, Floats, Floats, bool]:
    angle, offset, side, bend = line
    normal, rhs = np.zeros((6, 6)), np.zeros(6)
    sa, ca = np.sin(angle), np.cos(angle)
    width = np.sqrt(variance[0] * sa * sa + variance[1] * ca * ca)
    p = np.array([angle, offset, 0.0, 0.0, 0.0, bend])
    covariance = np.zeros((6, 6))
    ends, contact, level = _ends(depth, sigma, px, py, angle, offset, side, bend, width)
    if level <= 0.0:
        return p, covariance, 0.0, 0, ends, contact, False
    clear = CLEAR * width
    low, high = max(-reach, -ends[1] + clear), min(reach, min(ends[0], ends[2]) - clear)
    taxels = _chosen(depth, sigma, px, py, line, (low, high, max(ends[3] - clear, 0.5 * width)))
    count = len(taxels)
    if count < LEAST:
        return p, covariance, 0.0, count, ends, contact, False
    p[2] = level
    prior = (bend, bend_sigma)
    chi2 = _normal(taxels, table, width, p, side, prior, normal, rhs)
    damping = 0.0
    for _ in range(STEPS):
        damped = normal.copy()
        for a in range(6):
            damped[a, a] *= 1.0 + damping
        ok, inverse = invert(damped)
        if not ok:
            return p, covariance, chi2, count, ends, contact, False
        step = inverse @ rhs
        trial = p + step
        new = _normal(taxels, table, width, trial, side, prior, normal, rhs)
        if not new < chi2 + 1e-9:
            _normal(taxels, table, width, p, side, prior, normal, rhs)
            damping = max(1e-2, 10.0 * damping)
            if damping > 1e2:
                break
            continue
        gained = chi2 - new
        p, chi2 = trial, new
        damping = 0.1 * damping if damping > 1e-3 else 0.0
        if gained < 0.05:
            break
    ok, covariance = invert(normal)
    p[1] -= side * 0.5 * p[5] * width * width
    strong = ok and p[2] > 5.0 * np.sqrt(covariance[2, 2])
    near = abs(p[0] - angle) < 0.5 and abs(p[1] - offset) < 4.0 * width
    return p, covariance, chi2, count, ends, contact, strong and near
