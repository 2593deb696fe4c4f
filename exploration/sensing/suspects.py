"""Taxels that contradict their neighbors: dead or stuck without telling.

Each is compared with its prediction from the 5 x 5 around it (`neighbors`).  With sigma the taxels' noise, the
difference has variance sigma_0^2 + sum_k w_k^2 sigma_k^2; a taxel is suspect where it differs by more than a
normal deviate does with probability `FALSE_ALARM`, and by more than any edge or corner could explain (`slack`).
The worst goes first and is filled in from the rest, so that it accuses no neighbor.  Noise that turns out higher
than the calibration says (the median of the differences that no press explains tells) raises the bar.

A dead taxel where nothing is pressed reads what it should, and does no harm.
"""

from dataclasses import replace
from functools import lru_cache

import numba
import numpy as np
from scipy.special import ndtri

from exploration.sensing.contact_mask import usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.neighbors import NOTHING, Neighbors, neighbors
from exploration.sensing.response import response_of
from primitives.arrays import Bools, Floats, Ints, frozen

FALSE_ALARM = 1e-4  # probability, per taxel
DOUBT = float(-ndtri(FALSE_ALARM / 2))  # [sigma]
FAINT = 2.0  # [sigma] what a taxel that feels nothing at most reads
INNER = 0.5  # of the greatest error that a press causes inside the pad: what it mostly causes at most
MOST = 0.25  # of the taxels; where more contradict each other, no majority is left to trust
_MAD = 0.6744897501960817  # median of |normal deviate|
_RIM = 2  # taxels of nothing laid round the frame

Judges = tuple[
    Floats, Floats, Floats, Ints, Ints
]  # weights, slack, gain; classes of the rows, of the columns


def judges(image: TactileImage) -> Judges:
    """What `mark` needs for frames like this one; cached by layout and blur."""
    return _judges(response_of(image).mean_width, image.array.pitch, *image.array.shape)


@lru_cache(maxsize=32)
def _judges(width: float, pitch: tuple[float, float], rows: int, columns: int) -> Judges:
    known = neighbors(width, pitch)
    return known.weights, known.slack, known.gain, Neighbors.classes(rows), Neighbors.classes(columns)


def suspects(image: TactileImage) -> Bools:
    """(rows, columns) living taxels that contradict their neighbors; none where too many do."""
    if not usable(image):
        return frozen(np.zeros(image.array.shape), np.bool_)
    marked: Bools = mark(image.depth, image.sigma, *judges(image))
    marked.flags.writeable = False
    return marked


def unsuspected(image: TactileImage) -> TactileImage:
    """The image with suspects left out, as dead taxels are; itself where there are none."""
    marked = suspects(image)
    return replace(image, sigma=frozen(np.where(marked, np.inf, image.sigma))) if marked.any() else image


@numba.njit(cache=True, error_model="numpy")
def mark(
    depth: Floats,
    sigma: Floats,
    weights: Floats,
    slack: Floats,
    gain: Floats,
    row_class: Ints,
    column_class: Ints,
) -> Bools:
    """See `suspects`; the image must be usable."""
    rows, columns = depth.shape
    marked = np.zeros((rows, columns), dtype=np.bool_)
    z, s = _framed(depth, sigma)
    apart = np.zeros((rows, columns))
    noisy, living, worst = 0, 0, 0.0
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] == np.inf:
                continue
            r, c = row_class[i], column_class[j]
            difference = abs(z[i + 2, j + 2] - _predicted(z, weights[r, c], i, j)) / s[i + 2, j + 2]
            living += 1
            if difference > _MAD * gain[r, c]:
                noisy += 1
            if difference > DOUBT:
                apart[i, j] = _contradiction(z, s, weights[r, c], slack[r, c], 1.0, i, j)
                worst = max(worst, apart[i, j])
    if worst == 0.0:
        return marked
    scale = 1.0
    if noisy > 0.6 * living:
        scale = _scale(z, s, sigma, weights, slack, gain, row_class, column_class)
    for _ in range(int(MOST * rows * columns)):
        place = int(np.argmax(apart))
        i, j = place // columns, place % columns
        if apart[i, j] == 0.0:
            return marked
        r, c = row_class[i], column_class[j]
        apart[i, j] = 0.0
        if scale > 1.0 and _contradiction(z, s, weights[r, c], slack[r, c], scale, i, j) == 0.0:
            continue
        marked[i, j] = True
        z[i + 2, j + 2] = _predicted(z, weights[r, c], i, j)
        variance, deepest = _around(z, s, weights[r, c], i, j)
        s[i + 2, j + 2] = np.sqrt(variance) + slack[r, c, 0] * deepest
        for a in range(max(0, i - 2), min(rows, i + 3)):
            for b in range(max(0, j - 2), min(columns, j + 3)):
                r, c = row_class[a], column_class[b]
                if sigma[a, b] == np.inf or marked[a, b]:
                    apart[a, b] = 0.0
                else:
                    apart[a, b] = _contradiction(z, s, weights[r, c], slack[r, c], scale, a, b)
    marked[:] = False
    return marked


