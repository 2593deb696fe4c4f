"""One straight edge of a frame, from taxels to polished line in one kernel; or that it takes a longer look.

The way that most frames go: one that a plane explains has no line; otherwise `edge_start` gives a first line,
`edge_polish` fits it and `edge_verdict` says whether one edge, and nothing else, explains the frame.  Whatever is
left is for votes and joint fits (see `hough`).
"""

from math import pi

import numba
import numpy as np

from exploration.sensing.contact_mask import LEAST_PLATEAU
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edge_model import ALONG, HEIGHT, RISE, UNKNOWNS
from exploration.sensing.lines.edge_polish import TARED, polish
from exploration.sensing.lines.edge_start import first_edge, plane_chi2, quiet_variance, without_outliers
from exploration.sensing.lines.edge_verdict import EXTRA, explains, freed, rim_evidence, runs_out, seen_length
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.skin_views import skin_views
from exploration.sensing.lines.smooth_rival import rival_chi2
from exploration.sensing.response import Response
from exploration.sensing.surfaces.normal_equations import invert
from primitives.arrays import Floats, Ints

NOTHING, SURE, DOUBTFUL = 0, 1, 2  # verdicts

MISFIT = 3.5  # [standard deviations of chi2]
SMOOTH = 1.5  # the same, within which a smooth surface leaves nothing to find
STRENGTH, LEAST_STRENGTH = 10.0, 3.0  # [sigma] of the step's height, alone and beside a smooth rival
HIGHEST = 1.25  # of the deepest taxel, that a plateau stands beside its edge
RUN = 5.5  # [widths] from its edge, within which a plateau that runs out may be a ridge
STEP = 0.35  # of the deepest taxel, that a plateau stands at least where a smooth rival is near
WORTH, ROUGH = (
    6.0,
    0.12,
)  # [chi2] that an edge gains over a smooth rival, and per taxel, for that is approximate
LENGTH = 1.6  # [taxels] seen
BENT = 25.0  # [chi2] that three curvatures of the plateau gain
BLURRED = 3.0  # [sigma] of the width
CLEAR = 30.0  # [chi2] by which no smooth rim explains the step


def single_edge(image: TactileImage, response: Response) -> tuple[int, Line | None]:
    """The verdict on a usable frame, and its line where that is `SURE`."""
    found = _looked(*_arguments(image, response), pi / 2)
    verdict = int(found[0])
    return verdict, _line(found) if verdict == SURE else None


def first_look(image: TactileImage, response: Response, dihedral: float = pi / 2) -> tuple[int, Line | None]:
    """The same for who weighs smooth surfaces anyway: a frame that one might explain stays `DOUBTFUL`."""
    found = _single_edge(*_arguments(image, response), pi - dihedral)
    verdict = int(found[0])
    return verdict, _line(found) if verdict == SURE else None


def _arguments(
    image: TactileImage, response: Response
) -> tuple[Floats, Floats, float, float, float, Floats, Ints, Ints, Floats, Floats]:
    array = image.array
    vx, vy = response.variance
    pad = skin_views(array.rows, array.columns, array.pitch, image.margin, (float(vx), float(vy)))
    return (
        image.depth,
        image.sigma,
        image.gain_sigma,
        *array.pitch,
        pad.views,
        pad.kinds,
        pad.first,
        pad.blurs,
        response.table,
    )


def _line(found: Floats) -> Line:
    found.flags.writeable = False
    _, angle, offset, length, strength, side, plateau = found[:7].tolist()
    return Line(
        angle,
        offset,
        found[7:11].reshape(2, 2),
        length,
        found[11:13],
        found[13:15],
        strength,
        int(side),
        plateau,
    )


