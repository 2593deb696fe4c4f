"""How much likelier an outline is than another, or than the best smooth surface: by Laplace's approximation.

Each reading of a frame has evidence, with chi2 at its best and P the precision of its unknowns there,

    log E = log p - chi2 / 2 s - log det((P + P0) / 2 pi) / 2,

p their density before touch, P0 the precision of a density as wide, so that what the frame leaves open is no wider
after touch than before; and s = max(1, chi2 per degree of freedom of the better reading).  Before touch depth is
even over 2 mm, slopes are N(0, 0.1), lines are even over the pad in angle and offset; so is an arc's nearest
point, and its radius is even in log over two decades; the two sides of a wall are parallel to `ASKEW`.  A smooth
surface's orders weigh as in `order`, its pole even over the pad (our derivation).

A wall and a cylinder, or a pin and a ball, that are hardly wider than the blur are one and the same to the pad.
Who asks for the outline of either (`narrow`) is told how much likelier they are than a cylinder or ball wider than
the pad: one with its curvature held at the pad's own, whose chi2 is greater by the square of what its logarithm
is off, in deviations (in log, for a contact smaller than the blur leaves curvature open upward, not downward).
So are the tip of a corner and a ridge or dome as sharp; balls are weighed at any radius.
"""

from math import atan2, cos, exp, hypot, inf, log, pi, sin

import numba
import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.region_fit import SLOPE, RegionFit
from exploration.sensing.surfaces.footprint import Footprint
from exploration.sensing.surfaces.order import order_contact
from exploration.sensing.surfaces.smooth_fit import SmoothContact
from exploration.sensing.surfaces.smooth_shapes import PLANE
from primitives.arrays import Floats, frozen

PRIOR = {  # of what lies under a pad
    "smooth": 0.4,
    "line": 0.2,
    "two": 0.12,
    "arc": 0.1,
    "three": 0.05,
    "more": 0.05,
}
_KINDS = {
    (0, 0): "smooth",
    (1, 0): "line",
    (2, 0): "two",
    (3, 0): "three",
    (0, 1): "arc",
}  # of lines and arcs
DECADES = log(100.0)  # over which a radius is even
PARALLEL = 0.3  # [sine of the angle] between the two edges of a wall
ASKEW = 0.01  # [rad] by which they are not parallel
BEYOND = 40.0  # [log] by which chi2 alone decides
_SUM = frozen([1.0, 0.0, 1.0])  # of kxx, kxy, kyy in the sum of both curvatures
_NO_BALL = [1, 3]  # orders whose two curvatures differ
_LEVEL = -log(2.0) - 2.0 * log((2.0 * pi) ** 0.5 * SLOPE)  # log density of a depth and two slopes


def log_odds(
    image: TactileImage, fit: RegionFit, contact: SmoothContact, dome: Footprint, narrow: bool = False
) -> float:
    """Log of the odds of an outline against all smooth surfaces; infinite where chi2 leaves no doubt."""
    scale = max(1.0, min(fit.inflation, dome.chi2 / max(1, dome.dof)))
    gain = (dome.chi2 - fit.chi2) / (2.0 * scale)
    if not dome.converged or gain > BEYOND:
        return inf
    if gain < -BEYOND:
        return -inf
    size = hypot(*image.array.size)
    ordered = order_contact(contact, dome)
    kxx, kxy, kyy = dome.parameters[3:].tolist()
    mean, half = (kxx + kyy) / 2, hypot((kxx - kyy) / 2, kxy)
    turned = (2.0 * pi) ** 0.5 * SLOPE
    poles = -log(2.0) - sum(log(max(turned, abs(k) * size)) for k in (mean + half, mean - half))
    orders = np.maximum(ordered.probability, 1e-300) * np.exp(np.array([_LEVEL, poles, poles, poles]))
    wall, pin = is_wall(fit), _kind(fit) == "arc" and fit.region.signs[0] > 0.0
    if narrow and ordered.shape != PLANE and not wall and len(fit.region.sides) > 1:
        sharper = _wider(dome, max(image.array.size), _greatest(dome)) / (2.0 * scale)
        orders[_NO_BALL] *= exp(-min(sharper, 500.0))
    smooth = log(PRIOR["smooth"]) + ordered.evidence + ordered.volume + log(float(orders.sum()))
    if narrow and ordered.shape != PLANE and (wall or pin):
        smooth -= _wider(ordered.fit, max(image.array.size), _SUM if wall else 0.5 * _SUM) / (2.0 * scale)
    return gain + log_weight(fit, size) - smooth


