"""An edge that is expected, followed from one frame to the next: no search, one fit (`bent_edge`), one kernel.

One frame tells kappa to some 0.005 /mm only; what is expected of it enters as one more reading, so that from
frame to frame it is filtered as Kalman would.

Blurring a bent edge moves its half-height crossing by kappa w^2 / 2 toward the hollow side (the heat flow that a
Gaussian blur is, to second order), which is taken off the offset.

What is not that edge is looked for first (`face_ends`) and left out.
"""

from dataclasses import dataclass

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.bent_edge import chosen, weighed
from exploration.sensing.lines.face_ends import face_ends
from exploration.sensing.response import Response
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats

STEPS = 8
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
    ends, contact, level = face_ends(depth, sigma, px, py, angle, offset, side, bend, width)
    if level <= 0.0:
        return p, covariance, 0.0, 0, ends, contact, False
    clear = CLEAR * width
    low, high = max(-reach, -ends[1] + clear), min(reach, min(ends[0], ends[2]) - clear)
    taxels = chosen(depth, sigma, px, py, line, (low, high, max(ends[3] - clear, 0.5 * width)))
    count = len(taxels)
    if count < LEAST:
        return p, covariance, 0.0, count, ends, contact, False
    p[2] = level
    prior = (bend, bend_sigma)
    chi2 = weighed(taxels, table, width, p, side, prior, normal, rhs)
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
        new = weighed(taxels, table, width, trial, side, prior, normal, rhs)
        if not new < chi2 + 1e-9:
            weighed(taxels, table, width, p, side, prior, normal, rhs)
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