@numba.njit(cache=True, error_model="numpy")
def _single_edge(
    depth: Floats,
    sigma: Floats,
    gain: float,
    px: float,
    py: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    fall: float,
) -> Floats:
    """(15,) verdict, angle, offset, length, strength, side, plateau, covariance, start and end."""
    out = np.zeros(15)
    rows, columns = depth.shape
    if rows < 2 or columns < 2:
        return out
    z = depth.copy().reshape(depth.size)
    variance = np.empty(depth.size)
    quiet = quiet_variance(z, sigma, gain, variance)
    chi2, dof = plane_chi2(z, variance, gain, columns, px, py)
    if dof < UNKNOWNS or chi2 < dof + MISFIT * np.sqrt(2.0 * dof):
        return out
    out[0], out[1] = DOUBTFUL, np.inf
    p = np.zeros(UNKNOWNS)
    calm = without_outliers(z, variance, rows, columns)
    side = first_edge(calm, variance, rows, columns, px, py, blurs[0], p)
    if side == 0.0:
        return out
    design = np.empty((UNKNOWNS + EXTRA + 1, len(z)))
    normal, rhs = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    chi2, count = polish(
        z, variance, gain, quiet, views, kinds, first, blurs, table, p, side, fall, design, normal, rhs
    )
    dof = count - UNKNOWNS
    if chi2 < 0.0 or dof < 1 or chi2 > dof + MISFIT * np.sqrt(2.0 * dof):
        return out
    if not explains(z, quiet, design, rows, columns):
        return out
    ok, covariance = invert(normal)
    low, high = seen_length(p, side, 0.5 * columns * px, 0.5 * rows * py, LEAST_PLATEAU * quiet)
    if not ok or high - low < LENGTH * min(px, py):
        return out
    middle = 0.5 * (low + high)
    spread = covariance[HEIGHT, HEIGHT] + middle * (
        2.0 * covariance[HEIGHT, ALONG] + middle * covariance[ALONG, ALONG]
    )
    inflation = max(1.0, chi2 / dof)
    plateau = p[HEIGHT] + middle * p[ALONG]
    strength = plateau / np.sqrt(spread * inflation)
    if strength < LEAST_STRENGTH:
        return out
    low_step = plateau < STEP * calm.max()
    if not low_step:
        out[1] = chi2
    width = np.sqrt(blurs[0, 0] * np.sin(p[0]) ** 2 + blurs[0, 1] * np.cos(p[0]) ** 2)
    if plateau > HIGHEST * calm.max() or plateau < -RUN * width * p[RISE]:
        return out
    freed(views, kinds, first, blurs, table, p, side, middle, design)
    bent, blurred, clear = rim_evidence(design, p, side, middle, width, 1.0 / (TARED * quiet) ** 2)
    if bent > BENT or abs(blurred) > BLURRED:
        return out
    if strength < STRENGTH or clear < CLEAR or runs_out(p, side, 0.5 * columns * px, 0.5 * rows * py):
        if low_step:
            return out
        enough = chi2 + (WORTH + ROUGH * count) * inflation
        rival = rival_chi2(z, calm, variance, gain, views, kinds, first, blurs, table, enough)
        if rival < enough:
            return out
    out[0] = SURE
    write_line(out, p, side, low, high, strength, plateau, covariance, inflation)
    return out


@numba.njit(cache=True, error_model="numpy")
def _looked(
    depth: Floats,
    sigma: Floats,
    gain: float,
    px: float,
    py: float,
    views: Floats,
    kinds: Ints,
    first: Ints,
    blurs: Floats,
    table: Floats,
    fall: float,
) -> Floats:
    """`_single_edge`; nothing where an edge is doubtful and a smooth surface explains the frame as well."""
    out: Floats = _single_edge(depth, sigma, gain, px, py, views, kinds, first, blurs, table, fall)
    if out[0] != DOUBTFUL:
        return out
    rows, columns = depth.shape
    z = depth.copy().reshape(depth.size)
    variance = np.empty(depth.size)
    quiet_variance(z, sigma, gain, variance)
    calm = without_outliers(z, variance, rows, columns)
    dof = np.isfinite(variance).sum() - UNKNOWNS
    enough = dof + SMOOTH * np.sqrt(2.0 * max(1, dof))
    rival = rival_chi2(z, calm, variance, gain, views, kinds, first, blurs, table, enough)
    if rival < min(enough, out[1]):
        out[0] = NOTHING
    return out


@numba.njit(cache=True, error_model="numpy")
def write_line(
    out: Floats,
    p: Floats,
    side: float,
    low: float,
    high: float,
    strength: float,
    plateau: float,
    covariance: Floats,
    inflation: float,
) -> None:
    """Fill all of a line but the verdict, its angle in [0, pi)."""
    turns = np.floor(p[0] / np.pi)
    angle = max(0.0, p[0] - turns * np.pi)
    sign = 1.0 if turns % 2.0 == 0.0 else -1.0
    if angle >= np.pi:
        angle, sign = 0.0, -sign
    offset = sign * p[1]
    if sign < 0.0:
        low, high = -high, -low
    ca, sa = np.cos(angle), np.sin(angle)
    out[1], out[2], out[3], out[4], out[5], out[6] = angle, offset, high - low, strength, sign * side, plateau
    out[7], out[10] = covariance[0, 0] * inflation, covariance[1, 1] * inflation
    out[8] = sign * covariance[0, 1] * inflation
    out[9] = out[8]
    out[11], out[12] = low * ca - offset * sa, low * sa + offset * ca
    out[13], out[14] = high * ca - offset * sa, high * sa + offset * ca