def log_weight(fit: RegionFit, size: float) -> float:
    """What its kind and the volume of its unknowns add to the log evidence of an outline on a pad of a size [mm].

    More unknowns make a fit better and weigh less: by what they might have been, over what the frame leaves open.
    """
    return log(PRIOR[_kind(fit)]) + _volume(fit, size) + (_parallel(fit) if is_wall(fit) else 0.0)


def log_over(fit: RegionFit, other: RegionFit) -> float:
    """The rest of the log evidence, of an outline less that of another."""
    return (other.chi2 - fit.chi2) / (2.0 * max(1.0, min(fit.inflation, other.inflation)))


def _wider(fit: Footprint, size: float, across: Floats) -> float:
    """[chi2] by which a fit is worse with its curvature (3,) `across` of kxx, kxy, kyy held at that of the pad."""
    curvature = float(across @ fit.parameters[3:])
    variance = float(across @ fit.covariance[3:, 3:] @ across)
    if curvature * size <= 1.0 or not variance > 0.0:
        return 0.0
    return log(curvature * size) ** 2 * curvature**2 / variance


def _greatest(fit: Footprint) -> Floats:
    """(3,) of kxx, kxy, kyy in the greatest curvature."""
    kxx, kxy, kyy = fit.parameters[3:].tolist()
    turn = 0.5 * atan2(2.0 * kxy, kxx - kyy)
    return np.array([cos(turn) ** 2, sin(2.0 * turn), sin(turn) ** 2])


def _parallel(fit: RegionFit) -> float:
    """Log of how much denser two angles are, where they are, for belonging to one wall."""
    apart = float((fit.parameters[3] - fit.parameters[5] + pi / 2) % pi - pi / 2)
    c = fit.covariance
    variance = float(c[3, 3] + c[5, 5] - 2.0 * c[3, 5]) * fit.inflation + ASKEW**2
    return log(pi) - 0.5 * apart**2 / variance - 0.5 * log(2.0 * pi * variance)


def is_wall(fit: RegionFit) -> bool:
    """Whether an outline is two nearly parallel lines: smooth surfaces resemble it more than any other."""
    if len(fit.region.sides) != 2 or fit.region.signs:
        return False
    return abs(sin(float(fit.parameters[3] - fit.parameters[5]))) < PARALLEL


def _kind(fit: RegionFit) -> str:
    return _KINDS.get((len(fit.region.sides), len(fit.region.signs)), "more")


def _volume(fit: RegionFit, size: float) -> float:
    """Log of the density of the outline's unknowns before touch, times the volume that the frame leaves them."""
    return float(_volume_of(fit.parameters, fit.covariance, len(fit.region.sides), size, DECADES, _LEVEL))


@numba.njit(cache=True, error_model="numpy")
def _volume_of(p: Floats, covariance: Floats, lines: int, size: float, decades: float, level: float) -> float:
    """Log density + (log det C - log det(1 + W^1/2 C W^1/2) + m log 2 pi) / 2, W the precision before touch."""
    m = len(p)
    density = level - lines * log(pi * size)
    wide = np.zeros(m)
    wide[0] = 12.0 / 2.0**2
    for at in range(3, 3 + 2 * lines, 2):
        wide[at], wide[at + 1] = 12.0 / pi**2, 12.0 / size**2
    for at in range(3 + 2 * lines, m, 3):
        x, y, radius = p[at], p[at + 1], p[at + 2]
        density -= log(2.0 * pi * max(hypot(x, y), size) * size * decades * radius)
        wide[at], wide[at + 1], wide[at + 2] = 12.0 / size**2, 12.0 / size**2, 12.0 / (decades * radius) ** 2
    within = np.eye(m)
    for a in range(m):
        for b in range(m):
            within[a, b] += np.sqrt(wide[a] * wide[b]) * covariance[a, b]
    after, shared = _log_det(covariance), _log_det(within)
    if after == -inf:
        return -inf
    return float(density + 0.5 * (after - shared) + 0.5 * m * log(2.0 * pi))


@numba.njit(cache=True, error_model="numpy")
def _log_det(matrix: Floats) -> float:
    """Of a positive definite matrix, by Cholesky; -inf of any other."""
    m = len(matrix)
    lower = np.zeros((m, m))
    total = 0.0
    for i in range(m):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            if i > j:
                lower[i, j] = rest / lower[j, j]
            elif rest > 0.0:
                lower[i, i] = np.sqrt(rest)
                total += log(rest)
            else:
                return -inf
    return total
