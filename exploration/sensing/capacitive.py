"""How a straight edge looks to a capacitive taxel: a second physics, by the same recipe as `response.rubber`.

A face pressed `press` deep compresses the dielectric, under rubber that spreads it with a Gaussian, by
d(t) = press Phi(t / spread) at t inside the edge.  A strip of electrode there changes its capacitance as
f(d) = d / (1 - d/g) does (`curve.ParallelPlates`).  The field fringes: it decays beyond an electrode's rim as
exp(-|t|/L), so a taxel weighs what lies t away by exp(-|t|/L) / 2L (in the plane by K0(r/L) / 2 pi L^2, whose
projection on any line this is), and its electrode sums over the taxel's width:

    edge(t) = f^-1[ (box_p * exp(-|.|/L)/2L * f(d))(t) ] / press.

The 1/g favors what is deep, so the half-height crossing lies outside the edge, by more the deeper the press; the
table has it where it is (our derivation).  In units of w^2 = spread^2 + 2 L^2 + p^2/12 it goes to every detector.
"""

from functools import lru_cache

import numpy as np
from scipy.ndimage import convolve1d
from scipy.special import ndtr

from exploration.sensing.curve import ParallelPlates
from exploration.sensing.response import CELLS, REACH, Response

_FINE = 0.01  # [widths] step of the convolution


@lru_cache(maxsize=16)
def capacitive(
    spread: float, fringe: float, pitch: tuple[float, float], gap: float, press: float
) -> Response:
    """The response at a nominal press [mm]; see the module's derivation."""
    px, py = pitch
    common = spread**2 + 2 * fringe**2
    variance = np.array([common + px**2 / 12, common + py**2 / 12])
    width = float(np.sqrt(variance.mean()))
    plates = ParallelPlates(gap)
    t = np.arange(-2 * REACH, 2 * REACH, _FINE) * width
    felt = plates.signal(press * ndtr(t / spread))
    for kernel in (_fringing(fringe / (_FINE * width)), _box(np.sqrt((px**2 + py**2) / 2) / (_FINE * width))):
        felt = convolve1d(felt, kernel, mode="nearest")
    edge = plates.depth(felt) / press
    u = np.linspace(-REACH, REACH, CELLS + 1)
    line = np.interp(u * width, t, np.gradient(edge, t))
    return Response.of_line_spread(line, variance)


def _fringing(length: float) -> np.ndarray:
    """exp(-|k| / length), normalized; `length` in steps."""
    if length <= 0.0:
        return np.ones(1)
    k = np.arange(-int(12 * length) - 1, int(12 * length) + 2)
    kernel = np.exp(-np.abs(k) / length)
    return np.asarray(kernel / kernel.sum())


def _box(length: float) -> np.ndarray:
    half = max(0, round((length - 1) / 2))
    return np.full(2 * half + 1, 1.0 / (2 * half + 1))