@numba.njit(cache=True, error_model="numpy")
def _framed(depth: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """Depth and sigma in a rim of zeros, dead taxels at the mean of those beside them, as sure as they agree."""
    rows, columns = depth.shape
    z = np.zeros((rows + 2 * _RIM, columns + 2 * _RIM))
    s = np.zeros((rows + 2 * _RIM, columns + 2 * _RIM))
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] != np.inf:
                z[i + 2, j + 2], s[i + 2, j + 2] = depth[i, j], sigma[i, j]
                continue
            total, count, low, high, least = 0.0, 0, np.inf, -np.inf, 0.0
            for a in range(max(0, i - 1), min(rows, i + 2)):
                for b in range(max(0, j - 1), min(columns, j + 2)):
                    if sigma[a, b] != np.inf:
                        total += depth[a, b]
                        count += 1
                        low, high = min(low, depth[a, b]), max(high, depth[a, b])
                        least = max(least, sigma[a, b])
            z[i + 2, j + 2] = total / count if count else 0.0
            s[i + 2, j + 2] = least + 0.5 * (high - low) if count else 1e3
    return z, s


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"}, inline="always")
def _predicted(z: Floats, w: Floats, i: int, j: int) -> float:
    """What taxel (i, j) should read, by its own (25,) weights."""
    total = 0.0
    for a in range(5):
        for b in range(5):
            total += w[5 * a + b] * z[i + a, j + b]
    return total


@numba.njit(cache=True, error_model="numpy")
def _around(z: Floats, s: Floats, w: Floats, i: int, j: int) -> tuple[float, float]:
    """Variance of the prediction, and the deepest of the 5 x 5."""
    variance, deepest = 0.0, 0.0
    for a in range(5):
        for b in range(5):
            variance += (w[5 * a + b] * s[i + a, j + b]) ** 2
            deepest = max(deepest, abs(z[i + a, j + b]))
    return variance, deepest


@numba.njit(cache=True, error_model="numpy")
def _range(z: Floats, i: int, j: int) -> float:
    """What the 3 x 3 range over, within the frame."""
    low, high = np.inf, -np.inf
    for a in range(max(2, i + 1), min(z.shape[0] - 2, i + 4)):
        for b in range(max(2, j + 1), min(z.shape[1] - 2, j + 4)):
            low, high = min(low, z[a, b]), max(high, z[a, b])
    return high - low


@numba.njit(cache=True, error_model="numpy")
def _contradiction(z: Floats, s: Floats, w: Floats, slack: Floats, scale: float, i: int, j: int) -> float:
    """[mm] by which a taxel differs from its prediction, where that is more than it may; 0 elsewhere."""
    reading, noise = z[i + 2, j + 2], s[i + 2, j + 2]
    difference = abs(reading - _predicted(z, w, i, j))
    variance, deepest = _around(z, s, w, i, j)
    share = slack[1] if abs(reading) < FAINT * noise + NOTHING * deepest else slack[0]
    bar = DOUBT * scale * np.sqrt(variance + noise**2) + share * deepest
    return difference if difference > bar else 0.0


@numba.njit(cache=True, error_model="numpy")
def _scale(
    z: Floats,
    s: Floats,
    sigma: Floats,
    weights: Floats,
    slack: Floats,
    gain: Floats,
    row_class: Ints,
    column_class: Ints,
) -> float:
    """How much noisier the frame is than it says; at least 1.  Where neighbors agree no press misleads them."""
    rows, columns = sigma.shape
    ratios = np.empty(rows * columns)
    n = 0
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] != np.inf:
                r, c = row_class[i], column_class[j]
                difference = abs(z[i + 2, j + 2] - _predicted(z, weights[r, c], i, j))
                misled = INNER * slack[8, 8, 0] * _range(z, i, j)
                ratios[n] = np.sqrt(max(0.0, difference**2 - misled**2)) / (gain[r, c] * s[i + 2, j + 2])
                n += 1
    return max(1.0, float(np.median(ratios[:n])) / _MAD)
